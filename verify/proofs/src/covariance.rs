//! The covariance of a state, and what keeps it one.

use fixedpoint::covariance::PoseCovariance;
use fixedpoint::motion::covariance::{LARGEST, STATES, StateCovariance};

/// A pose's covariance becomes a state's whatever it is: variances above 0 and in range, everything else in range,
/// `e` and `g` known.
///
/// - Domain: all 64-bit numbers in place of the six entries.
/// - Fault: `motion/covariance.rs`: `.clamp(-(LARGEST >> FINER), LARGEST >> FINER) << FINER` →
///   `.clamp(-(LARGEST >> FINER), LARGEST >> (FINER - 1)) << FINER`: a covariance may be twice as large.
/// - Memory: by cells.
/// - Seconds: 120
#[kani::proof]
#[kani::unwind(8)]
fn any_pose_s_covariance_is_in_range() {
    let [xx, xy, xt, yy, yt, tt]: [i64; 6] = kani::any();
    let covariance = StateCovariance::of_pose(&PoseCovariance { xx, xy, xt, yy, yt, tt });
    kani::cover!(xx == i64::MAX);
    for i in 0..3 {
        assert!((1..=LARGEST).contains(&covariance.entry(i, i)));
        for j in 0..3 {
            assert!(covariance.entry(i, j).abs() <= LARGEST);
        }
    }
    assert!(covariance.entry(3, 3) == 0 && covariance.entry(4, 4) == 0 && covariance.uncertain() == 3);
}

/// What every prediction and every update ends with leaves a covariance whose variances are in range, and not below
/// 0.
///
/// - Domain: all variances from 0 to 2^63 - 1 of a state of five numbers, all covariances; the bounds of a
///   prediction.
/// - Fault: `motion/covariance.rs`: `let half = if i == o { (entry >> 2) + 3 }` →
///   `let half = if i == o { (entry >> 1) - (1 << 60) }`: the variance itself is not reduced as its row is.
#[kani::proof]
#[kani::unwind(7)]
fn settled_variances_are_in_range() {
    let mut covariance = StateCovariance::default();
    for i in 0..STATES {
        for j in i..STATES {
            let entry: i64 = kani::any();
            kani::assume(i != j || entry >= 0);
            covariance.set(i, j, entry);
        }
    }
    covariance.settle([24, 24, 24, 5, 5]);
    kani::cover!(covariance.entry(0, 0) == LARGEST);
    for i in 0..STATES {
        assert!((0..=LARGEST).contains(&covariance.entry(i, i)));
    }
}
