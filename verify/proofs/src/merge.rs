//! The list of detections, and the mean of two homographies.

use fixedpoint::formats::{Column, Obliquity};
use fixedpoint::homography::Homography;
use fixedpoint::merge::mean;

/// The mean of two numbers is half their sum, rounded up, whatever they are.
///
/// - Domain: all pairs of homographies.
/// - Fault: `merge.rs`: `whole + (odd >> 1) + (odd & 1)` → `whole + (odd >> 1)`: rounded down.
#[kani::proof]
fn means_are_rounded() {
    let (one, other): ([i32; 2], [i32; 2]) = (kani::any(), kani::any());
    let homography = |[column, obliquity]: [i32; 2]| Homography {
        a: Column::from_bits(column),
        s: Column::from_bits(column),
        k: Obliquity::from_bits(obliquity),
    };
    let found = mean(&homography(one), &homography(other));
    let surplus = |found: i32, place: usize| 2 * i64::from(found) - i64::from(one[place]) - i64::from(other[place]);
    kani::cover!(surplus(found.a.to_bits(), 0) == 1);
    assert!((0..=1).contains(&surplus(found.a.to_bits(), 0)) && found.s == found.a);
    assert!((0..=1).contains(&surplus(found.k.to_bits(), 1)));
}
