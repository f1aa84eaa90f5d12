//! The local threshold: extremes of windows that slide along a line.

use fixedpoint::threshold::Threshold;
use fixedpoint::threshold::local::Blocks;

/// The smallest and the largest of the pixels from `first` to `last`.
fn extremes(line: &[u8], first: usize, last: usize) -> (u8, u8) {
    let mut found = (u8::MAX, 0);
    for (i, &pixel) in line.iter().enumerate() {
        if first <= i && i <= last {
            found = (found.0.min(pixel), found.1.max(pixel));
        }
    }
    found
}

/// THRESH-5 and THRESH-6 as they stand.
fn defined(line: &[u8], pixel: usize) -> Threshold {
    let block = pixel / 16;
    let (left, right) = (16 * block.saturating_sub(8), (16 * (block + 8) + 15).min(line.len() - 1));
    let (darkest_left, brightest_left) = extremes(line, left, pixel);
    let (darkest_right, brightest_right) = extremes(line, pixel, right);
    let next = line.get(pixel + 1).copied().unwrap_or(u8::MAX);
    let previous = if pixel == 0 { u8::MAX } else { line[pixel - 1] };
    Threshold {
        darkest: darkest_left.min(next).max(darkest_right.min(previous)),
        brightest: brightest_left.min(brightest_right),
    }
}

/// A pixel's local threshold is that of the pixels around it.
///
/// - Domain: all lines of 6 pixels, any pixel of them; a sweep has longer ones.
/// - Fault: `threshold/local.rs`: `darkest: darkest(left, next).max(darkest(right, previous)),` →
///   `darkest: darkest(left, None).max(darkest(right, previous)),`: the next pixel does not count.
#[kani::proof]
#[kani::unwind(42)]
fn local_thresholds_are_as_defined() {
    let line: [u8; 6] = kani::any();
    let pixel: u8 = kani::any();
    kani::assume(pixel < 6);
    let mut blocks = Blocks::new();
    assert!(blocks.read(&line).is_ok());
    let expected = defined(&line, usize::from(pixel));
    kani::cover!(pixel == 5 && expected.range() == 255);
    assert_eq!(blocks.at(&line, u16::from(pixel)), Some(expected));
}
