//! Everything that the fuzzer has kept and everything that it once found, without the fuzzer.

use fuzz::replay::{corpus, files, regressions};
use fuzz::{TARGETS, Target};
use std::fs;
use std::path::Path;
use std::sync::Mutex;

/// The bounds on memory are the process's: one target at a time.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

fn replay(name: &str, folder: &Path) -> usize {
    let _alone = ONE_AT_A_TIME.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let (_, run): &Target = TARGETS.iter().find(|(target, _)| *target == name).unwrap();
    let inputs = files(&folder.join(name)).unwrap();
    for input in &inputs {
        // Shown where the input fails.
        println!("{}", input.display());
        run(&fs::read(input).unwrap());
    }
    inputs.len()
}

/// A corpus is large enough to mean something and small enough for a repository.
fn replay_corpus(name: &str) {
    let count = replay(name, &corpus());
    assert!((5..=40).contains(&count), "{count} inputs");
    let bytes: u64 = files(&corpus().join(name)).unwrap().iter().map(|file| file.metadata().unwrap().len()).sum();
    assert!(bytes <= 200 << 10, "{bytes} bytes");
}

macro_rules! corpora {
    ($($name:ident)*) => {
        /// Targets with a test here.
        const TESTED: &[&str] = &[$(stringify!($name)),*];
        $(#[test] fn $name() { replay_corpus(stringify!($name)); })*
    };
}

corpora!(code_word csv filter lines pgm png scene toml);

#[test]
fn every_target_is_tested() {
    assert_eq!(TESTED, TARGETS.map(|(name, _)| name));
}

/// What once failed: the target, the file, and what was wrong.
const REGRESSIONS: &[(&str, &str, &str)] = &[
    ("filter", "late_where_nothing_makes_room", "TIME-9: the reference called full what would be late"),
    (
        "filter",
        "a_landmark_almost_touched",
        "FILTER-10: 4 mm before a landmark the noise by the steps was beyond the port's format",
    ),
    ("filter", "late_reading_settles_nothing", "TIME-6: the reference settled what was old when it came"),
    (
        "filter",
        "candidate_beside_the_gate",
        "SAME-7: of an observation's NIS by the candidate the reference did not tell how near to the gate it was",
    ),
    ("png", "palette_ends_within_a_colour", "png 0.18.1 panics where a palette's length is no multiple of 3"),
    (
        "scene",
        "a_blur_that_goes_to_and_fro",
        "FIT-8: where few pixels tell the blur from the gain the reference's steps went to and fro until there were none left",
    ),
    (
        "scene",
        "guards_that_have_not_converged",
        "TRELLIS-3: after five steps the guard fits were a quarter of a standard deviation apart, by the rounding of derivatives",
    ),
    (
        "scene",
        "two_minima_where_white_is_too_bright",
        "FIT-6: white that no pixel measures left the blur and the gain two minima, and each pipeline came to one",
    ),
    ("scene", "white_that_no_pixel_measures", "FIT-6: as above, of another scene"),
    (
        "scene",
        "step_of_light_beside_the_end",
        "FIT-6: damped steps left a light that few pixels tell far from its minimum, and the half width with it",
    ),
    ("toml", "mark_alone", "the target put a remark before a byte order mark"),
    ("toml", "mark_of_a_site", "SITE-9: a site file lost its byte order mark when a landmark was written into it"),
    ("toml", "control_character_in_key", "a camera file's key came with its control characters to the terminal"),
];

#[test]
fn nothing_that_was_found_comes_back() {
    for (name, file, what) in REGRESSIONS {
        println!("{what}");
        let path = regressions().join(name).join(file);
        assert!(path.is_file(), "{}", path.display());
    }
    for (name, _) in TARGETS {
        let mut known: Vec<&str> = REGRESSIONS.iter().filter(|known| known.0 == name).map(|known| known.1).collect();
        known.sort_unstable();
        let there = files(&regressions().join(name)).unwrap();
        let there: Vec<_> = there.iter().map(|path| path.file_name().unwrap().to_str().unwrap()).collect();
        assert_eq!(there, known, "a regression has a name and a sentence: {name}");
        replay(name, &regressions());
    }
}
