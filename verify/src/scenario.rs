//! Scenario files: a site, and what happens there (SCENARIO).
//!
//! ```toml
//! site = "corridor.toml"        # a site file beside this one; or its parts in place, as [site.grid], [[site.wall]] ...
//!
//! [run]
//! laps = 5                      # times along the site's route; on an open one, there and back
//! speed_m_s = 0.05
//! turn_rad_s = 1.0              # on the spot at corners
//! wander_rad_s = 0.02           # standard deviation of the pilot's turn rate
//!
//! [image]
//! period_ms = 400.0
//! capture_ms = 300.0
//! processing_ms = 100.0
//! exposure_ms = 37.5            # of a row; by default its share of the capture
//! blur_px = 0.5                 # standard deviations
//! noise_grey = 2.0
//!
//! [robot]                       # standard deviations, drawn anew for every run
//! wheel_difference_sigma = 0.002
//! axle_excess_sigma = 0.005
//! slip_mm_per_root_m = 1.0
//!
//! [start]                       # what the robot is told: standard deviations
//! position_sigma_mm = 5.0
//! heading_sigma_rad = 0.02
//!
//! [occlusion]
//! probability = 0.0             # of a thing before the lines, in an image
//!
//! [false_decodes]
//! rate = 0.0                    # of another payload, for a landmark in an image
//!
//! [kidnap]                      # left out: nothing of the kind
//! wrong_start = true            # the robot is told a start that is wrong
//! at = 0.5                      # the share of the ride at which it is carried elsewhere; left out: never
//! lifted_ms = 1000.0
//! ```
//!
//! All but the site may be left out; the values are the defaults, of the kidnapping an example.

mod check;
mod form;

use crate::site::{self, Fault, Site, SiteError};
use reference::world::Setup;
use std::path::Path;

/// What a scenario file says.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// Where it happens.
    pub site: Site,
    /// What happens there, seen by the e-puck's camera.
    pub setup: Setup,
}

/// Scenarios that are part of the program: their names and files.
pub const BUILT_IN: [(&str, &str); 2] = [("triangle", "triangle.toml"), ("kidnap", "kidnap.toml")];

/// The files of these scenarios.
const FILES: [(&str, &str); 3] = [
    ("triangle.toml", include_str!("../scenarios/triangle.toml")),
    ("kidnap.toml", include_str!("../scenarios/kidnap.toml")),
    ("corridor.toml", include_str!("../scenarios/corridor.toml")),
];

/// The built-in scenario of this name, or else the one that a file describes (SCENARIO-1, SCENARIO-7).
//= reference/SPEC.md#scenario
//# - **SCENARIO-7** `triangle` and `kidnap` MUST be known without a file.
pub fn load(name: &Path) -> Result<Scenario, SiteError> {
    match BUILT_IN.iter().find(|(built_in, _)| Path::new(built_in) == name) {
        Some((_, file)) => {
            let path = Path::new(file);
            of_toml(&built_in_file(path)?, path, built_in_file)
        }
        None => of_toml(&site::read(name)?, name, site::read),
    }
}

fn built_in_file(path: &Path) -> Result<String, SiteError> {
    let found = FILES.iter().find(|(name, _)| Path::new(name) == path);
    found.map(|(_, text)| (*text).to_owned()).ok_or_else(|| SiteError::whole_file(path, "is no built-in file"))
}

/// The scenario that a TOML text describes, under the name `path`; `read` gives the text of its site's file (SCENARIO-1,
/// SCENARIO-2).
//= reference/SPEC.md#scenario
//# - **SCENARIO-2** The site MUST be the path of a site file, from the scenario file's folder, or a table with the
//# parts of one (SITE-1), and have a route.
pub fn of_toml(
    text: &str,
    path: &Path,
    read: impl Fn(&Path) -> Result<String, SiteError>,
) -> Result<Scenario, SiteError> {
    let in_text = |fault: Fault| fault.in_file(path, text);
    let form = form::parse(text).map_err(in_text)?;
    let site = match &form.site {
        form::SiteEntry::InPlace(site) => site::of_form(site).map_err(in_text)?,
        form::SiteEntry::File(name) => {
            let beside = path.parent().unwrap_or(Path::new("")).join(name.get_ref());
            site::of_toml(&read(&beside)?, &beside)?
        }
    };
    let setup = check::setup(&form, &site).map_err(in_text)?;
    Ok(Scenario { site, setup })
}

#[cfg(test)]
mod tests;
