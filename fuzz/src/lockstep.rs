//! Both pipelines on one frame, as `SAME` asks.

use crate::fault;
use verify::lockstep::{Setting, compare};
use verify::tally::{Frame, Part, Tally};
use verify::trace::Trace;

/// Whose frames these are in a tally; there is one only.
const FRAME: Frame = Frame { part: Part::Lines, index: 0 };

/// The traces of the reference and of the port.
///
/// # Panics
/// If a stage of the port differs by more than it may (SAME-1 to SAME-6).
#[must_use]
pub fn run(setting: &Setting, upper: &[u8], lower: &[u8]) -> [Trace; 2] {
    let reference = setting.run_reference(upper, lower);
    let port = fault::trace(setting.run_fixedpoint(upper, lower));
    let mut tally = Tally::default();
    compare(setting, FRAME, &reference, &port, &mut tally);
    let failing = tally.failing();
    if !failing.is_empty() {
        let worst: Vec<String> =
            failing.iter().map(|&stage| format!("{stage:?}: {:?}", tally.stage(stage).worst)).collect();
        panic!("not the same: {}", worst.join("; "));
    }
    [reference, port]
}
