//! One observation: linearised again and again, and used for a state or not.

use super::root::{Correction, NORMAL_BITS, ROOT_BITS, Root};
use crate::binary::{product, scaled, size};
use crate::inverse::Inverse;
use crate::motion::{STATES, State};
use crate::observation::{DERIVATIVE_BITS, Linearised, RESIDUAL_BITS};

/// The most linearisations (`FILTER-2`).
const LINEARISATIONS: u8 = 10;

/// 2e-5 m and 2e-5 rad with 40 fraction bits (`FILTER-2`).
const SETTLED: u64 = 21_990_233;

/// The largest NIS that counts as agreement, 16.266 with 20 fraction bits (`FILTER-4`).
const GATE: i64 = 17_056_137;

/// The state after an observation that agrees with it (`FILTER-2` to `FILTER-5`); `None` if the observation is not to be used.
///
/// The three numbers of a sighting, normalised by the Cholesky root of their noise, are observed one after the other: the
/// same estimate, covariance and NIS as all at once.
//= reference/SPEC.md#filter
//# - **FILTER-2** An observation MUST be linearised at the estimate and again towards where that leads (FILTER-9),
//# until the position moves by less than 2e-5 m along x and y together and the heading by less than 2e-5 rad, 10 times
//# at most.
//= reference/SPEC.md#filter
//# - **FILTER-4** An observation MUST be used if its linearisations end before or with the tenth, if its NIS, `νᵀ S⁻¹
//# ν` at the last one, is at most 16.266 *(1 in 1,000 of a chi-square of three)*, and if its landmark's centre is at
//# least 2^-8 m in front of the camera wherever it is linearised.
//= reference/SPEC.md#filter
//# - **FILTER-5** The covariance MUST become `(I - K H) P (I - K H)ᵀ + K R Kᵀ`, or what is the same without rounding.
pub(super) fn updated(prior: &State, linearise: impl Fn(&State) -> Option<Linearised>) -> Option<State> {
    let before = Root::of(&prior.covariance, prior.covariance.uncertain());
    let mut root = before;
    let mut correction = Correction::default();
    let mut settled = false;
    let mut from = correction.moved;
    let mut pace = Pace { share: WHOLE, way: None };
    for _ in 0..LINEARISATIONS {
        let normal = Normal::of(&linearise(&prior.moved(from))?, from)?;
        root = before;
        correction = Correction::default();
        for (by, seen) in normal.by_pose.iter().zip(normal.residual) {
            root.observe(by, seen, &mut correction);
        }
        let [x, y, turn, ..] = distances(correction.moved, from);
        settled = x.saturating_add(y) < SETTLED && turn < SETTLED;
        if settled {
            break;
        }
        from = pace.next(from, correction.moved);
    }
    if !settled || correction.nis > GATE {
        return None;
    }
    Some(State { covariance: root.covariance(), ..prior.moved(correction.moved) })
}

/// The whole of a way, with [`SHARE_BITS`].
const WHOLE: i64 = 1 << SHARE_BITS;
const SHARE_BITS: u8 = 28;

/// How much of the way to where a linearisation leads the next one goes (`FILTER-9`).
#[derive(Clone, Copy, Debug)]
struct Pace {
    /// [`SHARE_BITS`].
    share: i64,
    /// The way before, of x, y and the heading.
    way: Option<[i64; 3]>,
}

impl Pace {
    /// The next place to linearise at, after one that leads from a place to another.
    //= reference/SPEC.md#filter
    //# - **FILTER-9** Each further linearisation MUST be the share `ω` of the way from the one before to where that
    //# leads, `ω` being 1 at first and then `ω/(1 - r)` within 1/4 and 4, or 4 if `r >= 1`, with `r = d·d'/(d'·d')` of
    //# this way `d` and the way before, `d'`, in metres and radians.
    fn next(&mut self, from: [i64; STATES], to: [i64; STATES]) -> [i64; STATES] {
        let mut next = from;
        let way = [0, 1, 2].map(|i| to.get(i).zip(from.get(i)).map_or(0, |(to, from)| to.saturating_sub(*from)));
        if let Some(before) = self.way.replace(way) {
            self.share = self.after(way, before);
        }
        for (next, to) in next.iter_mut().zip(to) {
            *next = next.saturating_add(product(to.saturating_sub(*next), self.share, SHARE_BITS));
        }
        next
    }

    /// The share for a way after another one, from 30 bits of the longer one: `share d'·d'/(d'·d' - d·d')`.
    fn after(&self, way: [i64; 3], before: [i64; 3]) -> i64 {
        let longest = way.iter().chain(&before).map(|&value| size(value)).max().unwrap_or(0);
        let [way, before] = [way, before].map(|way| way.map(|value| scaled(value, (30 - longest).min(0))));
        let dot = |one: [i64; 3]| one.iter().zip(before).fold(0_i64, |sum, (&one, other)| sum + one * other); // below 2^61.6
        let square = dot(before);
        let Some(inverse) = Inverse::of(square - dot(way)) else { return 4 * WHOLE };
        product(self.share, inverse.times(square, i32::from(SHARE_BITS)), SHARE_BITS).clamp(WHOLE / 4, 4 * WHOLE)
    }
}

fn distances<const N: usize>(one: [i64; N], other: [i64; N]) -> [u64; N] {
    let mut distances = [0; N];
    for (distance, (one, other)) in distances.iter_mut().zip(one.into_iter().zip(other)) {
        *distance = one.abs_diff(other);
    }
    distances
}

/// A sighting whose noise is independent and of variance 1, `C⁻¹` times the linearised one with `R = C Cᵀ`.
#[derive(Clone, Copy, Debug, Default)]
struct Normal {
    /// Innovations by what is known before, [`NORMAL_BITS`].
    residual: [i64; 3],
    /// Likewise.
    by_pose: [[i64; 3]; 3],
}

impl Normal {
    /// Of a sighting linearised where the state has moved by `from`: `ν = z - h(x_i) + H (x_i - x_0)` (`FILTER-3`).
    ///
    /// Errors: 2^-28 of a standard deviation, and 2^-27 of the results.
    //= reference/SPEC.md#filter
    //# - **FILTER-3** The innovation MUST be `ν = z - h(x_i) + H (x_i - x_0)`, its covariance `S = H P Hᵀ + R`, and the
    //# estimate `x_0 + P Hᵀ S⁻¹ ν`, with `R` the noise and MOTION-7's, angles the short way round.
    fn of(linearised: &Linearised, from: [i64; 5]) -> Option<Self> {
        let noise = Root::of(&linearised.noise, 3);
        let mut normal = Self::default();
        for (i, (by, &residual)) in linearised.by_pose.iter().zip(&linearised.residual).enumerate() {
            let inverse = Inverse::of(noise.entry(i, i))?;
            let mut by = *by;
            let mut left = by.iter().zip(from).fold(residual, |sum, (&by, moved)| {
                sum.saturating_add(product(by, moved, DERIVATIVE_BITS + 40 - RESIDUAL_BITS))
            });
            for (k, &factor) in noise.row(i).iter().enumerate().take(i) {
                let known = normal.by_pose.get(k)?;
                for (by, &known) in by.iter_mut().zip(known) {
                    *by = by.saturating_sub(product(factor, known, ROOT_BITS + NORMAL_BITS - DERIVATIVE_BITS));
                }
                let known = *normal.residual.get(k)?;
                left = left.saturating_sub(product(factor, known, ROOT_BITS + NORMAL_BITS - RESIDUAL_BITS));
            }
            let normalised = |value: i64, bits: u8| inverse.times(value, i32::from(ROOT_BITS + NORMAL_BITS - bits));
            *normal.by_pose.get_mut(i)? = by.map(|value| normalised(value, DERIVATIVE_BITS));
            *normal.residual.get_mut(i)? = normalised(left, RESIDUAL_BITS);
        }
        Some(normal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `FILTER-9`, with the ways of x, y, the heading, `e` and `g` with 40 fraction bits.
    //= reference/SPEC.md#filter
    //= type=test
    //# - **FILTER-9** Each further linearisation MUST be the share `ω` of the way from the one before to where that
    //# leads, `ω` being 1 at first and then `ω/(1 - r)` within 1/4 and 4, or 4 if `r >= 1`, with `r = d·d'/(d'·d')` of
    //# this way `d` and the way before, `d'`, in metres and radians.
    #[test]
    fn the_next_linearisation_is_where_the_ways_lead() {
        let unit = 1_i64 << 40;
        let way = [3 * unit, -4 * unit, 12 * unit, unit, 0];
        let by = |tenths: i64| way.map(|value| value / 10 * tenths);
        for (tenths, share) in [(5, 2.0), (-8, 1.0 / 1.8), (0, 1.0), (9, 4.0), (10, 4.0), (15, 4.0), (-90, 0.25)] {
            let mut pace = Pace { share: WHOLE, way: None };
            assert_eq!(pace.next([0; STATES], way), way);
            let from = [unit, 2 * unit, 3 * unit, 0, unit];
            let to = core::array::from_fn(|i| from[i] + by(tenths)[i]);
            let next = pace.next(from, to);
            for i in 0..STATES {
                let expected = from[i] as f64 + share * by(tenths)[i] as f64;
                // The way to 30 bits, the share to 2^-27 of itself.
                assert!((next[i] as f64 - expected).abs() <= 2.0 + expected.abs() * 2_f64.powi(-26), "{tenths} {i}");
            }
        }
    }

    #[test]
    fn ways_of_any_length_have_a_share() {
        let pace = Pace { share: WHOLE, way: None };
        for way in [[0; 3], [1, 0, 0], [i64::MAX; 3], [i64::MIN; 3], [i64::MIN, i64::MAX, 0]] {
            for before in [[0; 3], [1, 0, 0], [i64::MAX; 3], [i64::MIN; 3], [i64::MAX, i64::MIN, 0]] {
                assert!((WHOLE / 4..=4 * WHOLE).contains(&pace.after(way, before)), "{way:?} {before:?}");
            }
        }
        let mut pace = pace;
        let [far, near] = [i64::MAX, i64::MIN].map(|value| [value; STATES]);
        assert_eq!(pace.next(near, far).map(|value| value > 0), [false; STATES]); // the way is limited to 2^63
        assert_eq!(pace.next(far, near).map(|value| value < 0), [false; STATES]);
    }
}
