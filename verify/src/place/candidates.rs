//! Where landmarks could be: points of the grid on walls (PLACE-1).

use crate::site::{ASKEW, OFF_WALL, Site, Wall, gap, on_wall};
use core::f64::consts::TAU;
use reference::frame::wrap;
use reference::grid::{Codes, Grid, field_bits};
use reference::landmark::{Format, Landmark};
use reference::render::Posted;
use std::collections::BTreeSet;

/// Barcode widths that HYPO needs between neighbours on a wall (PLACE-4).
const WALL_GAP: f64 = 1.5;

/// A place for a landmark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// The landmark.
    pub posted: Posted,
    /// Its pose as codes.
    pub codes: Codes,
    /// The number of its wall.
    pub wall: usize,
}

impl Candidate {
    /// Whether two landmarks stand too near to each other on a wall (PLACE-4).
    #[must_use]
    pub fn too_near(&self, other: &Self) -> bool {
        too_near(&self.posted, &other.posted)
    }
}

/// PLACE-4: by less than 1.5 widths of the wider barcode.
//= reference/SPEC.md#place
//# - **PLACE-4** Two landmarks on one wall MUST be at least 1.5 widths of the wider barcode apart.
fn too_near(one: &Posted, other: &Posted) -> bool {
    let wider = 2.0 * one.landmark.half_width().max(other.landmark.half_width());
    gap(one, other).is_some_and(|gap| gap < WALL_GAP * wider)
}

/// All places for landmarks of a format and default dimensions, by wall and codes: points of the grid on a wall, heading
/// along its normal, with a code word of unequal halves, beside what hangs there already (PLACE-1).
//= reference/SPEC.md#place
//# - **PLACE-1** Landmarks MUST be put on points of the grid that lie on a wall (SITE-5), with the normal of a visible
//# face as heading, inside the codes and with unequal halves (CODE-6).
#[must_use]
pub fn candidates(site: &Site, format: Format) -> Vec<Candidate> {
    let mut taken = BTreeSet::new();
    let mut found = Vec::new();
    for wall in &site.walls {
        for normal in wall.normals() {
            let Some(theta) = heading_code(&site.grid, format, normal) else { continue };
            for codes in codes_along(&site.grid, format, wall, theta) {
                if let Some(candidate) = candidate(site, format, codes)
                    && taken.insert(codes)
                {
                    found.push(candidate);
                }
            }
        }
    }
    found
}

/// The code of the heading that is a wall's normal, if the grid has it.
fn heading_code(grid: &Grid, format: Format, normal: f64) -> Option<u32> {
    let count = grid.headings(format);
    let off = |code: &u32| wrap(TAU * f64::from(*code) / f64::from(count) - normal).abs();
    (0..count).find(|code| off(code) <= ASKEW)
}

/// The codes of points within a wall's bounding box and its tolerance, x first.
fn codes_along(grid: &Grid, format: Format, wall: &Wall, theta: u32) -> impl Iterator<Item = Codes> {
    let bits = field_bits(format);
    let [xs, ys] = [0, 1].map(|axis| {
        let [a, b] = [wall.from[axis], wall.to[axis]];
        let code = |value: f64| (value - grid.origin[axis]) / grid.step[axis];
        let last = f64::from((1_u32 << bits[axis]) - 1);
        let low = code(a.min(b) - OFF_WALL).ceil().max(0.0);
        let high = code(a.max(b) + OFF_WALL).floor().min(last);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 2^10 - 1, or saturated")]
        let range = if low <= high { low as u32..high as u32 + 1 } else { 0..0 };
        range
    });
    xs.flat_map(move |x| ys.clone().map(move |y| Codes { x, y, theta }))
}

fn candidate(site: &Site, format: Format, codes: Codes) -> Option<Candidate> {
    let landmark_in_world = site.grid.pose(format, codes);
    let payload = site.grid.payload(format, &landmark_in_world).ok()?;
    let posted = Posted { landmark_in_world, landmark: Landmark::new(format), payload };
    let wall = on_wall(&site.walls, &posted).ok()?;
    let alone =
        |there: &Posted| !too_near(there, &posted) && (there.payload != payload || there.landmark.format != format);
    site.landmarks.iter().all(alone).then_some(Candidate { posted, codes, wall })
}
