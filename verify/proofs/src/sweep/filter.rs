//! The filter's numbers.

use fixedpoint::filter::root::{Correction, Root};
use fixedpoint::motion::StateCovariance;
use fixedpoint::motion::covariance::STATES;

/// A covariance is symmetric: an entry is the same as its mirror image, and setting one sets no other.
///
/// - Domain: all pairs of places.
/// - Fault: `motion/covariance.rs`: `let (i, j) = if i < j { (i, j) } else { (j, i) };` →
///   `let (i, j) = if i < j { (i, j) } else { (i, i) };`: the lower triangle is the diagonal.
pub(crate) fn covariances_are_symmetric() {
    let places = || (0..STATES).flat_map(|i| (0..STATES).map(move |j| (i, j)));
    for (i, j) in places() {
        let mut covariance = StateCovariance::default();
        covariance.set(i, j, 1);
        for (row, column) in places() {
            let is_same = (row, column) == (i, j) || (column, row) == (i, j);
            assert_eq!(covariance.entry(row, column), i64::from(is_same), "{i} {j} {row} {column}");
        }
    }
}

/// An observation moves the state towards what was seen, and leaves the variance along it half of what it was and the others
/// as they were, whatever is seen.
///
/// - Domain: every 2^16th innovation within 2^11 standard deviations; a state with deviations of 1/8 m, 1/8 m and 1/8 rad, seen
///   along x with a deviation of 1/8 m.
/// - Fault: `filter/root.rs`: `for (entry, weight) in row.iter_mut().zip(weights) {` →
///   `for (entry, weight) in row.iter_mut().zip(weights).skip(1) {`: a column of the root is not corrected.
pub(crate) fn observations_move_towards_what_is_seen() {
    let mut covariance = StateCovariance::default();
    for i in 0..3 {
        covariance.set(i, i, 1 << 50); // 2^-6 with 56 fraction bits
    }
    let before = Root::of(&covariance, 3);
    for seen in (-(1_i64 << 39)..=1 << 39).step_by(1 << 16) {
        let (mut root, mut correction) = (before, Correction::default());
        root.observe(&[8 << 28, 0, 0], seen, &mut correction);
        // 1/8 m is 2^37 with 40 fraction bits, and half of that is moved for each deviation, to 2^-26 and a unit.
        let [x, y, turn, ..] = correction.moved;
        let half = seen << 8;
        assert!((x - half).abs() <= (half.abs() >> 26) + 1 && y == 0 && turn == 0, "{seen}: {x} {y} {turn}");
        let after = root.covariance();
        for (i, expected) in [1 << 49, 1 << 50, 1 << 50].into_iter().enumerate() {
            // 2^-26 of it, and what is added for rounding.
            assert!(after.entry(i, i).abs_diff(expected) <= 1 << 24, "{seen}: {i} {}", after.entry(i, i));
        }
    }
}
