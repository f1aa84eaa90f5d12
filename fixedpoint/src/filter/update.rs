//! One observation: linearised again and again, and used for a state or not.

use super::root::{Correction, NORMAL_BITS, ROOT_BITS, Root};
use crate::binary::product;
use crate::inverse::Inverse;
use crate::motion::State;
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
pub(super) fn updated(prior: &State, linearise: impl Fn(&State) -> Option<Linearised>) -> Option<State> {
    let before = Root::of(&prior.covariance, prior.covariance.uncertain());
    let mut root = before;
    let mut correction = Correction::default();
    let mut settled = false;
    for _ in 0..LINEARISATIONS {
        let from = correction.moved;
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
    }
    if !settled || correction.nis > GATE {
        return None;
    }
    Some(State { covariance: root.covariance(), ..prior.moved(correction.moved) })
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
