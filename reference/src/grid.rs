//! The site's grid: poses of landmarks as payloads (GRID).

use crate::codeword::{self, EncodeRefusal};
use crate::frame::{Landmark, Pose, World, wrap};
use crate::landmark::Format;
use core::f64::consts::TAU;
use core::fmt;

/// How far a coordinate may be from the grid, as a share of its step (GRID-4).
pub const TOLERANCE: f64 = 1e-3;

/// Positions and headings that payloads stand for, known to every robot of a site.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// World position of the code (0, 0), metres.
    pub origin: [f64; 2],
    /// Distance of neighbouring codes along x and y, metres, positive.
    pub step: [f64; 2],
    /// Number of equal steps of the heading in a turn, from 1 to 16; `None` for all of the format's.
    pub theta_steps: Option<u32>,
}

impl Default for Grid {
    /// Steps of 50 mm from the world's origin, 16 headings (GRID-2).
    fn default() -> Self {
        Self { origin: [0.0, 0.0], step: [0.05, 0.05], theta_steps: None }
    }
}

/// A pose as the codes of x, y and heading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Codes {
    /// Code of x.
    pub x: u32,
    /// Code of y.
    pub y: u32,
    /// Code of the heading.
    pub theta: u32,
}

/// Bits of x, of y, and of the heading (GRID-1).
//= reference/SPEC.md#grid
//# - **GRID-1** A pose's payload MUST be the codes of x, y and heading, in this order, most significant first, of 6, 6
//# and 4 bits in `paper` and 10, 10 and 4 bits in `wide`.
#[must_use]
pub fn field_bits(format: Format) -> [u32; 3] {
    match format {
        Format::Paper => [6, 6, 4],
        Format::Wide => [10, 10, 4],
    }
}

/// Why a pose has no payload, or a payload no pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GridRefusal {
    /// The pose lies between the grid's (GRID-4).
    OffGrid,
    /// The pose lies beyond the largest code, or before the first (GRID-5).
    Outside,
    /// The pose's code word cannot be told from a foreign bar code (CODE-6).
    EqualHalves,
    /// The code of the heading is beyond the grid's steps (GRID-6).
    Heading,
}

impl fmt::Display for GridRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OffGrid => "the pose is not on the site's grid",
            Self::Outside => "the pose is outside the site's grid",
            Self::EqualHalves => "both layers of this pose's code word would look the same",
            Self::Heading => "the heading's code is beyond the grid's steps",
        })
    }
}

impl core::error::Error for GridRefusal {}

impl Grid {
    /// Headings in a turn for a format (GRID-3).
    //= reference/SPEC.md#grid
    //# - **GRID-3** The code `c` of the heading MUST stand for `c` equal parts of a turn, of which the grid has at most
    //# and by default `2^bits`.
    #[must_use]
    pub fn headings(&self, format: Format) -> u32 {
        let all = 1 << field_bits(format)[2];
        self.theta_steps.map_or(all, |steps| steps.min(all))
    }

    /// The pose of codes in the world (GRID-2, GRID-3).
    //= reference/SPEC.md#grid
    //# - **GRID-2** The code `c` of a coordinate MUST stand for the origin plus `c` steps, by default 50 mm from 0.
    #[must_use]
    pub fn pose(&self, format: Format, codes: Codes) -> Pose<World, Landmark> {
        let heading = f64::from(codes.theta) * TAU / f64::from(self.headings(format));
        Pose::new(
            self.origin[0] + f64::from(codes.x) * self.step[0],
            self.origin[1] + f64::from(codes.y) * self.step[1],
            heading,
        )
    }

    /// The codes of a pose (GRID-4, GRID-5).
    //= reference/SPEC.md#grid
    //# - **GRID-4** A pose that is more than 1/1000 of a step from the grid's nearest MUST be refused (`OffGrid`).
    //= reference/SPEC.md#grid
    //# - **GRID-5** A pose whose codes do not fit their fields MUST be refused (`Outside`).
    pub fn codes(&self, format: Format, pose: &Pose<World, Landmark>) -> Result<Codes, GridRefusal> {
        let [x_bits, y_bits, _] = field_bits(format);
        let x = code(pose.x() - self.origin[0], self.step[0], x_bits)?;
        let y = code(pose.y() - self.origin[1], self.step[1], y_bits)?;
        let headings = self.headings(format);
        let turns = wrap(pose.theta()).rem_euclid(TAU) / TAU * f64::from(headings);
        let nearest = turns.round();
        if (turns - nearest).abs() > TOLERANCE {
            return Err(GridRefusal::OffGrid);
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 16")]
        let theta = nearest as u32 % headings;
        Ok(Codes { x, y, theta })
    }

    /// The payload of a pose (GRID-1, GRID-4, GRID-5, CODE-6).
    pub fn payload(&self, format: Format, pose: &Pose<World, Landmark>) -> Result<u32, GridRefusal> {
        let payload = join(format, self.codes(format, pose)?);
        match codeword::encode(format, payload) {
            Ok(_) => Ok(payload),
            Err(EncodeRefusal::EqualHalves) => Err(GridRefusal::EqualHalves),
            Err(EncodeRefusal::TooLarge) => Err(GridRefusal::Outside),
        }
    }

    /// The landmark's pose that a payload stands for (GRID-1, GRID-6).
    //= reference/SPEC.md#grid
    //# - **GRID-6** A payload whose code of the heading is not below the number of headings MUST be refused
    //# (`Heading`).
    pub fn landmark_in_world(&self, format: Format, payload: u32) -> Result<Pose<World, Landmark>, GridRefusal> {
        let codes = split(format, payload);
        if codes.theta >= self.headings(format) { Err(GridRefusal::Heading) } else { Ok(self.pose(format, codes)) }
    }
}

/// One coordinate's code.
fn code(distance: f64, step: f64, bits: u32) -> Result<u32, GridRefusal> {
    let steps = distance / step;
    let nearest = steps.round();
    if !(nearest >= 0.0 && nearest < f64::from(1_u32 << bits)) {
        return Err(GridRefusal::Outside);
    }
    if (steps - nearest).abs() > TOLERANCE {
        return Err(GridRefusal::OffGrid);
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 2^10")]
    Ok(nearest as u32)
}

/// The payload of codes that fit their fields, x first (GRID-1).
#[must_use]
pub fn join(format: Format, codes: Codes) -> u32 {
    let [_, y_bits, theta_bits] = field_bits(format);
    (codes.x << y_bits | codes.y) << theta_bits | codes.theta
}

/// The codes of a payload (GRID-1).
#[must_use]
pub fn split(format: Format, payload: u32) -> Codes {
    let [_, y_bits, theta_bits] = field_bits(format);
    let field = |value: u32, bits: u32| value & ((1 << bits) - 1);
    Codes {
        x: payload >> (y_bits + theta_bits),
        y: field(payload >> theta_bits, y_bits),
        theta: field(payload, theta_bits),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::FRAC_PI_2;

    #[test]
    fn every_payload_is_one_pose() {
        let grid = Grid::default();
        for payload in (0..=0xFFFF).filter(|&payload| codeword::encode(Format::Paper, payload).is_ok()) {
            let pose = grid.landmark_in_world(Format::Paper, payload).unwrap();
            assert_eq!(grid.payload(Format::Paper, &pose), Ok(payload));
        }
    }

    //= reference/SPEC.md#grid
    //= type=test
    //# - **GRID-1** A pose's payload MUST be the codes of x, y and heading, in this order, most significant first, of
    //# 6, 6 and 4 bits in `paper` and 10, 10 and 4 bits in `wide`.
    //= reference/SPEC.md#grid
    //= type=test
    //# - **GRID-2** The code `c` of a coordinate MUST stand for the origin plus `c` steps, by default 50 mm from 0.
    #[test]
    fn fields_are_x_y_heading() {
        // 3 steps of x, 5 of y, a quarter turn: 000011 000101 0100.
        let pose = Pose::new(0.15, 0.25, FRAC_PI_2);
        assert_eq!(Grid::default().payload(Format::Paper, &pose), Ok(0b0000_1100_0101_0100));
        assert_eq!(Grid::default().payload(Format::Wide, &pose), Ok(0b0000_0000_1100_0000_0101_0100));
    }

    //= reference/SPEC.md#grid
    //= type=test
    //# - **GRID-3** The code `c` of the heading MUST stand for `c` equal parts of a turn, of which the grid has at most
    //# and by default `2^bits`.
    //= reference/SPEC.md#grid
    //= type=test
    //# - **GRID-6** A payload whose code of the heading is not below the number of headings MUST be refused
    //# (`Heading`).
    #[test]
    fn twelve_headings_refuse_the_other_four_codes() {
        let grid = Grid { theta_steps: Some(12), ..Grid::default() };
        let pose = grid.landmark_in_world(Format::Paper, 0b0000_1100_0101_0011).unwrap();
        assert!((pose.theta() - FRAC_PI_2).abs() < 1e-12);
        assert_eq!(grid.landmark_in_world(Format::Paper, 0b0000_1100_0101_1100), Err(GridRefusal::Heading));
    }

    //= reference/SPEC.md#grid
    //= type=test
    //# - **GRID-4** A pose that is more than 1/1000 of a step from the grid's nearest MUST be refused (`OffGrid`).
    //= reference/SPEC.md#grid
    //= type=test
    //# - **GRID-5** A pose whose codes do not fit their fields MUST be refused (`Outside`).
    #[test]
    fn poses_beside_the_grid_are_refused() {
        let payload = |x, y, theta| Grid::default().payload(Format::Paper, &Pose::new(x, y, theta));
        assert_eq!(payload(0.151, 0.25, 0.0), Err(GridRefusal::OffGrid));
        assert_eq!(payload(0.15, 0.25, 0.1), Err(GridRefusal::OffGrid));
        assert_eq!(payload(-0.05, 0.25, 0.0), Err(GridRefusal::Outside));
        assert_eq!(payload(0.15, 3.2, 0.0), Err(GridRefusal::Outside));
        assert_eq!(payload(f64::NAN, 0.25, 0.0), Err(GridRefusal::Outside));
        assert!(payload(0.15, 3.15, 0.0).is_ok());
        // A heading just below a turn is the heading 0.
        assert_eq!(payload(0.15, 0.25, -1e-6), payload(0.15, 0.25, 0.0));
    }

    #[test]
    fn indistinct_code_words_are_refused() {
        let equal = (0..=0xFFFF).find(|&payload| codeword::encode(Format::Paper, payload).is_err()).unwrap();
        let pose = Grid::default().pose(Format::Paper, split(Format::Paper, equal));
        assert_eq!(Grid::default().payload(Format::Paper, &pose), Err(GridRefusal::EqualHalves));
    }
}
