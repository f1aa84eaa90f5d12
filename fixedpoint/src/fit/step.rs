//! A Gauss-Newton step from the reduced normal equations of all layers.

use super::layer::LayerEquations;
use crate::binary;
use crate::covariance::Covariance;
use crate::edge::Blur;
use crate::elimination::{Equations, SOLUTION_BITS};
use crate::formats::{Column, Obliquity};
use crate::homography::Homography;

/// Extra bits with which layers are added.
const SPARE_BITS: i32 = 10;

/// What a squared contrast adds to the diagonal for σ (`FIT-8`): 2^-6.
const DAMPING_BITS: i32 = 6;

/// The solved equations in `a`, `s`, `k` and σ, their right side last.
#[derive(Clone, Debug)]
pub(super) struct Step {
    equations: Equations<5>,
    changes: [Change; 4],
    /// What the linearised model keeps of `FIT-6`'s sum after the step, in units of the scaled residuals' diagonal.
    kept: i64,
}

/// A number and its power of two: `value · 2^exponent`, of px or of `k`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Change {
    value: i64,
    exponent: i32,
}

impl Change {
    /// The change times `2^exponent`, rounded.
    pub(super) fn scaled(self, exponent: i32) -> i64 {
        binary::scaled(self.value, self.exponent.saturating_add(exponent))
    }
}

impl Step {
    /// Solves the sum of the layers' equations, at a blur that the step keeps in its range (`FIT-8`, `FIT-10`); `contrast` is the
    /// sum of the layers' squared gains at the start, squared grey levels.
    ///
    /// `None` unless the equations are positive definite.
    #[inline(never)] // its stack is not the others'
    pub(super) fn solve(layers: &[LayerEquations], contrast: u32, blur: Column) -> Option<Self> {
        let mut equations = sum(layers);
        for pivot in 0..4 {
            equations.eliminate(pivot)?;
        }
        let least = i64::from(equations.entry(4, 4));
        let mut solution = [0; 5];
        equations.substitute(3, &mut solution);
        let [a, s, k, sigma, right] = equations.exponents;
        let exponent = |column: i32| right - column - i32::from(SOLUTION_BITS);
        let free = solution[3];
        let weight = i64::from(equations.entry(3, 3));
        solution[3] = damped(free, weight, binary::scaled(i64::from(contrast), -DAMPING_BITS - 2 * sigma));
        let spread = Change { value: solution[3], exponent: exponent(sigma) }.scaled(20);
        let limited = limited(blur, spread);
        if limited != spread {
            solution[3] = binary::scaled(limited, -20 - exponent(sigma)).clamp(-(1 << 32), 1 << 32);
        }
        for pivot in (0..3).rev() {
            equations.substitute(pivot, &mut solution);
        }
        let missed = free - solution[3];
        let square = binary::product(missed, missed, SOLUTION_BITS);
        let by_blur = binary::product(square, weight, SOLUTION_BITS);
        let mut changes = [Change::default(); 4];
        for ((change, value), column) in changes.iter_mut().zip(solution).zip([a, s, k, sigma]) {
            *change = Change { value, exponent: exponent(column) };
        }
        Some(Self { equations, changes, kept: least.saturating_add(by_blur) })
    }

    /// Whether the fit has converged with this step (`FIT-11`); `squares` of the pixels and `prior`, what `FIT-6` adds to them,
    /// have 16 fraction bits.
    ///
    /// What is kept is off by at most 16 units of the squares' diagonal, which is 2^28 at least; the limit is
    /// `2^28/(225 (n - p))`, 932 units for the most pixels.
    //= reference/SPEC.md#fit
    //# - **FIT-11** With `s² = max(SSE/(n - p), 1/4)`, SSE the sum over the pixels alone, n pixels, `p = 4 + 4` per
    //# layer, the fit MUST have converged when a step, before it is shortened, lowers FIT-6's sum of the linearised
    //# model by at most `s²/225`; that step is the last one.
    pub(super) fn is_last(&self, squares: i64, prior: i64, degrees_of_freedom: u16) -> bool {
        let [.., right] = self.equations.exponents;
        let degrees_of_freedom = i64::from(degrees_of_freedom);
        let units = |squares: i64| binary::scaled(squares, -16 - 2 * right);
        let limit = units(squares.max(least_squares(degrees_of_freedom)));
        let decrease = units(squares.saturating_add(prior)).saturating_sub(self.kept);
        decrease.saturating_mul(degrees_of_freedom.saturating_mul(225)) <= limit
    }

    /// The step, shortened as a whole (`FIT-9`); `origin` is that of its columns relative to the principal column.
    //= reference/SPEC.md#fit
    //# - **FIT-9** A step MUST be shortened as a whole until `|Δa|` and `|Δs|` are at most 1 px, `|Δk|` at most 0.1 and
    //# `|Δσ|` at most 0.2 px, before the layers' own steps follow from it.
    pub(super) fn shortened(&self, origin: Column) -> Shortened {
        let [a, s, k, sigma] = self.changes;
        let turned = binary::product(i64::from(origin.to_bits()), k.scaled(30), 30);
        let lengths = [
            (a.scaled(20), 1 << 20),
            (s.scaled(20).saturating_add(turned), 1 << 20),
            (k.scaled(30), (1 << 30) / 10),
            (sigma.scaled(20), (1 << 20) / 5),
        ];
        let mut share = 1 << 16;
        for (length, limit) in lengths {
            let length = length.saturating_abs();
            if length > limit {
                share = share.min((limit << 16).checked_div(length).unwrap_or(0));
            }
        }
        Shortened { changes: self.changes.map(|change| Change { value: (change.value * share) >> 16, ..change }) }
    }

    /// `variance`, with 16 fraction bits, times the inverse's block (`FIT-14`), for columns from the same origin.
    pub(super) fn covariance(&self, variance: u32) -> Covariance {
        let entry = |i: usize, j: usize| {
            let [first, second] = [i, j].map(|i| self.equations.exponents.get(i).copied().unwrap_or_default());
            let product = binary::product(self.equations.inverse(i, j, 4), i64::from(variance), 0);
            binary::scaled(product, -16 - first - second)
        };
        Covariance {
            aa: entry(0, 0),
            as_: entry(0, 1),
            ak: entry(0, 2),
            ss: entry(1, 1),
            sk: entry(1, 2),
            kk: entry(2, 2),
        }
    }
}

/// The sum of squares, with 16 fraction bits, of pixels of the least variance, 1/4 (`FIT-11`).
pub(super) fn least_squares(degrees_of_freedom: i64) -> i64 {
    degrees_of_freedom << 14
}

/// A step of σ (`FIT-8`), at most 2^32 units, of equations with `damping` added to their `weight`, what is left for σ on the
/// diagonal.
fn damped(step: i64, weight: i64, damping: i64) -> i64 {
    let sum = weight.saturating_add(damping.max(0));
    step.saturating_mul(weight).checked_div(sum).unwrap_or(0)
}

/// The step of σ, in 2^-20 px, that stays within `FIT-10`'s range.
//= reference/SPEC.md#fit
//# - **FIT-10** A step that would take σ out of 0.2 to 1.2 px MUST, before FIT-9, be the one that takes it to that
//# limit and solves the equations for `a`, `s` and `k` there.
fn limited(blur: Column, spread: i64) -> i64 {
    let blur = i64::from(blur.to_bits());
    let (smallest, largest) = (i64::from(Blur::SMALLEST.to_bits()), i64::from(Blur::LARGEST.to_bits()));
    spread.clamp(smallest - blur, largest - blur)
}

/// The sum of the layers' reduced equations.
#[inline(never)] // likewise
fn sum(layers: &[LayerEquations]) -> Equations<5> {
    let mut highest = [i32::MIN; 5];
    for layer in layers {
        let [_, _, _, _, common @ ..] = layer.equations.exponents;
        for (high, exponent) in highest.iter_mut().zip(common) {
            *high = exponent.max(*high);
        }
    }
    let entry = |i: usize, j: usize| {
        let share = |layer: &LayerEquations| {
            let over = |i: usize| {
                let exponent = layer.equations.exponents.get(i + 4).copied().unwrap_or_default();
                exponent - highest.get(i).copied().unwrap_or_default()
            };
            let value = i64::from(layer.equations.entry(i + 4, j + 4));
            binary::scaled(value, over(i) + over(j) + 2 * SPARE_BITS)
        };
        layers.iter().map(share).sum()
    };
    let mut equations = Equations::scaled(entry);
    for (exponent, high) in equations.exponents.iter_mut().zip(highest) {
        *exponent += high - SPARE_BITS;
    }
    equations
}

/// A step as it is taken.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shortened {
    /// Of `a`, `s`, `k` and σ.
    pub(super) changes: [Change; 4],
}

impl Shortened {
    /// The change of σ in px.
    pub(super) fn spread(&self) -> Column {
        let [.., sigma] = self.changes;
        let limited = sigma.scaled(20).clamp(-(1 << 30), 1 << 30);
        Column::from_bits(i32::try_from(limited).unwrap_or_default())
    }

    /// A homography after the step; `None` outside of the formats.
    pub(super) fn applied(&self, homography: &Homography) -> Option<Homography> {
        let [a, s, k, _] = self.changes;
        let sum = |value: i32, change: i64| i32::try_from(i64::from(value).saturating_add(change)).ok();
        Some(Homography {
            a: Column::from_bits(sum(homography.a.to_bits(), a.scaled(20))?),
            s: Column::from_bits(sum(homography.s.to_bits(), s.scaled(20))?),
            k: Obliquity::from_bits(sum(homography.k.to_bits(), k.scaled(30))?),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::*;
    use super::{Change, Obliquity};
    use crate::elimination::Equations;

    /// Where a step leads that changes nothing, from a homography relative to the middle of a line of the reference camera.
    fn stays(a: i32, s: i32, k: i32) -> bool {
        let line: std::vec::Vec<u8> = (0..480_u16).map(|pixel| if pixel % 8 < 4 { 20 } else { 200 }).collect();
        let layer = FitLayer { line: &line, first_pixel: 200, last_pixel: 279, stripes: 0b1010 };
        let start = Start::at(&Homography { a: Column::ZERO, s: Column::from_num(40), k: Obliquity::ZERO });
        let camera = Camera::new(480, Column::from_num(239), crate::formats::FocalLength::from_num(640)).unwrap();
        let plan = Plan::Code(Illumination::Even);
        let mut state = State::start(&[layer], &start, &camera, Format::Paper, plan).unwrap();
        assert_eq!((state.origin, state.contrast), (Column::ZERO, 180 * 180));
        state.homography = Homography { a: Column::from_bits(a), s: Column::from_bits(s), k: Obliquity::from_bits(k) };
        state.advance(&step([Change::default(); 4]), &[]).is_some()
    }

    /// `FIT-13`: `|k| > 3/4`, `s < N/4`, here 5 px, and `s <= a k` are refused.
    #[test]
    fn the_bounds_of_a_fit_belong_to_it() {
        let (five, forty, three_quarters) = (5 << 20, 40 << 20, 3 << 28);
        assert!(stays(0, five, 0) && stays(0, forty, three_quarters) && stays(0, forty, -three_quarters));
        assert!(!stays(0, five - 1, 0) && !stays(0, forty, three_quarters + 1));
        assert!(!stays(0, forty, -three_quarters - 1));
        for half in [1_i32 << 29, -1 << 29] {
            let eighty = 80 * (1 << 20) * half.signum();
            assert!(stays(eighty - half.signum(), forty, half) && !stays(eighty, forty, half));
        }
    }

    fn step(changes: [Change; 4]) -> Step {
        Step { equations: Equations::empty(), changes, kept: 0 }
    }

    /// `FIT-9`: 1 px, 1 px, 0.1 and 0.2 px, in units of 2^-20 px and, of `k`, 2^-30.
    #[test]
    fn a_step_is_shortened_as_a_whole() {
        let shortened = |a: i64, s: i64, k: i64, sigma: i64| {
            let change = |value: i64, bits: i32| Change { value: value << 10, exponent: -bits - 10 };
            let step = step([change(a, 20), change(s, 20), change(k, 30), change(sigma, 20)]);
            let [a, s, k, sigma] = step.shortened(Column::ZERO).changes;
            [a.scaled(20), s.scaled(20), k.scaled(30), sigma.scaled(20)]
        };
        let (px, tenth, fifth) = (1 << 20, (1 << 30) / 10, (1 << 20) / 5);
        assert_eq!(shortened(px, -px, -tenth, fifth), [px, -px, -tenth, fifth]);
        for longer in [[2 * px, 0, 0, 4], [0, -2 * px, 0, 4], [0, 0, 2 * tenth, 4], [8, 0, 0, -2 * fifth]] {
            let [a, s, k, sigma] = longer;
            assert_eq!(shortened(a, s, k, sigma), longer.map(|change| change / 2), "{longer:?}");
        }
        assert_eq!(shortened(4 * px, 2 * px, 0, 0), [px, px / 2, 0, 0]);
    }

    /// `FIT-10`: σ stays within 0.2 and 1.2 px.
    #[test]
    fn blur_stays_in_its_range() {
        let half = Column::from_num(0.5);
        let to = |blur: Column| i64::from((blur - half).to_bits());
        assert_eq!((super::limited(half, 7), super::limited(half, -7)), (7, -7));
        assert_eq!(super::limited(half, 1 << 30), to(Blur::LARGEST));
        assert_eq!(super::limited(half, -(1 << 30)), to(Blur::SMALLEST));
    }

    /// `FIT-8`: what is added halves the step where it is as much as what is there, and leaves nothing where it is without end.
    #[test]
    fn steps_of_the_blur_are_damped() {
        assert_eq!((super::damped(100, 3, 1), super::damped(-100, 1 << 30, 1 << 30)), (75, -50));
        assert_eq!((super::damped(100, 3, 0), super::damped(1 << 32, 1 << 30, 0)), (100, 1 << 32));
        assert_eq!((super::damped(1 << 32, 1 << 30, i64::MAX), super::damped(1, 0, 0)), (0, 0));
    }

    /// `FIT-8`: of equations in which `a` and σ share half of what they know, 3/4 is left for σ alone; a contrast of as much, 64
    /// times, halves the step of σ, and `a` is what solves its own equation there.
    #[test]
    fn the_step_of_the_blur_is_damped_by_the_contrast() {
        const ONE: i64 = 1 << 20;
        let (a, sigma, right) = (4, 7, 8);
        let mut equations = Equations::<9>::scaled(|i, j| match (i, j) {
            (i, j) if i == j => ONE,
            (i, j) if (i, j) == (a, sigma) => ONE / 2,
            (i, j) if (i, j) == (a, right) => ONE / 10,
            (i, j) if (i, j) == (sigma, right) => 11 * ONE / 100,
            _ => 0,
        });
        (0..4).for_each(|own| equations.eliminate(own).unwrap());
        let layer = LayerEquations { equations, squares: 0, prior: 0 };
        let taken = |contrast: u32| {
            let step = super::Step::solve(std::slice::from_ref(&layer), contrast, Column::from_num(0.6)).unwrap();
            step.changes.map(|change| change.scaled(20) as f64 / 2_f64.powi(20))
        };
        let near = |found: [f64; 4], expected: [f64; 4]| {
            found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-5)
        };
        // (0.11 - 0.1/2)/(3/4) is 0.08.
        assert!(near(taken(0), [0.06, 0.0, 0.0, 0.08]), "{:?}", taken(0));
        assert!(near(taken(48 << 20), [0.08, 0.0, 0.0, 0.04]), "{:?}", taken(48 << 20));
    }

    /// What a step changes, and what no format holds.
    #[test]
    fn a_step_is_added() {
        let px = |value: i64| Change { value, exponent: 0 };
        let taken = |changes| super::Shortened { changes };
        let before = Homography { a: Column::from_num(3), s: Column::from_num(40), k: Obliquity::from_num(0.25) };
        let after = Homography { a: Column::from_num(1), s: Column::from_num(45), k: Obliquity::from_num(-0.75) };
        let step = taken([px(-2), px(5), px(-1), px(1)]);
        assert_eq!((step.applied(&before), step.spread()), (Some(after), Column::from_num(1)));
        assert_eq!(taken([px(1 << 20), px(0), px(0), px(0)]).applied(&before), None);
        assert_eq!(taken([px(0), px(0), px(0), px(1 << 40)]).spread(), Column::from_num(1024));
        assert_eq!(taken([px(0), px(0), px(0), px(-1 << 40)]).spread(), Column::from_num(-1024));
    }

    /// `FIT-11`: a step that lowers pixels and prior together by at most `s²/225`, of 2250 by the pixels alone by 10.
    #[test]
    fn a_step_is_the_last_that_lowers_little() {
        let last = |kept: i64, degrees_of_freedom: u16| {
            let step = super::Step { kept, ..step([Change::default(); 4]) };
            step.is_last(2250 << 16, 6 << 16, degrees_of_freedom)
        };
        assert!(last(2256 - 10, 1) && !last(2256 - 11, 1));
        assert!(last(2256 - 5, 2) && !last(2256 - 6, 2));
    }

    /// `FIT-11`: `s²` is at least 1/4, here of 40 degrees of freedom and with 16 fraction bits.
    #[test]
    fn rounding_leaves_a_quarter() {
        assert_eq!(super::least_squares(40), 10 << 16);
    }
}
