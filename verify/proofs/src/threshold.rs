//! What is black and what is distinct.

use fixedpoint::refusal::LineRefusal;
use fixedpoint::threshold::{Threshold, threshold};

/// A pixel is black and distinct as THRESH-2, THRESH-3, THRESH-7 and THRESH-8 say.
///
/// - Domain: all extremes in order, all pixels.
/// - Fault: `threshold.rs`: `8 * self.distance(pixel) >= u16::from(self.range())` →
///   `8 * self.distance(pixel) > u16::from(self.range())`: a sixteenth of the range is not enough.
#[kani::proof]
#[kani::unwind(5)]
fn black_and_distinct_are_as_defined() {
    let (darkest, brightest, pixel): (u8, u8, u8) = (kani::any(), kani::any(), kani::any());
    kani::assume(darkest <= brightest);
    let threshold = Threshold { darkest, brightest };
    let [darkest, brightest, value] = [darkest, brightest, pixel].map(i32::from);
    let (sum, range) = (darkest + brightest, brightest - darkest);
    kani::cover!(8 * (2 * value - sum) == range && range > 24);
    assert_eq!(threshold.is_black(pixel), range >= 24 && 2 * value < sum);
    assert_eq!(threshold.is_distinct(pixel), range < 24 || 8 * (2 * value - sum).abs() >= range);
}

/// Of a line that is not refused the darkest pixel is black, the brightest is white, and both are distinct.
///
/// - Domain: all lines of 8 pixels.
/// - Fault: `threshold.rs`: `let darkest = line.iter().copied().min().unwrap_or(0);` →
///   `let darkest = line.first().copied().unwrap_or(0);`: the first pixel counts as the darkest.
#[kani::proof]
#[kani::unwind(10)]
fn extremes_are_told_apart() {
    let line: [u8; 8] = kani::any();
    let place: u8 = kani::any();
    kani::assume(place < 8);
    let pixel = line[usize::from(place)];
    let found = threshold(&line);
    kani::cover!(found == Err(LineRefusal::LowContrast));
    if let Ok(found) = found {
        assert!((found.darkest..=found.brightest).contains(&pixel));
        assert!(found.is_black(found.darkest) && found.is_distinct(found.darkest));
        assert!(!found.is_black(found.brightest) && found.is_distinct(found.brightest));
        assert!(line.contains(&found.darkest) && line.contains(&found.brightest));
    } else {
        assert!(line.iter().all(|other| pixel.abs_diff(*other) < 24));
    }
}
