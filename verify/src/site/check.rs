//! From a site file's form to a site: sizes, ranges, grid (SITE-3, SITE-4, SITE-6 to SITE-8).

use super::fault::Fault;
use super::form::{
    CAMERA_AHEAD_MM, Exactly, FaceForm, GridForm, LandmarkForm, Pair, RegionForm, RobotForm, RouteForm, SiteForm,
    WallForm,
};
use super::{LARGEST_COORDINATE, Region, Route, Site, Wall, hang};
use core::ops::Range;
use reference::codeword::{self, EncodeRefusal};
use reference::frame::{self, Camera, Pose, Robot, World};
use reference::grid::{Codes, Grid, field_bits};
use reference::landmark::{Format, Landmark, STRIPE_HEIGHT, STRIPE_WIDTH};
use reference::render::Posted;
use toml::Spanned;

/// Shortest wall and leg of a route, metres (SITE-3).
const SHORTEST: f64 = 1e-3;

/// Tallest stripe, metres: no robot of this kind sees more.
const TALLEST_STRIPE: f64 = 1.0;

pub(crate) fn site(form: &SiteForm) -> Result<Site, Fault> {
    let grid = form.grid.as_ref().map_or(Ok(Grid::default()), grid)?;
    let camera_in_robot = form.robot.as_ref().map_or(Ok(Site::default().camera_in_robot), robot)?;
    let walls = form.wall.iter().map(wall).collect::<Result<Vec<_>, _>>()?;
    let mut landmarks: Vec<Posted> = Vec::new();
    for entry in &form.landmark {
        let posted = landmark(&grid, entry)?;
        let heading = entry.get_ref().heading_deg.as_ref();
        hang::on_wall(&walls, &posted).map_err(|off| {
            let span = if off.is_heading() { heading.map(Spanned::span) } else { None };
            Fault::new(span.unwrap_or_else(|| pose_span(entry)), off.to_string())
        })?;
        for (i, other) in landmarks.iter().enumerate() {
            distinct(&posted, other)
                .map_err(|what| Fault::new(pose_span(entry), format!("{what} landmark[{}]", i + 1)))?;
        }
        landmarks.push(posted);
    }
    let route = form.route.as_ref().map(route).transpose()?;
    let region = form.region.as_ref().map(region).transpose()?;
    Ok(Site { grid, camera_in_robot, walls, landmarks, route, region })
}

/// A finite number of at most `most` in absolute value (SITE-3).
//= reference/SPEC.md#site
//# - **SITE-3** Unknown keys, keys without their unit, numbers that are not finite, sizes that are not above 0, walls
//# and legs shorter than 1 mm, and coordinates beyond 1000 m MUST be refused.
pub(crate) fn within(value: f64, most: f64, span: Range<usize>) -> Result<f64, Fault> {
    if value.is_nan() || value.is_infinite() {
        Err(Fault::new(span, format!("{value} is not a finite number")))
    } else if value.abs() > most {
        Err(Fault::new(span, format!("{value} is too large; the most is {most}")))
    } else {
        Ok(value)
    }
}

/// A finite number above 0 (SITE-3).
pub(crate) fn positive(value: f64, most: f64, span: Range<usize>) -> Result<f64, Fault> {
    let value = within(value, most, span.clone())?;
    if value > 0.0 { Ok(value) } else { Err(Fault::new(span, format!("{value} is not above 0"))) }
}

fn point(pair: &Pair) -> Result<[f64; 2], Fault> {
    let Exactly([x, y]) = *pair.get_ref();
    Ok([within(x, LARGEST_COORDINATE, pair.span())?, within(y, LARGEST_COORDINATE, pair.span())?])
}

pub(crate) fn grid(form: &GridForm) -> Result<Grid, Fault> {
    let default = Grid::default();
    let step = match &form.step_mm {
        None => default.step,
        Some(pair) => {
            let Exactly([x, y]) = *pair.get_ref();
            let most = 1000.0 * LARGEST_COORDINATE;
            [positive(x, most, pair.span())? / 1000.0, positive(y, most, pair.span())? / 1000.0]
        }
    };
    let theta_steps = match &form.theta_steps {
        None => None,
        Some(steps) => Some(match u32::try_from(*steps.get_ref()) {
            Ok(count @ 1..=16) => count,
            _ => return Err(Fault::new(steps.span(), format!("{} is not from 1 to 16", steps.get_ref()))),
        }),
    };
    Ok(Grid { origin: form.origin_m.as_ref().map_or(Ok(default.origin), point)?, step, theta_steps })
}

/// SITE-8.
fn robot(form: &RobotForm) -> Result<Pose<Robot, Camera>, Fault> {
    let read = |value: &Option<Spanned<f64>>, default: f64, most: f64| {
        value.as_ref().map_or(Ok(default), |value| within(*value.get_ref(), most, value.span()))
    };
    let x = read(&form.camera_x_mm, CAMERA_AHEAD_MM, 1000.0 * LARGEST_COORDINATE)?;
    let y = read(&form.camera_y_mm, 0.0, 1000.0 * LARGEST_COORDINATE)?;
    let heading = read(&form.camera_heading_deg, 0.0, 360.0)?;
    Ok(Pose::new(x / 1000.0, y / 1000.0, heading.to_radians()))
}

fn wall(entry: &Spanned<WallForm>) -> Result<Wall, Fault> {
    let form = entry.get_ref();
    let face = form.face;
    let wall = Wall {
        from: point(&form.from_m)?,
        to: point(&form.to_m)?,
        left: matches!(face, FaceForm::Left | FaceForm::Both),
        right: matches!(face, FaceForm::Right | FaceForm::Both),
    };
    if wall.length() < SHORTEST {
        return Err(Fault::new(form.to_m.span(), "the wall is shorter than 1 mm"));
    }
    Ok(wall)
}

/// Where a landmark's pose is written.
fn pose_span(entry: &Spanned<LandmarkForm>) -> Range<usize> {
    let form = entry.get_ref();
    let codes = form.codes.as_ref().map(Spanned::span);
    codes.or_else(|| form.x_m.as_ref().map(Spanned::span)).unwrap_or_else(|| entry.span())
}

fn landmark(grid: &Grid, entry: &Spanned<LandmarkForm>) -> Result<Posted, Fault> {
    let form = entry.get_ref();
    let landmark = dimensions(form)?;
    let landmark_in_world = pose(grid, landmark.format, entry)?;
    let payload = match &form.identifier {
        Some(identifier) => identifier_payload(landmark.format, identifier)?,
        //= reference/SPEC.md#site
        //# - **SITE-6** A landmark MUST carry the payload of its pose (GRID), or else the identifier that it is given,
        //# if it can be encoded (CODE-5, CODE-6).
        // SITE-6
        None => grid
            .payload(landmark.format, &landmark_in_world)
            .map_err(|refusal| Fault::new(pose_span(entry), refusal.to_string()))?,
    };
    Ok(Posted { landmark_in_world, landmark, payload })
}

fn dimensions(form: &LandmarkForm) -> Result<Landmark, Fault> {
    let mut landmark =
        Landmark { stripe_width: STRIPE_WIDTH, stripe_height: STRIPE_HEIGHT, format: form.format.into() };
    if let Some(height) = &form.stripe_height_mm {
        landmark.stripe_height = positive(*height.get_ref(), 1000.0 * TALLEST_STRIPE, height.span())? / 1000.0;
    }
    if let Some(width) = &form.stripe_width_mm {
        landmark.stripe_width = positive(*width.get_ref(), 1000.0, width.span())? / 1000.0;
        return landmark.checked().map_err(|refusal| Fault::new(width.span(), refusal.to_string()));
    }
    Ok(landmark)
}

/// The pose by codes or by world coordinates, never both (SITE-4).
//= reference/SPEC.md#site
//# - **SITE-4** A landmark's pose MUST be given either as the codes of the grid or as world coordinates and heading.
fn pose(grid: &Grid, format: Format, entry: &Spanned<LandmarkForm>) -> Result<Pose<World, frame::Landmark>, Fault> {
    let form = entry.get_ref();
    match (&form.codes, &form.x_m, &form.y_m, &form.heading_deg) {
        (Some(codes), None, None, None) => coded_pose(grid, format, codes),
        (None, Some(x), Some(y), Some(heading)) => {
            let metres = |value: &Spanned<f64>| within(*value.get_ref(), LARGEST_COORDINATE, value.span());
            let heading = within(*heading.get_ref(), 360.0, heading.span())?;
            Ok(Pose::new(metres(x)?, metres(y)?, heading.to_radians()))
        }
        (Some(codes), ..) => Err(Fault::new(codes.span(), "a landmark has either codes or x_m, y_m and heading_deg")),
        _ => Err(Fault::new(pose_span(entry), "a landmark needs codes, or all of x_m, y_m and heading_deg")),
    }
}

fn coded_pose(
    grid: &Grid,
    format: Format,
    codes: &Spanned<Exactly<i64, 3>>,
) -> Result<Pose<World, frame::Landmark>, Fault> {
    let [x_bits, y_bits, _] = field_bits(format);
    let limits = [1 << x_bits, 1 << y_bits, grid.headings(format)];
    let mut fields = [0; 3];
    for ((field, code), limit) in fields.iter_mut().zip(codes.get_ref().0).zip(limits) {
        let fits = u32::try_from(code).ok().filter(|&code| code < limit);
        *field =
            fits.ok_or_else(|| Fault::new(codes.span(), format!("{code} is not a code from 0 to {}", limit - 1)))?;
    }
    let [x, y, theta] = fields;
    Ok(grid.pose(format, Codes { x, y, theta }))
}

/// An identifier is a payload that stands for no pose (SITE-6).
pub(crate) fn identifier_payload(format: Format, identifier: &Spanned<i64>) -> Result<u32, Fault> {
    let fault = |what: &str| Fault::new(identifier.span(), what);
    let payload = u32::try_from(*identifier.get_ref()).map_err(|_| fault("does not fit the landmark's format"))?;
    match codeword::encode(format, payload) {
        Ok(_) => Ok(payload),
        Err(EncodeRefusal::TooLarge) => Err(fault("does not fit the landmark's format")),
        Err(EncodeRefusal::EqualHalves) => Err(fault("both layers of this identifier's code word would look the same")),
    }
}

/// What two landmarks of a site may not have in common (SITE-7).
//= reference/SPEC.md#site
//# - **SITE-7** Two landmarks of which one's barcode reaches into the other's barcode or quiet zone, or that carry the
//# same payload in the same format, MUST be refused.
fn distinct(one: &Posted, other: &Posted) -> Result<(), &'static str> {
    if hang::overlap(one, other) {
        Err("its barcode or quiet zone overlaps")
    } else if one.payload == other.payload && one.landmark.format == other.landmark.format {
        Err("it carries the same payload as")
    } else {
        Ok(())
    }
}

fn route(form: &RouteForm) -> Result<Route, Fault> {
    let points = form.points_m.get_ref().iter().map(point).collect::<Result<Vec<_>, _>>()?;
    if points.len() < 2 {
        return Err(Fault::new(form.points_m.span(), "a route has at least two points"));
    }
    for (i, ([a, b], entry)) in super::line::sides(&points).zip(form.points_m.get_ref()).enumerate() {
        let last = i + 1 == points.len();
        if (form.closed || !last) && (b[0] - a[0]).hypot(b[1] - a[1]) < SHORTEST {
            return Err(Fault::new(entry.span(), "the route's next point is less than 1 mm away"));
        }
    }
    Ok(Route { points, closed: form.closed })
}

fn region(form: &RegionForm) -> Result<Region, Fault> {
    let mut rings = Vec::new();
    for ring in std::iter::once(&form.polygon_m).chain(&form.holes_m) {
        let points = ring.get_ref().iter().map(point).collect::<Result<Vec<_>, _>>()?;
        if points.len() < 3 {
            return Err(Fault::new(ring.span(), "a polygon has at least three points"));
        }
        let doubled: f64 = super::line::sides(&points).map(|[a, b]| a[0] * b[1] - b[0] * a[1]).sum();
        if doubled.abs() < SHORTEST * SHORTEST {
            return Err(Fault::new(ring.span(), "the polygon encloses no area"));
        }
        rings.push(points);
    }
    Ok(Region { rings })
}
