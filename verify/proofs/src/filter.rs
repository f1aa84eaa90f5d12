//! What a prediction leaves of a covariance.

use fixedpoint::motion::StateCovariance;
use fixedpoint::motion::covariance::{LARGEST, WheelNoise};

/// A prediction leaves the variances across and of the heading of any diagonally dominant covariance of both in range, none
/// below 0, and grows that of the heading.
///
/// - Domain: variances up to 16 m² and 16 rad², a covariance of both of no more than either; a step of 1/128 m along x,
///   with the slip of 1 cm.
/// - Fault: `motion/covariance.rs`: `self.settle([24, 24, 24, 5, 5]);` → ` `: nothing is limited.
/// - Memory: by cells.
/// - Seconds: 120
#[kani::proof]
#[kani::unwind(7)]
fn a_prediction_keeps_variances_in_range() {
    let [yy, yt, tt]: [i64; 3] = kani::any();
    kani::assume([yy, tt].iter().all(|variance| (1..=LARGEST).contains(variance)));
    kani::assume((-yy..=yy).contains(&yt) && (-tt..=tt).contains(&yt));
    let mut covariance = StateCovariance::default();
    for (i, j, entry) in [(0, 0, 1 << 40), (1, 1, yy), (1, 2, yt), (2, 2, tt)] {
        covariance.set(i, j, entry);
    }
    // Of a heading, 30 fraction bits; of the wheels' ways, 24, on an axle of 1/16 m.
    let transition = [[0; 3], [1 << 23, 0, 0], [0; 3]];
    let variance = 1 << 37; // 2^-25 m²
    let wheels = [-1, 1].map(|sign| WheelNoise { by: [1 << 23, 0, sign << 28], variance });
    covariance.moved(&transition, &wheels);
    kani::cover!(covariance.entry(1, 1) > 1 << 59);
    for i in 0..3 {
        assert!((0..=LARGEST).contains(&covariance.entry(i, i)));
    }
    assert!(covariance.entry(2, 2) > tt || tt > LARGEST / 2);
}
