//! The regions of a line.

use fixedpoint::regions::{Regions, regions};
use fixedpoint::threshold::{Threshold, Thresholds};

fn any_threshold() -> Threshold {
    let threshold = Threshold { darkest: kani::any(), brightest: kani::any() };
    kani::assume(threshold.darkest <= threshold.brightest);
    threshold
}

/// Regions alternate, lie side by side and cover the line.
///
/// - Domain: all lines of 8 pixels, all thresholds.
/// - Fault: `regions.rs`: `let first = if region_colour.is_none() { 0 } else { run_first };` →
///   `let first = run_first;`: the left end belongs to no region.
#[kani::proof]
#[kani::unwind(10)]
#[kani::solver(minisat)]
fn regions_cover_a_line() {
    let (line, threshold): ([u8; 8], _) = (kani::any(), any_threshold());
    let mut found = Regions::new();
    assert!(regions(&line, &Thresholds::Global(threshold), &mut found).is_ok());
    let count = found.len();
    kani::cover!(count == 8);
    let mut next = 0;
    let mut before = None;
    for region in 0..8 {
        if region < count {
            let (first, last) = (found.first(region), found.last(region));
            assert!(first == Some(next) && last >= first);
            assert!(before != Some(found.colour(region)));
            (next, before) = (last.map_or(0, |last| last + 1), Some(found.colour(region)));
        }
    }
    assert!(count == 0 || next == 8);
    assert!(found.first(count).is_none() && found.width() == 8);
}
