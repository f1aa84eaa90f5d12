//! A scenario file as it is written: keys, units, what may be left out (SCENARIO-1, SCENARIO-3).

use crate::site::{Fault, SiteForm, WITHOUT_UNIT, parse_with_units};
use core::ops::Range;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A number that may be left out.
pub(super) type Number = Option<Spanned<f64>>;

/// A scenario, with its site as the file has it.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ScenarioForm<S> {
    pub(super) site: S,
    #[serde(default)]
    pub(super) run: RunForm,
    #[serde(default)]
    pub(super) image: ImageForm,
    #[serde(default)]
    pub(super) robot: RobotForm,
    #[serde(default)]
    pub(super) start: StartForm,
    #[serde(default)]
    pub(super) occlusion: OcclusionForm,
    #[serde(default)]
    pub(super) false_decodes: FalseDecodesForm,
    #[serde(default)]
    pub(super) kidnap: KidnapForm,
}

/// A site in a file of its own, or in place.
#[derive(Debug)]
pub(super) enum SiteEntry {
    File(Spanned<String>),
    InPlace(Box<SiteForm>),
}

impl SiteEntry {
    /// Where a file's name is written; a site in place is spread over many tables.
    pub(super) fn span(&self) -> Range<usize> {
        match self {
            Self::File(name) => name.span(),
            Self::InPlace(_) => 0..0,
        }
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RunForm {
    pub(super) laps: Option<Spanned<i64>>,
    pub(super) speed_m_s: Number,
    pub(super) turn_rad_s: Number,
    pub(super) wander_rad_s: Number,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ImageForm {
    pub(super) period_ms: Number,
    pub(super) capture_ms: Number,
    pub(super) processing_ms: Number,
    pub(super) exposure_ms: Number,
    pub(super) blur_px: Number,
    pub(super) noise_grey: Number,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RobotForm {
    pub(super) wheel_difference_sigma: Number,
    pub(super) axle_excess_sigma: Number,
    pub(super) slip_mm_per_root_m: Number,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StartForm {
    pub(super) position_sigma_mm: Number,
    pub(super) heading_sigma_rad: Number,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct OcclusionForm {
    pub(super) probability: Number,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FalseDecodesForm {
    pub(super) rate: Number,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct KidnapForm {
    #[serde(default)]
    pub(super) wrong_start: bool,
    pub(super) at: Number,
    pub(super) lifted_ms: Number,
}

/// Keys with a unit, without it; beside a site's.
const UNITS: [(&str, &str); 14] = [
    ("speed", "speed_m_s"),
    ("turn", "turn_rad_s"),
    ("wander", "wander_rad_s"),
    ("period", "period_ms"),
    ("capture", "capture_ms"),
    ("processing", "processing_ms"),
    ("exposure", "exposure_ms"),
    ("blur", "blur_px"),
    ("noise", "noise_grey"),
    ("slip", "slip_mm_per_root_m"),
    ("position_sigma", "position_sigma_mm"),
    ("heading_sigma", "heading_sigma_rad"),
    ("lifted", "lifted_ms"),
    ("wheel_difference", "wheel_difference_sigma"),
];

/// The form that a text fills in.
//= reference/SPEC.md#scenario
//# - **SCENARIO-1** A scenario file MUST be TOML with the parts `site`, `run`, `image`, `robot`, `start`, `occlusion`,
//# `false_decodes` and `kidnap`, of which only `site` has to be there, and with its unit in every key that has one.
//= reference/SPEC.md#scenario
//# - **SCENARIO-3** Whatever is wrong MUST be reported as SITE-2 and SITE-3 say, in the site's own file if it is there.
pub(super) fn parse(text: &str) -> Result<ScenarioForm<SiteEntry>, Fault> {
    // An untagged alternative would lose the places of what is wrong in the site.
    let table = DeTable::parse(text)?;
    match table.get_ref().get("site").map(Spanned::get_ref) {
        Some(DeValue::Table(_)) => filled(text, |site| SiteEntry::InPlace(Box::new(site))),
        _ => filled(text, SiteEntry::File),
    }
}

fn filled<S: DeserializeOwned>(text: &str, entry: impl Fn(S) -> SiteEntry) -> Result<ScenarioForm<SiteEntry>, Fault> {
    let form: ScenarioForm<S> = parse_with_units(text, &[&WITHOUT_UNIT[..], &UNITS].concat())?;
    let ScenarioForm { site, run, image, robot, start, occlusion, false_decodes, kidnap } = form;
    Ok(ScenarioForm { site: entry(site), run, image, robot, start, occlusion, false_decodes, kidnap })
}
