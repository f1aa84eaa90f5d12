//! `robot.toml` as it is written: keys, units, what may be left out (LOG-15).

use super::{Observe, Stamp};
use crate::input::CameraFile;
use crate::site::fault::Fault;
use crate::site::form::{FormatForm, GridForm, WITHOUT_UNIT, units};
use serde::Deserialize;
use toml::Spanned;
use toml::de::DeTable;

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct KnowledgeForm {
    pub(super) states: Option<Spanned<i64>>,
    pub(super) observe: Option<Observe>,
    pub(super) stamp: Option<Stamp>,
    pub(super) formats: Option<Spanned<Vec<FormatForm>>>,
    pub(super) grid: Option<Spanned<GridForm>>,
    #[serde(default)]
    pub(super) landmark: Vec<Spanned<ListedForm>>,
    pub(super) camera: Option<Spanned<CameraFile>>,
    pub(super) robot: Option<RobotForm>,
    pub(super) start: Option<StartForm>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ListedForm {
    #[serde(default)]
    pub(super) format: FormatForm,
    pub(super) identifier: Spanned<i64>,
    pub(super) x_m: Spanned<f64>,
    pub(super) y_m: Spanned<f64>,
    pub(super) heading_deg: Spanned<f64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RobotForm {
    pub(super) camera_x_mm: Option<Spanned<f64>>,
    pub(super) camera_y_mm: Option<Spanned<f64>>,
    pub(super) camera_heading_deg: Option<Spanned<f64>>,
    pub(super) wheel_diameter_mm: Option<Spanned<f64>>,
    pub(super) axle_mm: Option<Spanned<f64>>,
    pub(super) steps_per_turn: Option<Spanned<f64>>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StartForm {
    pub(super) x_m: Option<Spanned<f64>>,
    pub(super) y_m: Option<Spanned<f64>>,
    pub(super) theta_rad: Option<Spanned<f64>>,
    pub(super) deviation_x_m: Option<Spanned<f64>>,
    pub(super) deviation_y_m: Option<Spanned<f64>>,
    pub(super) deviation_theta_rad: Option<Spanned<f64>>,
}

/// Keys with a unit, without it, that a site file does not have.
const MORE_WITHOUT_UNIT: [(&str, &str); 10] = [
    ("wheel_diameter", "wheel_diameter_mm"),
    ("axle", "axle_mm"),
    ("theta", "theta_rad"),
    ("deviation_x", "deviation_x_m"),
    ("deviation_y", "deviation_y_m"),
    ("deviation_theta", "deviation_theta_rad"),
    ("width", "width_px"),
    ("height", "height_px"),
    ("focal_length", "focal_length_px"),
    ("principal_column", "principal_column_px"),
];

/// The form that a text fills in.
//= reference/SPEC.md#log
//# - **LOG-15** What a robot knows MUST be TOML with the parts `grid` or `landmark`, `camera`, `robot` and `start` and
//# the keys `states`, `observe`, `stamp` and `formats`, with its unit in every key that has one, and be refused as a
//# site file is (SITE-2, SITE-3).
pub(super) fn parse(text: &str) -> Result<KnowledgeForm, Fault> {
    let table = DeTable::parse(text)?;
    units(table.get_ref(), &WITHOUT_UNIT)?;
    units(table.get_ref(), &MORE_WITHOUT_UNIT)?;
    Ok(toml::from_str(text)?)
}
