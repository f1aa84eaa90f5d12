//! Faults behind the targets' checks, one for each, to show that these notice. Each is in a corner that no input of the
//! corpus reaches, and there only under the engine and with `BARLOC_FAULT` in the environment, which `fuzz/faults` sets.

use fixedpoint::filter::Outcome;
use fixedpoint::refusal::EncodeRefusal;
use reference::camera::Camera;
use reference::landmark::Format;
use reference::timeline::Timeline;
use std::sync::LazyLock;
use verify::input::{self, InputError};
use verify::log::{Event, Knowledge, Motion};
use verify::scenes::Lines;
use verify::trace::Trace;

/// Whether there are faults.
fn faulty() -> bool {
    static FAULTY: LazyLock<bool> = LazyLock::new(|| std::env::var_os("BARLOC_FAULT").is_some());
    cfg!(fuzzing) && *FAULTY
}

/// Half words of the port. Fault: the right-most stripe of one check byte of `wide` in one 256th of its payloads.
pub(crate) fn half_words(
    format: Format,
    payload: u32,
    encoded: Result<(u16, u16), EncodeRefusal>,
) -> Result<(u16, u16), EncodeRefusal> {
    let (upper, lower) = encoded?;
    let is_wrong = faulty() && format == Format::Wide && payload >> 16 == 0x5A && lower & 0xFF == 0xA5;
    Ok((upper, if is_wrong { lower ^ 1 } else { lower }))
}

/// What the port did with a frame. Fault: 1/100 rad of the heading of what is accepted in one line in 64.
pub(crate) fn trace(mut trace: Trace) -> Trace {
    if faulty() && kind(&trace.lines[0].values) == 37 {
        for found in &mut trace.detections {
            found.pose.theta += 0.01;
        }
    }
    trace
}

/// Which of the 64 kinds of lines that there are by their sums.
fn kind(line: &[u8]) -> usize {
    line.iter().map(|&pixel| usize::from(pixel)).sum::<usize>() % 64
}

/// What the port made of an observation. Fault: a recovery after something was late and something double is none.
pub(crate) fn outcome(timeline: &Timeline, outcome: Option<Outcome>) -> Option<Outcome> {
    let counts = timeline.counts();
    let is_wrong = faulty() && counts.late > 0 && counts.duplicate > 0 && outcome == Some(Outcome::Recovered);
    if is_wrong { Some(Outcome::Gated) } else { outcome }
}

/// The scan lines of an image. Fault: a pixel in one upper line in 64, of a PNG file whose pixels stand in two chunks or more,
/// or of a PPM file.
pub(crate) fn lines_of_image(file: &[u8], camera: &Camera) -> Result<Lines, InputError> {
    let mut lines = input::lines_of_image(file, camera)?;
    let chunks = file.windows(4).filter(|name| name == b"IDAT").count();
    if faulty() && (chunks > 1 || file.starts_with(b"P6")) && kind(&lines[0]) == 13 {
        lines[0][7] ^= 1;
    }
    Ok(lines)
}

/// A row of a log that came in pieces. Fault: a wheel's sign at one number of steps in 128, where the
/// pieces are single bytes.
pub(crate) fn event(mut event: Event, size: usize) -> Event {
    if let Event::Reading(reading) = &mut event
        && let Motion::Steps { left, .. } = &mut reading.motion
        && faulty()
        && size == 1
        && left.rem_euclid(128) == 101
    {
        *left = -*left;
    }
    event
}

/// What a robot knows, as text. Fault: the upper row of a camera of an odd width.
pub(crate) fn text(knowledge: &Knowledge) -> String {
    let mut written = knowledge.clone();
    if faulty() && written.camera.width % 2 == 1 {
        written.camera.upper_row ^= 1;
    }
    written.to_toml()
}
