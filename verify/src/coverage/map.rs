//! The heat map: region, route, walls and landmarks as SVG (SITE-15).

use super::{RegionCoverage, RouteCoverage};
use crate::certificate::landmark_name;
use crate::site::{Site, Wall};
use core::fmt::Write;
use reference::frame::Point;
use reference::render::Posted;

/// Size of the longer side of the plan, px.
const PLAN: f64 = 720.0;
/// Left margin, for the axis of y.
const LEFT: f64 = 80.0;
/// Top margin, for the title.
const TOP: f64 = 50.0;
/// Right margin, for the legend.
const RIGHT: f64 = 270.0;
/// Bottom margin, for the axis of x and the scale bar.
const BOTTOM: f64 = 100.0;

/// Colours of the shares from 0 to the largest; light to dark, also when printed in grey (after matplotlib's viridis).
const SHADES: [[f64; 3]; 5] =
    [[253.0, 247.0, 200.0], [122.0, 209.0, 81.0], [34.0, 168.0, 132.0], [42.0, 120.0, 142.0], [65.0, 68.0, 135.0]];

/// Legs of this length have an arrow, px.
const ARROW_LEG: f64 = 60.0;

/// Most landmarks that the legend names.
const MOST_NAMED: usize = 8;

/// Distance of the legend's lines, px.
const LEGEND_LINE: f64 = 24.0;

const READ: &str = "#0b7a3b";
const UNREAD: &str = "#d95f02";
const LANDMARK: &str = "#c2002f";

/// A plan of the site as SVG: shares of headings in the region, what is read along the route, walls, landmarks, scale.
//= reference/SPEC.md#site
//# - **SITE-15** The heat map MUST show walls, landmarks, the route, the share of headings with a colour legend, axes
//# in metres and a scale.
#[must_use]
pub fn heat_map(site: &Site, region: Option<&RegionCoverage>, route: Option<&RouteCoverage>) -> String {
    let plan = Plan::of(site);
    let mut svg = String::new();
    let width = LEFT + plan.width + RIGHT;
    let height = (TOP + plan.height + BOTTOM).max(legend_height(site, region.is_some()));
    // Writing to a string does not fail.
    let _ = writeln!(
        svg,
        "<svg xmlns='http://www.w3.org/2000/svg' width='{width:.0}' height='{height:.0}' \
         viewBox='0 0 {width:.0} {height:.0}' font-family='Helvetica, Arial, sans-serif' font-size='15' fill='#111'>\n\
         <rect width='100%' height='100%' fill='white'/>\n\
         <text x='{LEFT}' y='28' font-size='18'>{}</text>",
        title(region, route)
    );
    plan.axes(&mut svg);
    if let Some(region) = region {
        plan.cells(&mut svg, region);
    }
    if let Some(route) = route {
        plan.route(&mut svg, route);
    }
    site.walls.iter().for_each(|wall| plan.wall(&mut svg, wall));
    site.landmarks.iter().enumerate().for_each(|(i, posted)| plan.landmark(&mut svg, i + 1, posted));
    plan.scale_bar(&mut svg);
    plan.legend(&mut svg, site, region, route);
    svg += "</svg>\n";
    svg
}

fn title(region: Option<&RegionCoverage>, route: Option<&RouteCoverage>) -> String {
    let region =
        region.map(|region| format!("A landmark is readable from {:.1} % of the poses", 100.0 * region.share()));
    let route = route.map(|route| {
        let gap = route.longest_gap.map_or("none ever".to_owned(), |gap| format!("longest gap {:.2} m", gap.length));
        format!("Readable along {:.1} % of the route, {gap}", 100.0 * route.share())
    });
    region.into_iter().chain(route).collect::<Vec<_>>().join("; ")
}

/// A piece of the route: both ends in pixels, whether something is read, its heading in radians.
type Piece = ([f64; 2], [f64; 2], bool, f64);

/// From metres to pixels.
struct Plan {
    low: [f64; 2],
    high: [f64; 2],
    scale: f64,
    width: f64,
    height: f64,
}

impl Plan {
    fn of(site: &Site) -> Self {
        let ends = site.walls.iter().flat_map(|wall| [wall.from, wall.to]);
        let hung = site.landmarks.iter().map(|posted| [posted.landmark_in_world.x(), posted.landmark_in_world.y()]);
        let route = site.route.iter().flat_map(|route| route.points.iter().copied());
        let region = site.region.iter().flat_map(|region| region.rings.iter().flatten().copied());
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for point in ends.chain(hung).chain(route).chain(region) {
            for axis in 0..2 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        if low[0] > high[0] {
            (low, high) = ([0.0; 2], [1.0; 2]);
        }
        let span = (high[0] - low[0]).max(high[1] - low[1]).max(0.01);
        // Walls and labels at the border stay inside.
        let margin = 0.06 * span;
        let (low, high) = (low.map(|v| v - margin), high.map(|v| v + margin));
        let scale = PLAN / (span + 2.0 * margin);
        Self { low, high, scale, width: (high[0] - low[0]) * scale, height: (high[1] - low[1]) * scale }
    }

    fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [LEFT + (x - self.low[0]) * self.scale, TOP + (self.high[1] - y) * self.scale]
    }

    /// Frame, ticks and names of the axes.
    fn axes(&self, svg: &mut String) {
        let (right, bottom) = (LEFT + self.width, TOP + self.height);
        let _ = writeln!(
            svg,
            "<rect x='{LEFT}' y='{TOP}' width='{:.1}' height='{:.1}' fill='none' stroke='#777'/>",
            self.width, self.height
        );
        let [(x_step, x_decimals), (y_step, y_decimals)] = [0, 1].map(|axis| self.tick_step(axis));
        for x in ticks(self.low[0], self.high[0], x_step) {
            let [px, _] = self.at([x, 0.0]);
            let _ = writeln!(
                svg,
                "<path d='M{px:.1} {bottom:.1}v6' stroke='#777'/><text x='{px:.1}' y='{:.1}' text-anchor='middle'>{x:.x_decimals$}</text>",
                bottom + 22.0
            );
        }
        for y in ticks(self.low[1], self.high[1], y_step) {
            let [_, py] = self.at([0.0, y]);
            let _ = writeln!(
                svg,
                "<path d='M{LEFT} {py:.1}h-6' stroke='#777'/><text x='{:.1}' y='{:.1}' text-anchor='end'>{y:.y_decimals$}</text>",
                LEFT - 10.0,
                py + 5.0
            );
        }
        let _ = writeln!(
            svg,
            "<text x='{:.1}' y='{:.1}' text-anchor='end'>x (m)</text>\
             <text transform='translate(22 {:.1}) rotate(-90)' text-anchor='middle'>y (m)</text>",
            right,
            bottom + 44.0,
            TOP + self.height / 2.0
        );
    }

    /// Distance of an axis's ticks in metres, equal on both axes unless one would have too few, and their decimals.
    fn tick_step(&self, axis: usize) -> (f64, usize) {
        let span = |axis: usize| self.high[axis] - self.low[axis];
        let step = round_step((span(0).max(span(1)) / 6.0).min(span(axis) / 2.0));
        (step, if step < 0.1 { 2 } else { usize::from(step < 1.0) })
    }

    fn cells(&self, svg: &mut String, region: &RegionCoverage) {
        let most = most_readable(region);
        // A little over the edge: renderers leave seams between cells that only touch.
        let side = region.cell * self.scale + 0.4;
        svg.push_str("<g shape-rendering='crispEdges'>\n");
        for cell in &region.cells {
            let [x, y] = self.at(cell.middle);
            let _ = writeln!(
                svg,
                "<rect x='{:.2}' y='{:.2}' width='{side:.2}' height='{side:.2}' fill='{}'/>",
                x - side / 2.0,
                y - side / 2.0,
                shade(cell.readable as f64 / most)
            );
        }
        svg.push_str("</g>\n");
    }

    /// The pieces of the route, one stroke for each run of equal ones, and arrows along its legs.
    fn route(&self, svg: &mut String, route: &RouteCoverage) {
        let ends = route.samples.iter().zip(&route.readable).map(|(sample, numbers)| {
            let pose = &sample.robot_in_world;
            let end = |x: f64| pose.place(&Point::new(x, 0.0));
            let [a, b] = [end(-sample.length / 2.0), end(sample.length / 2.0)];
            (self.at([a.x, a.y]), self.at([b.x, b.y]), !numbers.is_empty(), pose.theta())
        });
        let pieces: Vec<Piece> = ends.collect();
        for run in pieces.chunk_by(|a, b| a.2 == b.2 && (a.3 - b.3).abs() < 1e-9) {
            let [[x, y], [to_x, to_y]] = [run[0].0, run[run.len() - 1].1];
            let style = if run[0].2 { read_style() } else { unread_style() };
            let path = format!("M{x:.1} {y:.1}L{to_x:.1} {to_y:.1}");
            // White below it, or it would not be seen on dark cells.
            let _ = writeln!(svg, "<path d='{path}' stroke='white' stroke-width='9'/><path d='{path}' {style}/>");
        }
        let legs: Vec<_> = pieces.chunk_by(|a, b| (a.3 - b.3).abs() < 1e-9).collect();
        let length = |leg: &[Piece]| {
            let [[x, y], [to_x, to_y]] = [leg[0].0, leg[leg.len() - 1].1];
            (to_x - x).hypot(to_y - y)
        };
        // Arrows on short legs would hide them.
        let longest = legs.iter().map(|leg| length(leg)).fold(0.0, f64::max);
        for leg in legs.into_iter().filter(|leg| length(leg) >= longest.min(ARROW_LEG)) {
            let ([x, y], degrees) = (leg[leg.len() / 2].0, -leg[0].3.to_degrees());
            let scale = (length(leg) / ARROW_LEG).min(1.0);
            let _ = writeln!(
                svg,
                "<path transform='translate({x:.1} {y:.1}) rotate({degrees:.2}) scale({scale:.2})' d='M-9 -8L12 0L-9 8z' fill='#111'/>"
            );
        }
    }

    fn wall(&self, svg: &mut String, wall: &Wall) {
        let [[x, y], [to_x, to_y]] = [self.at(wall.from), self.at(wall.to)];
        let _ = writeln!(
            svg,
            "<path d='M{x:.1} {y:.1}L{to_x:.1} {to_y:.1}' stroke='#111' stroke-width='3' stroke-linecap='round'/>"
        );
    }

    /// A bar as wide as the barcode, its number behind it.
    fn landmark(&self, svg: &mut String, number: usize, posted: &Posted) {
        let place = |x: f64, y: f64| {
            let point = posted.landmark_in_world.place(&Point::new(x, y));
            self.at([point.x, point.y])
        };
        let half = posted.landmark.half_width().max(4.0 / self.scale);
        let [[x, y], [to_x, to_y]] = [place(0.0, -half), place(0.0, half)];
        let [label_x, label_y] = place(-16.0 / self.scale, 0.0);
        let _ = writeln!(
            svg,
            "<path d='M{x:.1} {y:.1}L{to_x:.1} {to_y:.1}' stroke='{LANDMARK}' stroke-width='9'/>\
             <text x='{label_x:.1}' y='{:.1}' text-anchor='middle' font-weight='bold' fill='{LANDMARK}'>{number}</text>",
            label_y + 5.0
        );
    }

    fn scale_bar(&self, svg: &mut String) {
        let metres = round_step((self.high[0] - self.low[0]).max(self.high[1] - self.low[1]) / 5.0);
        let (y, length) = (TOP + self.height + 62.0, metres * self.scale);
        let label = if metres < 1.0 { format!("{:.0} cm", 100.0 * metres) } else { format!("{metres:.0} m") };
        let _ = writeln!(
            svg,
            "<path d='M{LEFT} {y:.1}v10h{length:.1}v-10' fill='none' stroke='#111' stroke-width='2'/>\
             <text x='{:.1}' y='{:.1}' text-anchor='middle'>{label}</text>",
            LEFT + length / 2.0,
            y + 28.0
        );
    }

    fn legend(&self, svg: &mut String, site: &Site, region: Option<&RegionCoverage>, route: Option<&RouteCoverage>) {
        let x = LEFT + self.width + 24.0;
        let mut y = TOP + 12.0;
        let mut entry = |sample: &str, label: &str| {
            let _ = writeln!(
                svg,
                "<path d='M{x:.1} {y:.1}h30' {sample}/><text x='{:.1}' y='{:.1}'>{label}</text>",
                x + 40.0,
                y + 5.0
            );
            y += LEGEND_LINE;
        };
        entry("stroke='#111' stroke-width='3'", "wall");
        if route.is_some() {
            entry(&read_style(), "route, readable");
            entry(&unread_style(), "route, nothing readable");
        }
        for (i, posted) in site.landmarks.iter().take(MOST_NAMED).enumerate() {
            let label = landmark_name(posted.landmark.format, posted.payload);
            entry(&format!("stroke='{LANDMARK}' stroke-width='9'"), &format!("{}: {label}", i + 1));
        }
        if site.landmarks.len() > MOST_NAMED {
            entry(
                &format!("stroke='{LANDMARK}' stroke-width='9'"),
                &format!("and {} more", site.landmarks.len() - MOST_NAMED),
            );
        }
        if let Some(region) = region {
            colour_bar(svg, x, y + 10.0, most_readable(region) / region.headings as f64);
        }
    }
}

/// From the picture's top to the legend's end, px: wall, two kinds of route, landmarks, colour bar.
fn legend_height(site: &Site, colours: bool) -> f64 {
    let lines = 3 + site.landmarks.len().min(MOST_NAMED + 1);
    TOP + LEGEND_LINE * lines as f64 + if colours { 300.0 } else { 20.0 }
}

fn read_style() -> String {
    format!("stroke='{READ}' stroke-width='6'")
}

fn unread_style() -> String {
    format!("stroke='{UNREAD}' stroke-width='3' stroke-dasharray='7 4'")
}

/// Shares of headings from 0 to `most`.
fn colour_bar(svg: &mut String, x: f64, y: f64, most: f64) {
    let (bands, band) = (40, 5.0);
    let _ = writeln!(
        svg,
        "<text x='{x:.1}' y='{:.1}'>Share of headings from</text><text x='{x:.1}' y='{:.1}'>which one is readable</text>",
        y + 5.0,
        y + 24.0
    );
    let top = y + 40.0;
    for i in 0..bands {
        let share = 1.0 - (f64::from(i) + 0.5) / f64::from(bands);
        let _ = writeln!(
            svg,
            "<rect x='{x:.1}' y='{:.1}' width='26' height='{band}' fill='{}' shape-rendering='crispEdges'/>",
            top + band * f64::from(i),
            shade(share)
        );
    }
    for part in [0.0, 0.5, 1.0] {
        let _ = writeln!(
            svg,
            "<text x='{:.1}' y='{:.1}'>{:.1} %</text>",
            x + 34.0,
            top + band * f64::from(bands) * (1.0 - part) + 5.0,
            100.0 * most * part
        );
    }
}

/// The largest number of headings of a cell, at least 1.
fn most_readable(region: &RegionCoverage) -> f64 {
    region.cells.iter().map(|cell| cell.readable).max().unwrap_or(0).max(1) as f64
}

/// The colour of a share from 0 to 1.
fn shade(share: f64) -> String {
    let place = share.clamp(0.0, 1.0) * (SHADES.len() - 1) as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an index")]
    let below = (place as usize).min(SHADES.len() - 2);
    let part = place - below as f64;
    let mix = |i: usize| (1.0 - part) * SHADES[below][i] + part * SHADES[below + 1][i];
    format!("rgb({:.0},{:.0},{:.0})", mix(0), mix(1), mix(2))
}

/// The nearest smaller of 1, 2, 5 times a power of ten.
fn round_step(value: f64) -> f64 {
    let power = 10_f64.powf(value.log10().floor());
    let factor = [5.0, 2.0].into_iter().find(|factor| factor * power <= value);
    factor.unwrap_or(1.0) * power
}

/// Multiples of `step` from `low` to `high`.
fn ticks(low: f64, high: f64, step: f64) -> impl Iterator<Item = f64> {
    #[expect(clippy::cast_possible_truncation, reason = "a few ticks on coordinates of at most 1000 m")]
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    (first..=last).map(move |i| i as f64 * step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round() {
        for (value, step) in [(0.37, 0.2), (0.5, 0.5), (1.9, 1.0), (73.0, 50.0), (0.012, 0.01)] {
            assert!((round_step(value) / step - 1.0).abs() < 1e-12, "{value}");
        }
        assert_eq!(ticks(-0.3, 0.5, 0.2).count(), 4);
    }

    #[test]
    fn shades_run_from_the_first_to_the_last() {
        assert_eq!((shade(0.0), shade(1.0)), ("rgb(253,247,200)".to_owned(), "rgb(65,68,135)".to_owned()));
        assert_eq!(shade(0.25), "rgb(122,209,81)");
    }
}
