//! Target `csv`: a robot's log as `replay` reads it, and the list of landmarks of `print --sheet`.
//!
//! Input: a byte whose lowest bits tell a log (0), a list (1) and a log of numbers (2), and the text. Of a log, bytes 0x1E part the texts of
//! `odometry.csv`, of `frames.csv` or `observations.csv`, whichever its header names, and of `truth.csv`. Images are those
//! that this project's readers are tested with.

mod composed;
mod log;
mod parts;
mod sheet;

use crate::draw::Draw;

/// One input.
///
/// # Panics
/// If the same rows are read in two ways that do not come to the same, or a refusal is more than a line.
pub fn run(data: &[u8]) {
    let mut draw = Draw::new(data);
    match draw.byte() & 3 {
        0 => log::run(draw.rest()),
        2 => log::run(composed::text(&mut draw, log::BETWEEN).as_bytes()),
        _ => sheet::run(draw.rest()),
    }
}

/// What begins some text files and is no part of them.
const MARK: &[u8] = b"\xEF\xBB\xBF";

/// The text with line ends of CR LF, if its are LF alone.
fn with_carriage_returns(text: &[u8]) -> Option<Vec<u8>> {
    if text.contains(&b'\r') {
        return None;
    }
    let byte = |&byte: &u8| if byte == b'\n' { vec![b'\r', b'\n'] } else { vec![byte] };
    Some(text.iter().flat_map(byte).collect())
}
