//! A Gauss-Newton step from the reduced normal equations of all layers.

use super::Illumination;
use super::layer::LayerEquations;
use crate::binary;
use crate::covariance::Covariance;
use crate::edge::Blur;
use crate::elimination::{Equations, SOLUTION_BITS};
use crate::formats::{Column, Obliquity};
use crate::homography::Homography;

/// Extra bits with which layers are added.
const SPARE_BITS: i32 = 10;

/// The solved equations in `a`, `s`, `k` and σ, their right side last.
#[derive(Clone, Debug)]
pub(super) struct Step {
    equations: Equations<5>,
    changes: [Change; 4],
    /// The sum of squares that the linearised model keeps after the layers' own steps alone, and after the whole step, in
    /// units of the scaled residuals' diagonal.
    kept: [i64; 2],
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
    /// Solves the sum of the layers' equations, at a blur that the step keeps in its range (`FIT-8`, `FIT-10`).
    ///
    /// `None` unless the equations are positive definite.
    #[inline(never)] // its stack is not the others'
    pub(super) fn solve(layers: &[LayerEquations], blur: Column) -> Option<Self> {
        let mut equations = sum(layers);
        let without_common = i64::from(equations.entry(4, 4));
        for pivot in 0..4 {
            equations.eliminate(pivot)?;
        }
        let least = i64::from(equations.entry(4, 4));
        let mut solution = [0; 5];
        equations.substitute(3, &mut solution);
        let [a, s, k, sigma, right] = equations.exponents;
        let exponent = |column: i32| right - column - i32::from(SOLUTION_BITS);
        let spread = Change { value: solution[3], exponent: exponent(sigma) }.scaled(20);
        let limited = limited(blur, spread);
        let free = solution[3];
        if limited != spread {
            solution[3] = binary::scaled(limited, -20 - exponent(sigma)).clamp(-(1 << 32), 1 << 32);
        }
        for pivot in (0..3).rev() {
            equations.substitute(pivot, &mut solution);
        }
        let missed = free - solution[3];
        let square = binary::product(missed, missed, SOLUTION_BITS);
        let by_blur = binary::product(square, i64::from(equations.entry(3, 3)), SOLUTION_BITS);
        let mut changes = [Change::default(); 4];
        for ((change, value), column) in changes.iter_mut().zip(solution).zip([a, s, k, sigma]) {
            *change = Change { value, exponent: exponent(column) };
        }
        Some(Self { equations, changes, kept: [without_common, least.saturating_add(by_blur)] })
    }

    /// Whether the fit has converged with this step (`FIT-11`); `squares` has 16 fraction bits.
    ///
    /// What is kept is off by at most 16 units of the squares' diagonal, which is 2^28 at least; the limit is
    /// `2^28/(225 (n - p))`, 932 units for the most pixels.
    pub(super) fn is_last(&self, squares: i64, degrees_of_freedom: u16, illumination: Illumination) -> bool {
        let [.., right] = self.equations.exponents;
        let degrees_of_freedom = i64::from(degrees_of_freedom);
        let units = |squares: i64| binary::scaled(squares, -16 - 2 * right);
        let limit = units(squares.max(least_squares(degrees_of_freedom)));
        let least = |from: i64, to: i64, part: i64| {
            from.saturating_sub(to).saturating_mul(part.saturating_mul(degrees_of_freedom)) <= limit
        };
        let [without_common, kept] = self.kept;
        match illumination {
            Illumination::Even => least(units(squares), kept, 225),
            Illumination::Step => least(units(squares), without_common, 16) && least(without_common, kept, 225),
        }
    }

    /// The step, shortened as a whole (`FIT-9`); `origin` is that of its columns relative to the principal column.
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

/// The step of σ, in 2^-20 px, that stays within `FIT-10`'s range.
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
