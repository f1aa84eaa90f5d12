//! A site from above with the paths of a run, to scale, as in the paper's Fig. 11. North of the page is y.

use super::frame::{Frame, Pixel, Scale, apart, near};
use super::sign::{Entry, Sign, draw_carried, draw_legend, estimate_line, legend_height, odometry_line, truth_line};
use super::{Has, MARGIN, Page, Pose, Sample, WIDTH, count, draw_title, lifts, text_style, title_height};
use crate::drawing::DrawingError;
use crate::drawing::area::{grid_step, whole};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// The most that the chart is wide and high, pixels.
const CHART: (f64, f64) = (1280.0, 1500.0);
/// Room for the numbers and the name of an axis, left and below, pixels.
const LABELS: (i32, i32) = (140, 100);
/// Room for the legend beside the chart, pixels.
const LEGEND: i32 = 490;
/// White between the chart and its legend, pixels.
const GAP: i32 = 36;
/// From the outermost things to the frame: room for the landmarks' numbers, pixels.
const BORDER: f64 = 76.0;
/// How far a path that strays is followed beyond everything else, as a part of the larger side.
const STRAYS: f64 = 0.15;
/// The grid's steps along the larger side, at most.
const STEPS: f64 = 10.0;
/// From a dot or a cross to others of its kind, pixels at least.
const DOTS: i32 = 12;
/// The signs where the robot and the estimate begin are drawn beside each other if they are so far apart, pixels.
const START: i32 = 30;
/// From a landmark's place on its wall to its number behind the wall, pixels.
const NUMBER: f64 = 32.0;

/// A landmark on a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landmark {
    /// Where its centre is and where it looks: along the wall's normal.
    pub pose: Pose,
    /// How wide it is, metres; it is drawn at least so wide that it is seen.
    pub width: f64,
}

/// What is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Map<'a> {
    /// Lines of about 100 characters; the first one is bold.
    pub title: &'a str,
    /// The ends of the walls, `[x, y]` in metres.
    pub walls: &'a [[[f64; 2]; 2]],
    /// They are numbered from 1 in this order.
    pub landmarks: &'a [Landmark],
    /// The run.
    pub samples: &'a [Sample],
}

/// The drawing as the text of an SVG file, the same for the same input.
pub fn draw(map: &Map<'_>) -> Result<String, DrawingError> {
    let frame = frame(map);
    let [left, _, right, bottom] = frame.sides();
    let entries = entries(map, &frame);
    let legend = frame.corner.1 + legend_height(1, &entries);
    let height = (bottom + LABELS.1).max(legend) + MARGIN;
    let mut svg = String::new();
    {
        let page = SVGBackend::with_string(&mut svg, (WIDTH.unsigned_abs(), height.unsigned_abs())).into_drawing_area();
        page.fill(&WHITE)?;
        draw_title(&page, left, map.title)?;
        frame.draw_grid(&page, Some("x (m)"), "y (m)")?;
        draw_site(&page, &frame, map)?;
        draw_paths(&page, &frame, map.samples)?;
        draw_marks(&page, &frame, map.samples)?;
        draw_legend(&page, (right + GAP, frame.corner.1), (1, LEGEND), &entries)?;
        page.present()?;
    }
    Ok(svg)
}

/// The least and the largest coordinates of points, metres.
#[derive(Clone, Copy, Debug)]
struct Extent {
    low: [f64; 2],
    high: [f64; 2],
}

impl Extent {
    /// Of the finite ones of points; of none, a metre around the origin.
    fn of(points: impl Iterator<Item = [f64; 2]>) -> Self {
        let finite = points.filter(|point| point.iter().all(|value| value.is_finite()));
        let around = finite.fold(None, |extent: Option<Self>, point| {
            let Self { low, high } = extent.unwrap_or(Self { low: point, high: point });
            let each = |pick: fn(f64, f64) -> f64, ends: [f64; 2]| [pick(ends[0], point[0]), pick(ends[1], point[1])];
            Some(Self { low: each(f64::min, low), high: each(f64::max, high) })
        });
        around.unwrap_or(Self { low: [-0.5; 2], high: [0.5; 2] })
    }

    fn larger_side(&self) -> f64 {
        (self.high[0] - self.low[0]).max(self.high[1] - self.low[1])
    }

    /// With other points as well, but by no more than a margin in metres.
    fn stretched(self, points: impl Iterator<Item = [f64; 2]>, most: f64) -> Self {
        let other = Self::of(points.chain([self.low, self.high]));
        let low = [0, 1].map(|axis| other.low[axis].max(self.low[axis] - most));
        let high = [0, 1].map(|axis| other.high[axis].min(self.high[axis] + most));
        Self { low, high }
    }
}

fn place(pose: &Pose) -> [f64; 2] {
    [pose[0], pose[1]]
}

/// Everything that belongs to the site and the true path, and of the other paths what is not far off, at one scale.
fn frame(map: &Map<'_>) -> Frame {
    let walls = map.walls.iter().flatten().copied();
    let landmarks = map.landmarks.iter().map(|landmark| place(&landmark.pose));
    let truth = map.samples.iter().filter(|sample| !sample.lifted).map(|sample| place(&sample.truth));
    let site = Extent::of(walls.chain(landmarks).chain(truth));
    let beliefs = map.samples.iter().flat_map(|sample| [Some(sample.estimate), sample.odometry]);
    let strays = beliefs.flatten().map(|pose| place(&pose));
    // A tenth of a metre is shown at least.
    let extent = site.stretched(strays, STRAYS * site.larger_side());
    let sides = [0, 1].map(|axis| (extent.high[axis] - extent.low[axis]).max(0.1));
    let pixels = ((CHART.0 - 2.0 * BORDER) / sides[0]).min((CHART.1 - 2.0 * BORDER) / sides[1]);
    let step = grid_step(sides[0].max(sides[1]) / STEPS);
    let scale = |axis: usize| {
        let middle = f64::midpoint(extent.low[axis], extent.high[axis]);
        let half = sides[axis] / 2.0 + BORDER / pixels;
        Scale::linear(middle - half, middle + half, step)
    };
    Frame {
        corner: (MARGIN + LABELS.0, title_height(map.title)),
        size: (whole(sides[0] * pixels + 2.0 * BORDER), whole(sides[1] * pixels + 2.0 * BORDER)),
        x: scale(0),
        y: scale(1),
    }
}

/// Walls, and landmarks with their numbers.
fn draw_site(page: &Page<'_>, frame: &Frame, map: &Map<'_>) -> Result<(), DrawingError> {
    for wall in map.walls {
        frame.draw_line(page, wall, BLACK.mix(0.45).stroke_width(4))?;
    }
    for (landmark, number) in map.landmarks.iter().zip(1..) {
        draw_landmark(page, frame, landmark, number)?;
    }
    Ok(())
}

fn draw_landmark(page: &Page<'_>, frame: &Frame, landmark: &Landmark, number: u32) -> Result<(), DrawingError> {
    let [x, y, heading] = landmark.pose;
    let (Some(centre), true) = (frame.pixel([x, y]), heading.is_finite()) else { return Ok(()) };
    // Pixels ahead of the landmark and to its left; y of a page runs down.
    let (sine, cosine) = heading.sin_cos();
    let beside = |ahead: f64, aside: f64| -> Pixel {
        (centre.0 + whole(ahead * cosine - aside * sine), centre.1 - whole(ahead * sine + aside * cosine))
    };
    let ahead_m = landmark.width / 2.0;
    let reach = frame.nearest_pixel([x - ahead_m * sine, y + ahead_m * cosine]);
    let half = f64::from(reach.0 - centre.0).hypot(f64::from(reach.1 - centre.1)).max(14.0);
    page.draw(&PathElement::new(vec![beside(0.0, -half), beside(0.0, half)], BLACK.stroke_width(12)))?;
    page.draw(&PathElement::new(vec![centre, beside(24.0, 0.0)], BLACK.stroke_width(3)))?;
    let middle = Pos::new(HPos::Center, VPos::Center);
    page.draw_text(&number.to_string(), &text_style().pos(middle), beside(-NUMBER, 0.0))?;
    Ok(())
}

/// Odometry, estimate and truth, each above the one before.
fn draw_paths(page: &Page<'_>, frame: &Frame, samples: &[Sample]) -> Result<(), DrawingError> {
    let odometry = samples.iter().map(|sample| sample.odometry.map_or([f64::NAN; 2], |pose| place(&pose)));
    frame.draw_line(page, &odometry.collect::<Vec<_>>(), odometry_line())?;
    // A filter that begins anew does not drive there.
    let mut rest = samples;
    while !rest.is_empty() {
        let end = 1 + rest.iter().skip(1).take_while(|sample| !sample.seen.recovered).count();
        let (piece, others) = rest.split_at(end);
        let estimate: Vec<_> = piece.iter().map(|sample| place(&sample.estimate)).collect();
        frame.draw_line(page, &estimate, estimate_line())?;
        rest = others;
    }
    // A robot that is carried has no path.
    for driven in samples.split(|sample| sample.lifted) {
        let truth: Vec<_> = driven.iter().map(|sample| place(&sample.truth)).collect();
        frame.draw_line(page, &truth, truth_line())?;
    }
    Ok(())
}

/// What happened on the way.
fn draw_marks(page: &Page<'_>, frame: &Frame, samples: &[Sample]) -> Result<(), DrawingError> {
    let marks: [(Sign, Has); 3] = [
        (Sign::Used, |sample| sample.seen.used),
        (Sign::Gated, |sample| sample.seen.gated),
        (Sign::Recovered, |sample| sample.seen.recovered),
    ];
    for (sign, has) in marks {
        let places =
            samples.iter().filter(|sample| has(sample)).filter_map(|sample| frame.pixel(place(&sample.estimate)));
        for pixel in apart(places, DOTS) {
            sign.draw(page, pixel)?;
        }
    }
    for lift in lifts(samples) {
        draw_lift(page, frame, samples, lift.start.checked_sub(1), lift.end)?;
    }
    for (sign, pose) in starts(frame, samples) {
        if let Some(pixel) = frame.pixel(place(&pose)) {
            sign.draw(page, pixel)?;
        }
    }
    Ok(())
}

/// Where the robot begins, and where the estimate does if that is another place in the drawing.
fn starts(frame: &Frame, samples: &[Sample]) -> Vec<(Sign, Pose)> {
    let Some(Sample { truth, estimate, .. }) = samples.first() else { return vec![] };
    let [first, believed] = [truth, estimate].map(|pose| frame.nearest_pixel(place(pose)));
    let mut starts = vec![(Sign::Start(truth[2]), *truth)];
    if !near(first, believed, START) {
        starts.push((Sign::FirstBelief(estimate[2]), *estimate));
    }
    starts
}

/// From the sample before the robot was lifted to the one after it was put down, if there are such.
fn draw_lift(
    page: &Page<'_>,
    frame: &Frame,
    samples: &[Sample],
    before: Option<usize>,
    after: usize,
) -> Result<(), DrawingError> {
    let pixel = |i: usize| samples.get(i).and_then(|sample| frame.pixel(place(&sample.truth)));
    let (from, to) = (before.and_then(pixel), pixel(after));
    if let (Some(from), Some(to)) = (from, to) {
        draw_carried(page, from, to)?;
    }
    for (sign, pixel) in [(Sign::Lifted, from), (Sign::PutDown, to)] {
        if let Some(pixel) = pixel {
            sign.draw(page, pixel)?;
        }
    }
    Ok(())
}

/// The legend: what there is in this drawing.
fn entries(map: &Map<'_>, frame: &Frame) -> Vec<Entry> {
    let samples = map.samples;
    let (used, gated) = (count(samples, |sample| sample.seen.used), count(samples, |sample| sample.seen.gated));
    let (recovered, lifts) = (count(samples, |sample| sample.seen.recovered), lifts(samples).len());
    let believed = starts(frame, samples).len().saturating_sub(1);
    let odometry = count(samples, |sample| sample.odometry.is_some());
    let all = [
        (map.walls.len(), Sign::Line(BLACK.mix(0.45).stroke_width(4)), "wall".to_owned()),
        (map.landmarks.len(), Sign::Landmark, "landmark, looking up".to_owned()),
        (samples.len(), Sign::Start(0.0), "start, facing right".to_owned()),
        (believed, Sign::FirstBelief(0.0), "start of the estimate".to_owned()),
        (samples.len(), Sign::Line(truth_line()), "true path".to_owned()),
        (samples.len(), Sign::Line(estimate_line()), "estimate".to_owned()),
        (odometry, Sign::Line(odometry_line()), "odometry alone".to_owned()),
        (used, Sign::Used, format!("observation used ({used})")),
        (gated, Sign::Gated, format!("observation gated ({gated})")),
        (recovered, Sign::Recovered, format!("filter recovered ({recovered})")),
        (lifts, Sign::Lifted, format!("robot lifted ({lifts})")),
        (lifts, Sign::PutDown, "robot put down".to_owned()),
    ];
    all.into_iter().filter(|(there, ..)| *there > 0).map(|(_, sign, text)| (sign, text)).collect()
}
