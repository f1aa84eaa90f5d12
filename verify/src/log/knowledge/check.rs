//! From the form of `robot.toml` to what the robot knows: ranges and defaults (LOG-7, LOG-15 to LOG-17).

use super::form::{KnowledgeForm, ListedForm, RobotForm, StartForm};
use super::{Knowledge, Landmarks, Listed, Mounting, Start, States, Wheels};
use crate::input::key_of;
use crate::log::{LARGEST_ANGLE, LARGEST_COORDINATE};
use crate::site::check::{grid, identifier_payload, positive, within};
use crate::site::fault::Fault;
use core::ops::Range;
use reference::camera::Camera;
use reference::grid::{Grid, field_bits};
use reference::landmark::Format;
use toml::Spanned;
use toml::de::DeTable;

/// Largest wheel and axle, metres.
const LARGEST_WHEEL: f64 = 1.0;
const LARGEST_AXLE: f64 = 10.0;

/// How far from the axle's middle a camera may stand, millimetres.
const FARTHEST_MOUNTED: f64 = 1000.0;

/// Most steps of a turn.
const MOST_STEPS: f64 = 1e6;

/// Largest standard deviation of a heading, radians: beyond it nothing is known of it.
const LARGEST_HEADING_DEVIATION: f64 = 10.0;

pub(super) fn knowledge(form: &KnowledgeForm, text: &str) -> Result<Knowledge, Fault> {
    let formats = formats(form)?;
    Ok(Knowledge {
        landmarks: landmarks(form, &formats)?,
        formats,
        camera: camera(form, text)?,
        mounting: mounting(form.robot.as_ref().unwrap_or(&RobotForm::default()))?,
        wheels: wheels(form.robot.as_ref().unwrap_or(&RobotForm::default()))?,
        start: start(form.start.as_ref().unwrap_or(&StartForm::default()))?,
        states: states(form)?,
        observe: form.observe.unwrap_or_default(),
        stamp: form.stamp.unwrap_or_default(),
    })
}

/// A number that may be left out.
fn read(value: Option<&Spanned<f64>>, default: f64, most: f64) -> Result<f64, Fault> {
    value.map_or(Ok(default), |value| within(*value.get_ref(), most, value.span()))
}

/// A number above 0 that may be left out, in units of which there are `per` in one of the result's.
fn size(value: Option<&Spanned<f64>>, default: f64, most: f64, per: f64) -> Result<f64, Fault> {
    value.map_or(Ok(default), |value| Ok(positive(*value.get_ref(), most * per, value.span())? / per))
}

fn states(form: &KnowledgeForm) -> Result<States, Fault> {
    let Some(states) = &form.states else { return Ok(States::default()) };
    match states.get_ref() {
        3 => Ok(States::Three),
        5 => Ok(States::Five),
        other => Err(Fault::new(states.span(), format!("{other} is neither 3 nor 5"))),
    }
}

/// Those that are named, or those of the table, or all; each once, `paper` first.
fn formats(form: &KnowledgeForm) -> Result<Vec<Format>, Fault> {
    let of_all = |wanted: &[Format]| Format::ALL.into_iter().filter(|format| wanted.contains(format)).collect();
    let listed: Vec<Format> = form.landmark.iter().map(|entry| entry.get_ref().format.into()).collect();
    let Some(named) = &form.formats else {
        return Ok(of_all(if listed.is_empty() { &Format::ALL } else { &listed }));
    };
    let wanted: Vec<Format> = named.get_ref().iter().map(|&format| format.into()).collect();
    if wanted.is_empty() {
        return Err(Fault::new(named.span(), "names no format"));
    }
    if listed.iter().any(|format| !wanted.contains(format)) {
        return Err(Fault::new(named.span(), "leaves out the format of a landmark"));
    }
    Ok(of_all(&wanted))
}

fn landmarks(form: &KnowledgeForm, formats: &[Format]) -> Result<Landmarks, Fault> {
    let Some(grid_form) = &form.grid else {
        let none = form.landmark.is_empty();
        return if none { Ok(Landmarks::Grid(Grid::default())) } else { table(&form.landmark).map(Landmarks::Table) };
    };
    if let Some(entry) = form.landmark.first() {
        return Err(Fault::new(entry.span(), "there is a grid as well; landmarks have poses by one or the other"));
    }
    let grid = grid(grid_form.get_ref())?;
    within_reach(&grid, formats, grid_form.span())?;
    Ok(Landmarks::Grid(grid))
}

/// Every pose of a grid is within what a log may have (LOG-7).
fn within_reach(grid: &Grid, formats: &[Format], span: Range<usize>) -> Result<(), Fault> {
    for &format in formats {
        let [x_bits, y_bits, _] = field_bits(format);
        for (axis, bits) in [x_bits, y_bits].into_iter().enumerate() {
            let last = grid.origin[axis] + f64::from((1_u32 << bits) - 1) * grid.step[axis];
            if grid.origin[axis].abs().max(last.abs()) > LARGEST_COORDINATE {
                let name = crate::certificate::format_name(format);
                let what = format!("the grid of format {name} reaches beyond ±{LARGEST_COORDINATE} m");
                return Err(Fault::new(span, what));
            }
        }
    }
    Ok(())
}

/// LOG-17.
//= reference/SPEC.md#log
//# - **LOG-17** A table of landmarks MUST give each a format, an identifier that can be encoded (CODE-5, CODE-6), and a
//# pose, and no two of them the same format and identifier.
fn table(entries: &[Spanned<ListedForm>]) -> Result<Vec<Listed>, Fault> {
    let mut table: Vec<Listed> = Vec::new();
    for entry in entries {
        let listed = listed(entry.get_ref())?;
        let same = |other: &Listed| (other.format, other.identifier) == (listed.format, listed.identifier);
        if let Some(i) = table.iter().position(same) {
            let what = format!("landmark[{}] has the same identifier and format", i + 1);
            return Err(Fault::new(entry.get_ref().identifier.span(), what));
        }
        table.push(listed);
    }
    Ok(table)
}

fn listed(form: &ListedForm) -> Result<Listed, Fault> {
    let format = form.format.into();
    Ok(Listed {
        format,
        identifier: identifier_payload(format, &form.identifier)?,
        x: read(Some(&form.x_m), 0.0, LARGEST_COORDINATE)?,
        y: read(Some(&form.y_m), 0.0, LARGEST_COORDINATE)?,
        heading: read(Some(&form.heading_deg), 0.0, 360.0)?.to_radians(),
    })
}

fn camera(form: &KnowledgeForm, text: &str) -> Result<Camera, Fault> {
    let Some(file) = &form.camera else { return Ok(Camera::epuck()) };
    file.get_ref().camera().map_err(|refusal| {
        let table = DeTable::parse(text).ok();
        let camera = table.as_ref().and_then(|table| table.get_ref().get("camera"));
        let key = camera.and_then(|camera| camera.get_ref().as_table()?.get(key_of(refusal)));
        Fault::new(key.map_or_else(|| file.span(), Spanned::span), refusal.to_string())
    })
}

/// Millimetres that may be left out, as metres.
fn millimetres(value: Option<&Spanned<f64>>, default: f64) -> Result<f64, Fault> {
    value.map_or(Ok(default), |value| Ok(within(*value.get_ref(), FARTHEST_MOUNTED, value.span())? / 1000.0))
}

fn mounting(form: &RobotForm) -> Result<Mounting, Fault> {
    let default = Knowledge::default().mounting;
    Ok(Mounting {
        x: millimetres(form.camera_x_mm.as_ref(), default.x)?,
        y: millimetres(form.camera_y_mm.as_ref(), default.y)?,
        heading: read(form.camera_heading_deg.as_ref(), 0.0, 360.0)?.to_radians(),
    })
}

fn wheels(form: &RobotForm) -> Result<Wheels, Fault> {
    let default = Knowledge::default().wheels;
    Ok(Wheels {
        diameter: size(form.wheel_diameter_mm.as_ref(), default.diameter, LARGEST_WHEEL, 1000.0)?,
        axle: size(form.axle_mm.as_ref(), default.axle, LARGEST_AXLE, 1000.0)?,
        steps_per_turn: size(form.steps_per_turn.as_ref(), default.steps_per_turn, MOST_STEPS, 1.0)?,
    })
}

fn start(form: &StartForm) -> Result<Start, Fault> {
    let default = Knowledge::default().start;
    let [x, y, theta] = default.deviations;
    Ok(Start {
        x: read(form.x_m.as_ref(), default.x, LARGEST_COORDINATE)?,
        y: read(form.y_m.as_ref(), default.y, LARGEST_COORDINATE)?,
        theta: read(form.theta_rad.as_ref(), default.theta, LARGEST_ANGLE)?,
        deviations: [
            size(form.deviation_x_m.as_ref(), x, LARGEST_COORDINATE, 1.0)?,
            size(form.deviation_y_m.as_ref(), y, LARGEST_COORDINATE, 1.0)?,
            size(form.deviation_theta_rad.as_ref(), theta, LARGEST_HEADING_DEVIATION, 1.0)?,
        ],
    })
}
