//! From a scenario file's form to a setup: defaults, ranges, what has to fit together (SCENARIO-4 to SCENARIO-6).

use super::form::{ImageForm, KidnapForm, Number, RobotForm, ScenarioForm, SiteEntry, StartForm};
use crate::site::{Fault, Route, Site, Wall, positive, within};
use core::ops::Range;
use reference::frame::{Point, World};
use reference::motion::Drive;
use reference::world::{self, Disturbance, Imperfections, Lift, Place, Ride, Setup, Shutter, Told};
use toml::Spanned;

/// Most laps, and longest time in an image or a lift, milliseconds.
const MOST_LAPS: i64 = 100_000;
const LONGEST_MS: f64 = 60_000.0;

/// Fastest steps of an e-puck's wheel, 1/s.
const FASTEST_STEPS: f64 = 1000.0;

/// The most of a standard deviation of a wheel's or an axle's share: with three of them no wheel is left of its own size.
const MOST_SHARE: f64 = 0.3;

pub(super) fn setup(form: &ScenarioForm<SiteEntry>, site: &Site) -> Result<Setup, Fault> {
    let mut setup = Setup::new(place(site), ride(form, site)?);
    let sensor = &mut setup.place.sensor;
    sensor.blur = at_least_zero(&form.image.blur_px, sensor.blur, 100.0)?;
    sensor.noise = at_least_zero(&form.image.noise_grey, sensor.noise, 255.0)?;
    setup.shutter = shutter(&form.image, setup.place.camera.height)?;
    setup.imperfections = imperfections(&form.robot)?;
    setup.told = told(&form.start, form.kidnap.wrong_start)?;
    setup.lift = lift(&form.kidnap)?;
    setup.disturbance = Disturbance {
        occlusion: at_least_zero(&form.occlusion.probability, 0.0, 1.0)?,
        false_decodes: at_least_zero(&form.false_decodes.rate, 0.0, 1.0)?,
    };
    Ok(setup)
}

/// The site as the simulated robot has it.
fn place(site: &Site) -> Place {
    let point = |[x, y]: [f64; 2]| Point::new(x, y);
    let wall = |wall: &Wall| world::Wall { from: point(wall.from), to: point(wall.to) };
    Place {
        camera_in_robot: site.camera_in_robot,
        grid: site.grid,
        walls: site.walls.iter().map(wall).collect(),
        landmarks: site.landmarks.clone(),
        ..Place::default()
    }
}

/// A number from 0 to `most`, or the default.
fn at_least_zero(number: &Number, default: f64, most: f64) -> Result<f64, Fault> {
    let Some(number) = number else { return Ok(default) };
    let value = within(*number.get_ref(), most, number.span())?;
    if value < 0.0 { Err(Fault::new(number.span(), format!("{value} is below 0"))) } else { Ok(value) }
}

/// A number above 0, at most `most`, or the default.
fn above_zero(number: &Number, default: f64, most: f64) -> Result<f64, Fault> {
    number.as_ref().map_or(Ok(default), |number| positive(*number.get_ref(), most, number.span()))
}

/// Where a number is written; nowhere where it is left out.
fn span(number: &Number) -> Range<usize> {
    number.as_ref().map_or(0..0, Spanned::span)
}

/// SCENARIO-4: no wheel makes more steps than it can.
//= reference/SPEC.md#scenario
//# - **SCENARIO-4** Speeds MUST be above 0 and at most what 1000 steps a second allow, a correction of 0.3 rad/s
//# (WORLD-7) included.
fn ride(form: &ScenarioForm<SiteEntry>, site: &Site) -> Result<Ride, Fault> {
    let Some(route) = &site.route else { return Err(Fault::new(form.site.span(), "the scenario's site has no route")) };
    let form = &form.run;
    let drive = Drive::epuck();
    let fastest = FASTEST_STEPS * drive.step();
    let laps = match &form.laps {
        None => 5,
        Some(laps) => match u32::try_from(*laps.get_ref()) {
            Ok(count) if (1..=MOST_LAPS).contains(laps.get_ref()) => count,
            _ => return Err(Fault::new(laps.span(), format!("{} is not from 1 to {MOST_LAPS}", laps.get_ref()))),
        },
    };
    Ok(Ride {
        points: ring(route),
        laps,
        // A correction of up to 0.3 rad/s comes on top of the speed.
        speed: above_zero(&form.speed_m_s, 0.05, fastest - 0.3 * drive.axle / 2.0)?,
        turn: above_zero(&form.turn_rad_s, 1.0, fastest / (drive.axle / 2.0))?,
        wander: at_least_zero(&form.wander_rad_s, 0.02, 0.1)?,
    })
}

/// The route as a ring: an open one leads back through the points between its ends (SCENARIO-8).
//= reference/SPEC.md#scenario
//# - **SCENARIO-8** A lap of an open route MUST lead to its end and back.
fn ring(route: &Route) -> Vec<Point<World>> {
    let back = if route.closed { &[][..] } else { &route.points[1..route.points.len() - 1] };
    route.points.iter().chain(back.iter().rev()).map(|&[x, y]| Point::new(x, y)).collect()
}

/// SCENARIO-5.
//= reference/SPEC.md#scenario
//# - **SCENARIO-5** An image's period MUST be refused if it is shorter than capture and processing, and a row's
//# exposure if it is longer than its share of the capture.
fn shutter(form: &ImageForm, rows: usize) -> Result<Shutter, Fault> {
    let default = Shutter::default();
    let ms = |microseconds: u64| microseconds as f64 / 1000.0;
    let capture = above_zero(&form.capture_ms, ms(default.capture), 1000.0)?;
    let processing = at_least_zero(&form.processing_ms, ms(default.processing), LONGEST_MS)?;
    let period = above_zero(&form.period_ms, ms(default.period), LONGEST_MS)?;
    let share = capture / rows as f64;
    let exposure = above_zero(&form.exposure_ms, share, LONGEST_MS)?;
    let written = |numbers: [&Number; 3]| numbers.into_iter().find(|number| number.is_some()).map_or(0..0, span);
    if period < capture + processing {
        let place = written([&form.period_ms, &form.processing_ms, &form.capture_ms]);
        let busy = capture + processing;
        return Err(Fault::new(
            place,
            format!("a period of {period} ms is shorter than capture and processing, {busy} ms"),
        ));
    }
    if exposure > share {
        let what = format!("{exposure} ms is longer than a row's share of the capture, {share} ms");
        return Err(Fault::new(span(&form.exposure_ms), what));
    }
    let [capture, processing, period, exposure] = [capture, processing, period, exposure].map(microseconds);
    // What is rounded still fits together.
    let [processing, exposure] = [processing.min(period.saturating_sub(capture)), exposure.min(capture / rows as u64)];
    if exposure == 0 {
        return Err(Fault::new(written([&form.exposure_ms, &form.capture_ms, &None]), "is less than a microsecond"));
    }
    Ok(Shutter { period, capture, processing, exposure })
}

/// A time from 0 to [`LONGEST_MS`], in whole microseconds.
fn microseconds(ms: f64) -> u64 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 6e7")]
    let microseconds = (ms * 1000.0).round() as u64;
    microseconds
}

fn imperfections(form: &RobotForm) -> Result<Imperfections, Fault> {
    let default = Imperfections::default();
    Ok(Imperfections {
        wheel_difference: at_least_zero(&form.wheel_difference_sigma, default.wheel_difference, MOST_SHARE)?,
        axle_excess: at_least_zero(&form.axle_excess_sigma, default.axle_excess, MOST_SHARE)?,
        slip: at_least_zero(&form.slip_mm_per_root_m, default.slip * 1000.0, 100.0)? / 1000.0,
    })
}

fn told(form: &StartForm, wrong: bool) -> Result<Told, Fault> {
    let [x, _, heading] = Told::default().sigma;
    let position = at_least_zero(&form.position_sigma_mm, 1000.0 * x, 10_000.0)? / 1000.0;
    Ok(Told { sigma: [position, position, at_least_zero(&form.heading_sigma_rad, heading, 3.0)?], wrong })
}

/// SCENARIO-6.
//= reference/SPEC.md#scenario
//# - **SCENARIO-6** A kidnapping MUST be a start that is wrong (WORLD-19), a lift at a share of the ride from 0 to
//# below 1 (WORLD-20), or both.
fn lift(form: &KidnapForm) -> Result<Option<Lift>, Fault> {
    let lasts = microseconds(above_zero(&form.lifted_ms, 1000.0, LONGEST_MS)?);
    if form.at.is_none() {
        return match &form.lifted_ms {
            Some(lifted) => Err(Fault::new(lifted.span(), "says how long the robot is lifted, but not at which share")),
            None => Ok(None),
        };
    }
    let at = at_least_zero(&form.at, 0.0, 1.0)?;
    if at >= 1.0 { Err(Fault::new(span(&form.at), "1 is the end of the ride")) } else { Ok(Some(Lift { at, lasts })) }
}
