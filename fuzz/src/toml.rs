//! Target `toml`: files of a camera, a site, a scenario and a robot.
//!
//! Input: a byte that chooses the kind of file, and the text.

use crate::draw::Draw;
use crate::fault;
use crate::memory;
use crate::replay::is_a_sentence;
use core::fmt::{Debug, Display};
use reference::grid::Codes;
use reference::landmark::Format;
use std::path::Path;
use verify::input;
use verify::log::Knowledge;
use verify::scenario;
use verify::site::{self, Site};

/// What reading a file may take beside 2 KiB for each of its bytes: a table for every `[a]`.
const MOST: usize = 1 << 20;

/// The name that texts are read under.
const NAME: &str = "fuzz.toml";

/// The site that a scenario may name, whatever name it gives.
const SITE: &str = include_str!("../../verify/scenarios/corridor.toml");

/// One input.
///
/// # Panics
/// If a file is read in two ways that do not come to the same, or a refusal is more than a line.
pub fn run(data: &[u8]) {
    let mut draw = Draw::new(data);
    let kind = draw.byte();
    // The readers take text only.
    let Ok(text) = core::str::from_utf8(draw.rest()) else { return };
    match kind % 4 {
        0 => drop(read_alike(text, input::camera_of_toml)),
        1 => {
            if let Some(site) = read_alike(text, |text| site::of_toml(text, Path::new(NAME))) {
                landmarks_are_added(text, &site, kind);
            }
        }
        2 => drop(read_alike(text, |text| scenario::of_toml(text, Path::new(NAME), |_| Ok(SITE.to_owned())))),
        _ => {
            let knowledge = read_alike(text, |text| Knowledge::of_toml(text, Path::new(NAME)));
            knowledge.iter().for_each(is_written_and_read);
        }
    }
}

/// What a text means, in all spellings of it.
fn read_alike<T: Debug + PartialEq, E: Display>(text: &str, reader: impl Fn(&str) -> Result<T, E>) -> Option<T> {
    let read = |text: &str| {
        let found = memory::at_most(MOST + 2048 * text.len(), || reader(text));
        found.map_err(|refusal| is_a_sentence(&refusal.to_string())).ok()
    };
    let meaning = read(text);
    // A line end within a text is a part of it.
    let has_long_texts = text.contains("\"\"\"") || text.contains("'''");
    if !text.contains('\r') && !has_long_texts {
        assert_eq!(read(&text.replace('\n', "\r\n")), meaning, "line ends of CR LF");
    }
    if meaning.is_some() {
        // A byte order mark is one only where the text begins.
        let (mark, rest) = text.split_at(if text.starts_with('\u{feff}') { '\u{feff}'.len_utf8() } else { 0 });
        assert_eq!(read(&format!("{mark}# {NAME}\n{rest}\n\n# end")), meaning, "remarks");
    }
    // Written anew by the library: order, spelling of numbers, and tables in line are others.
    if let Ok(table) = text.parse::<toml::Table>() {
        let anew = toml::to_string(&table).expect("what was read can be written");
        assert_eq!(read(&anew), meaning, "written anew:\n{anew}");
    }
    meaning
}

/// LOG-19
fn is_written_and_read(knowledge: &Knowledge) {
    let again = Knowledge::of_toml(&fault::text(knowledge), Path::new(NAME));
    assert_eq!(again.expect("what was written"), *knowledge, "LOG-19");
}

/// SITE-9: what is added is added, and nothing else changes.
fn landmarks_are_added(text: &str, site: &Site, seed: u8) {
    let read = |text: &str| site::of_toml(text, Path::new(NAME));
    let with = |added: &[(Format, Codes)]| site::with_landmarks(text, Path::new(NAME), added);
    let same = with(&[]).and_then(|text| read(&text));
    assert_eq!(same.expect("nothing was added"), *site, "SITE-9");
    let codes = Codes { x: u32::from(seed >> 2), y: 0, theta: u32::from(seed >> 4) };
    let Ok(more) = with(&[(Format::Paper, codes)]) else { panic!("landmarks can be added") };
    keeps_its_lines(text, &more);
    // It may hang on no wall.
    if let Ok(more) = read(&more) {
        let (last, before) = more.landmarks.split_last().expect("one was added");
        assert_eq!(before, site.landmarks, "SITE-9");
        assert_eq!(last.landmark_in_world, site.grid.pose(Format::Paper, codes));
        assert_eq!(Site { landmarks: site.landmarks.clone(), ..more }, *site, "SITE-9");
    }
}

/// Every line is still there, in its order, but for landmarks in line, which become tables.
fn keeps_its_lines(text: &str, more: &str) {
    let in_line = text.contains("landmark") && !text.contains("[[landmark]]") || text.contains("landmark =");
    if in_line || text.contains('\r') {
        return;
    }
    let [(was_marked, text), (is_marked, more)] = [text, more].map(|text| {
        let unmarked = text.strip_prefix('\u{feff}');
        (unmarked.is_some(), unmarked.unwrap_or(text))
    });
    assert_eq!(is_marked, was_marked, "SITE-9: the byte order mark");
    let mut lines = more.lines().map(str::trim_end);
    for line in text.lines().map(str::trim_end) {
        assert!(lines.any(|other| other == line), "SITE-9: {line:?} is lost in\n{more}");
    }
}
