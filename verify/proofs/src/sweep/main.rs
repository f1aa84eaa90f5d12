//! Sweeps: claims that are shown by trying every number there is.

mod filter;
mod lines;
mod rounding;
mod timeline;

use std::process::ExitCode;

/// All sweeps by name.
const SWEEPS: [(&str, fn()); 19] = [
    ("covariances_are_symmetric", filter::covariances_are_symmetric),
    ("observations_move_towards_what_is_seen", filter::observations_move_towards_what_is_seen),
    ("regions_are_as_defined", lines::regions_are_as_defined),
    ("any_roi_can_be_checked", lines::any_roi_can_be_checked),
    ("rois_share_no_region", lines::rois_share_no_region),
    ("transitions_come_once", lines::transitions_come_once),
    ("local_thresholds_are_those_of_their_windows", lines::local_thresholds_are_those_of_their_windows),
    ("too_many_regions_are_refused", lines::too_many_regions_are_refused),
    ("transitions_lie_where_the_threshold_is_met", lines::transitions_lie_where_the_threshold_is_met),
    ("chords_keep_to_their_error", rounding::chords_keep_to_their_error),
    ("exponentials_keep_to_their_error", rounding::exponentials_keep_to_their_error),
    ("quick_sines_keep_to_their_error", rounding::quick_sines_keep_to_their_error),
    ("ratios_are_rounded", rounding::ratios_are_rounded),
    ("reciprocals_keep_to_their_error", rounding::reciprocals_keep_to_their_error),
    ("a_queue_stays_well_formed", timeline::a_queue_stays_well_formed),
    ("sines_keep_to_their_error", rounding::sines_keep_to_their_error),
    ("sines_repeat_by_quarters", rounding::sines_repeat_by_quarters),
    ("square_roots_keep_to_their_error", rounding::square_roots_keep_to_their_error),
    ("vectors_have_their_angle", rounding::vectors_have_their_angle),
];

fn main() -> ExitCode {
    let name = std::env::args().nth(1).unwrap_or_default();
    let Some((_, sweep)) = SWEEPS.iter().find(|(known, _)| *known == name) else {
        eprintln!("there is no sweep `{name}`");
        return ExitCode::from(2);
    };
    sweep();
    ExitCode::SUCCESS
}
