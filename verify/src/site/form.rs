//! A site file as it is written: keys, units, what may be left out (SITE-1, SITE-8).

use super::fault::Fault;
use reference::landmark::Format;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// How far the camera stands ahead of the robot's axle, millimetres (SITE-8).
//= reference/SPEC.md#site
//# - **SITE-8** The camera MUST stand 30 mm ahead of the middle of the robot's axle and look ahead, if the file does
//# not say otherwise.
pub(super) const CAMERA_AHEAD_MM: f64 = 30.0;

/// Coordinates x and y.
pub(crate) type Pair = Spanned<Exactly<f64, 2>>;

/// Just so many numbers: an array of serde's would leave those that are too many unread.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "Vec<T>")]
pub(crate) struct Exactly<T, const N: usize>(pub(crate) [T; N]);

impl<T, const N: usize> TryFrom<Vec<T>> for Exactly<T, N> {
    type Error = String;

    fn try_from(numbers: Vec<T>) -> Result<Self, String> {
        let numbers = <[T; N]>::try_from(numbers);
        numbers.map(Self).map_err(|numbers| format!("has {} numbers where {N} are expected", numbers.len()))
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SiteForm {
    pub(super) grid: Option<GridForm>,
    pub(super) robot: Option<RobotForm>,
    #[serde(default)]
    pub(super) wall: Vec<Spanned<WallForm>>,
    #[serde(default)]
    pub(super) landmark: Vec<Spanned<LandmarkForm>>,
    pub(super) route: Option<RouteForm>,
    pub(super) region: Option<RegionForm>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct GridForm {
    pub(crate) step_mm: Option<Pair>,
    pub(crate) origin_m: Option<Pair>,
    pub(crate) theta_steps: Option<Spanned<i64>>,
}

#[expect(clippy::struct_field_names, reason = "the file's keys; other parts of a robot may follow")]
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RobotForm {
    pub(super) camera_x_mm: Option<Spanned<f64>>,
    pub(super) camera_y_mm: Option<Spanned<f64>>,
    pub(super) camera_heading_deg: Option<Spanned<f64>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WallForm {
    pub(super) from_m: Pair,
    pub(super) to_m: Pair,
    pub(super) face: FaceForm,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum FaceForm {
    Left,
    Right,
    Both,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LandmarkForm {
    pub(super) codes: Option<Spanned<Exactly<i64, 3>>>,
    pub(super) x_m: Option<Spanned<f64>>,
    pub(super) y_m: Option<Spanned<f64>>,
    pub(super) heading_deg: Option<Spanned<f64>>,
    #[serde(default)]
    pub(super) format: FormatForm,
    pub(super) identifier: Option<Spanned<i64>>,
    pub(super) stripe_width_mm: Option<Spanned<f64>>,
    pub(super) stripe_height_mm: Option<Spanned<f64>>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum FormatForm {
    #[default]
    Paper,
    Wide,
}

impl From<FormatForm> for Format {
    fn from(form: FormatForm) -> Self {
        match form {
            FormatForm::Paper => Self::Paper,
            FormatForm::Wide => Self::Wide,
        }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RouteForm {
    pub(super) points_m: Spanned<Vec<Pair>>,
    #[serde(default)]
    pub(super) closed: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RegionForm {
    pub(super) polygon_m: Spanned<Vec<Pair>>,
    #[serde(default)]
    pub(super) holes_m: Vec<Spanned<Vec<Pair>>>,
}

/// Keys with a unit, without it.
pub(crate) const WITHOUT_UNIT: [(&str, &str); 14] = [
    ("step", "step_mm"),
    ("origin", "origin_m"),
    ("camera_x", "camera_x_mm"),
    ("camera_y", "camera_y_mm"),
    ("camera_heading", "camera_heading_deg"),
    ("from", "from_m"),
    ("to", "to_m"),
    ("x", "x_m"),
    ("y", "y_m"),
    ("heading", "heading_deg"),
    ("stripe_width", "stripe_width_mm"),
    ("stripe_height", "stripe_height_mm"),
    ("points", "points_m"),
    ("polygon", "polygon_m"),
];

/// The form that a text fills in (SITE-1).
//= reference/SPEC.md#site
//# - **SITE-1** A site file MUST be TOML with the parts `grid`, `robot`, `wall`, `landmark`, `route` and `region`, each
//# of which may be left out, and with its unit in every key that has one (`_m`, `_mm`, `_deg`).
pub(super) fn parse(text: &str) -> Result<SiteForm, Fault> {
    parse_with_units(text, &WITHOUT_UNIT)
}

/// The form that a text fills in, where the given keys, each with its unit, do not stand without it.
pub(crate) fn parse_with_units<T: DeserializeOwned>(text: &str, without_unit: &[(&str, &str)]) -> Result<T, Fault> {
    let table = DeTable::parse(text)?;
    units(table.get_ref(), without_unit)?;
    Ok(toml::from_str(text)?)
}

/// Refuses keys that lack their unit: "unknown field" would not say what is missing.
pub(crate) fn units(table: &DeTable<'_>, without_unit: &[(&str, &str)]) -> Result<(), Fault> {
    for (name, value) in table {
        if let Some((_, key)) = without_unit.iter().find(|(bare, _)| *bare == name.get_ref()) {
            return Err(Fault::new(name.span(), format!("has no unit; write {key}")));
        }
        match value.get_ref() {
            DeValue::Table(table) => units(table, without_unit)?,
            DeValue::Array(items) => {
                for item in items {
                    if let DeValue::Table(table) = item.get_ref() {
                        units(table, without_unit)?;
                    }
                }
            }
            _ => {}
        }
    }
    Ok(())
}
