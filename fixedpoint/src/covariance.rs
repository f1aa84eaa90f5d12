//! The covariance of a pose.
//!
//! `POSE` bends: what is a Gaussian in `(a, s, k)` is a thin sliver along `k`. So the pose is averaged over five nodes of
//! `k`, each with the mean of `(a, s)` given it, and what remains of `(a, s)` goes through the derivatives at the nodes.
//! With `m = f k` and `ρ² = s² + m²` these are, by `a` and by `s`,
//!
//! `x: -W m/ρ², (W f - 2 s x)/ρ²`, `y: -W s/ρ², -(W a + 2 s y)/ρ²`, `θ: 0, m/ρ²`.

pub mod exponential;
mod node;
mod paper;
mod spread;

use crate::binary::product;
use crate::camera::Camera;
use crate::formats::{Angle, Column, Length, Obliquity};
use crate::frame::{self, Pose};
use crate::homography::Homography;
use crate::landmark::Landmark;
use crate::ratio;
use node::Node;
pub use paper::paper;
use spread::Derivatives;

/// The covariance of `(a, s, k)`: px² for two of `a` and `s`, px with `k`, all with 50 fraction bits.
///
/// Saturates at ±2^12 or later.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Covariance {
    /// Variance of `a`.
    pub aa: i64,
    /// Covariance of `a` and `s`.
    pub as_: i64,
    /// Covariance of `a` and `k`.
    pub ak: i64,
    /// Variance of `s`.
    pub ss: i64,
    /// Covariance of `s` and `k`.
    pub sk: i64,
    /// Variance of `k`.
    pub kk: i64,
}

impl Covariance {
    /// That of columns from another origin, at `-origin` as seen from this one: `s' = s + origin k`.
    ///
    /// Rounding errors: 2^-51 of `as` and `sk`, `2 origin` times that of `ss`.
    #[must_use]
    pub fn shifted(&self, origin: Column) -> Self {
        let times = |value: i64| product(i64::from(origin.to_bits()), value, 20);
        let sk = self.sk.saturating_add(times(self.kk));
        Self {
            as_: self.as_.saturating_add(times(self.ak)),
            ss: self.ss.saturating_add(times(self.sk.saturating_add(sk))),
            sk,
            ..*self
        }
    }
}

/// The covariance of a pose `(x, y, θ)`: m², m rad and rad², all with 48 fraction bits.
///
/// Saturates at ±2^15: COV-5 knows variances of up to 28,000 m².
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PoseCovariance {
    /// Variance of `x`.
    pub xx: i64,
    /// Covariance of `x` and `y`.
    pub xy: i64,
    /// Covariance of `x` and `θ`.
    pub xt: i64,
    /// Variance of `y`.
    pub yy: i64,
    /// Covariance of `y` and `θ`.
    pub yt: i64,
    /// Variance of `θ`.
    pub tt: i64,
}

impl PoseCovariance {
    fn plus(&self, other: &Self, weight: i64) -> Self {
        let sum = |one: i64, other: i64| one.saturating_add(product(other, weight, WEIGHT_BITS));
        Self {
            xx: sum(self.xx, other.xx),
            xy: sum(self.xy, other.xy),
            xt: sum(self.xt, other.xt),
            yy: sum(self.yy, other.yy),
            yt: sum(self.yt, other.yt),
            tt: sum(self.tt, other.tt),
        }
    }
}

/// Why a fitted pose was refused: its heading is not known (`COV-4`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Undetermined;

/// Fraction bits of the nodes' places and weights.
const WEIGHT_BITS: u8 = 30;

/// Gauss-Hermite nodes and their weights: zeros of the fifth Hermite polynomial, `ξ² = 5 ± √10`, and 8/15, `(7 ± 2 √10)/60`.
const NODES: [(i64, i64); 5] = [
    (0, 572_662_306),
    (1_455_592_527, 238_452_206),
    (-1_455_592_527, 238_452_206),
    (3_067_648_194, 12_087_553),
    (-3_067_648_194, 12_087_553),
];

/// The camera's pose in the landmark's frame and its covariance, through the bend (`COV-1` to `COV-4`).
///
/// Rounding errors: at each node 2^-31 of `k`, 2^-21 px of `a` and `s`, and what [`crate::pose`] lists, with 36 fraction
/// bits instead of 24; of the mean 2^-25 m and 2^-31 π; of the covariance 2^-48 for each node, and 2^-28 of the derivatives.
///
/// # Errors
/// `Undetermined` by `COV-4`.
//= reference/SPEC.md#cov
//# - **COV-1** The distribution of `(a, s, k)` MUST be split into that of `k` and that of `(a, s)` given `k`, whose
//# mean moves by `Σ_{as,k}/Σ_kk` per unit of k and whose covariance is `Σ_as - Σ_{as,k} Σ_{k,as}/Σ_kk`.
//= reference/SPEC.md#cov
//# - **COV-2** The mean of a fitted pose MUST be the mean of POSE over the five Gauss-Hermite nodes of `k`, at the mean
//# of `(a, s)` given each.
//= reference/SPEC.md#cov
//# - **COV-3** Its covariance MUST be that of the five nodes about their mean, plus the mean over the nodes of the
//# covariance of `(a, s)` given `k` carried through the derivatives of POSE by `a` and `s`.
pub fn transform(
    homography: &Homography,
    covariance: &Covariance,
    camera: &Camera,
    landmark: &Landmark,
) -> Result<(Pose<frame::Landmark, frame::Camera>, PoseCovariance), Undetermined> {
    if !is_determined(homography, covariance, camera) {
        return Err(Undetermined);
    }
    let given = Conditional::of(covariance);
    let middle = Node::at(homography, camera, landmark);
    let mut mean = [0_i64; 3];
    let mut sum = PoseCovariance::default();
    for (place, weight) in NODES {
        let node = given.node(homography, place);
        let at = Node::at(&node, camera, landmark);
        let deviation = deviation(&at, &middle);
        for (mean, deviation) in mean.iter_mut().zip(deviation) {
            *mean = mean.saturating_add(product(deviation, weight, WEIGHT_BITS));
        }
        sum = sum.plus(&square(deviation), weight);
        sum = sum.plus(&Derivatives::at(&node, &at, camera).carried(&given), weight);
    }
    Ok((moved(&middle, mean), sum.plus(&square(mean), -(1 << WEIGHT_BITS))))
}

/// Whether `f² Σ_kk <= s²/16` (`COV-4`).
///
/// Error: 2^-40 px² of 16 times the left side.
//= reference/SPEC.md#cov
//# - **COV-4** The pose and the covariance that a detection reports MUST be these, and a fit count as undetermined if
//# `f sqrt(Σ_kk) > s/4`, where the heading is so uncertain that no Gaussian can say it.
#[must_use]
pub fn is_determined(homography: &Homography, covariance: &Covariance, camera: &Camera) -> bool {
    let f = i64::from(camera.focal_length().to_bits()); // 16 fraction bits
    let s = i64::from(homography.s.to_bits()); // 20
    product(f * f, covariance.kk, 38) <= s.saturating_mul(s) // 16 f² Σ with 40
}

/// The distribution of `(a, s)` given `k` (`COV-1`).
#[derive(Clone, Copy, Debug)]
struct Conditional {
    /// The standard deviation of `k` with 30 fraction bits.
    deviation: i64,
    /// `Σ_ak/Σ_kk` and `Σ_sk/Σ_kk` in px with 20 fraction bits.
    slopes: [i64; 2],
    /// Variance of `a`, covariance, variance of `s`, 50 fraction bits.
    aa: i64,
    as_: i64,
    ss: i64,
}

impl Conditional {
    fn of(covariance: &Covariance) -> Self {
        let Covariance { aa, as_, ak, ss, sk, kk } = *covariance;
        // Without a variance of k nothing moves with it.
        let slope = |with_k: i64| ratio::rounded(with_k, kk, 20).unwrap_or(0);
        let [by_a, by_s] = [slope(ak), slope(sk)];
        let less = |value: i64, slope: i64, with_k: i64| value.saturating_sub(product(slope, with_k, 20));
        let deviation = kk.max(0).unsigned_abs().saturating_mul(1 << 10).isqrt();
        Self {
            deviation: i64::try_from(deviation).unwrap_or_default(),
            slopes: [by_a, by_s],
            aa: less(aa, by_a, ak).max(0),
            as_: less(as_, by_a, sk),
            ss: less(ss, by_s, sk).max(0),
        }
    }

    /// The mean at `place` standard deviations of `k`.
    fn node(&self, homography: &Homography, place: i64) -> Homography {
        let k = product(self.deviation, place, WEIGHT_BITS); // 30 fraction bits
        let [a, s] = self.slopes.map(|slope| product(slope, k, 30));
        let moved = |value: i32, change: i64| {
            let sum = i64::from(value).saturating_add(change);
            i32::try_from(sum.clamp(i64::from(i32::MIN), i64::from(i32::MAX))).unwrap_or_default()
        };
        Homography {
            a: Column::from_bits(moved(homography.a.to_bits(), a)),
            s: Column::from_bits(moved(homography.s.to_bits(), s)),
            k: Obliquity::from_bits(moved(homography.k.to_bits(), k)),
        }
    }
}

/// π with 40 fraction bits.
const PI: i64 = 3_454_217_652_358;

/// A node less another one, the angle the short way round: metres and radians with 36 fraction bits.
fn deviation(node: &Node, from: &Node) -> [i64; 3] {
    let turn = i64::from((node.theta - from.theta).to_bits()); // 31 fraction bits of π
    [node.x.saturating_sub(from.x), node.y.saturating_sub(from.y), product(turn, PI, 35)]
}

/// The pose of a node moved by metres and radians with 36 fraction bits.
fn moved(node: &Node, [x, y, turn]: [i64; 3]) -> Pose<frame::Landmark, frame::Camera> {
    const INVERSE_PI: i64 = 349_985_421_095; // 40 fraction bits
    let length = |from: i64, change: i64| {
        let sum = ratio::dropped(from.saturating_add(change), 12);
        Length::from_bits(i32::try_from(sum.clamp(i64::from(i32::MIN), i64::from(i32::MAX))).unwrap_or_default())
    };
    let turn = i32::try_from(product(turn, INVERSE_PI, 45)).unwrap_or_default();
    Pose::new(length(node.x, x), length(node.y, y), node.theta + Angle::from_bits(turn))
}

/// The products of a deviation with itself.
fn square([x, y, t]: [i64; 3]) -> PoseCovariance {
    let of = |one: i64, other: i64| product(one, other, 24);
    PoseCovariance { xx: of(x, x), xy: of(x, y), xt: of(x, t), yy: of(y, y), yt: of(y, t), tt: of(t, t) }
}

#[cfg(test)]
mod tests;
