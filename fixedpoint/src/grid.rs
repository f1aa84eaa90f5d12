//! Poses of landmarks as payloads: the grid that every robot of a site knows.

use crate::formats::{Angle, GridStep, Length};
use crate::frame::{self, Pose, World};
use crate::landmark::Format;
use crate::ratio;
use crate::refusal::{GridRefusal, SpacingRefusal};

/// The most headings, those of four bits (`GRID-3`).
pub const MAX_HEADINGS: u8 = 1 << HEADING_BITS;

/// Bits of the heading's code (`GRID-1`).
const HEADING_BITS: u8 = 4;

/// A grid of poses: where its codes are 0, its steps along the world's x and y, and how many headings it has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    origin: [Length; 2],
    step: [GridStep; 2],
    headings: u8,
}

/// `GRID-2` and `GRID-3`: 50 mm, rounded to 2^-30 m, from 0, and 16 headings.
//= reference/SPEC.md#grid
//# - **GRID-2** The code `c` of a coordinate MUST stand for the origin plus `c` steps, by default 50 mm from 0.
impl Default for Grid {
    fn default() -> Self {
        Self { origin: [Length::ZERO; 2], step: [GridStep::from_bits(53_687_091); 2], headings: MAX_HEADINGS }
    }
}

impl Grid {
    /// A grid from its origin in metres, its steps along x and y in metres, and the number of its headings.
    ///
    /// # Errors
    /// `Step` for a step of 0, `Headings` unless there are 1 to 16 of them (`GRID-3`).
    //= reference/SPEC.md#grid
    //# - **GRID-3** The code `c` of the heading MUST stand for `c` equal parts of a turn, of which the grid has at most
    //# and by default `2^bits`.
    pub fn new(origin: [Length; 2], step: [GridStep; 2], headings: u8) -> Result<Self, SpacingRefusal> {
        if step.contains(&GridStep::ZERO) {
            return Err(SpacingRefusal::Step);
        }
        if !(1..=MAX_HEADINGS).contains(&headings) {
            return Err(SpacingRefusal::Headings);
        }
        Ok(Self { origin, step, headings })
    }

    /// Where the landmark with a payload stands (`GRID-1` to `GRID-3`).
    ///
    /// Errors: half a unit of the step's last bit for every step, 2^-31 m and 0.5 µm at the 1023rd; 2^-25 m of the result; of
    /// the heading 2^-32 π.
    ///
    /// # Errors
    /// `TooLarge` if the payload has more bits than the format, `Heading` if the code of the heading is not below the number
    /// of headings (`GRID-6`), `Beyond` if the place is outside the ±128 m of [`Length`].
    //= reference/SPEC.md#grid
    //# - **GRID-6** A payload whose code of the heading is not below the number of headings MUST be refused
    //# (`Heading`).
    pub fn landmark_in_world(&self, format: Format, payload: u32) -> Result<Pose<World, frame::Landmark>, GridRefusal> {
        let [x, y, heading] = codes(format, payload).ok_or(GridRefusal::TooLarge)?;
        if heading >= u32::from(self.headings) {
            return Err(GridRefusal::Heading);
        }
        let [from_x, from_y] = self.origin;
        let [step_x, step_y] = self.step;
        let coordinate = |from, step, code| coordinate(from, step, code).ok_or(GridRefusal::Beyond);
        Ok(Pose::new(
            coordinate(from_x, step_x, x)?,
            coordinate(from_y, step_y, y)?,
            part_of_turn(heading, self.headings),
        ))
    }
}

/// The codes of x, y and heading (`GRID-1`); `None` if the payload has more bits than they.
//= reference/SPEC.md#grid
//# - **GRID-1** A pose's payload MUST be the codes of x, y and heading, in this order, most significant first, of 6, 6
//# and 4 bits in `paper` and 10, 10 and 4 bits in `wide`.
fn codes(format: Format, payload: u32) -> Option<[u32; 3]> {
    let bits = match format {
        Format::Paper => 6,
        Format::Wide => 10,
    };
    let mask = (1 << bits) - 1;
    let x = payload >> (bits + HEADING_BITS);
    let y = (payload >> HEADING_BITS) & mask;
    (x <= mask).then_some([x, y, payload & u32::from(MAX_HEADINGS - 1)])
}

/// `from + code step`, 30 fraction bits until it is rounded; below 2^42.
fn coordinate(from: Length, step: GridStep, code: u32) -> Option<Length> {
    let fine = (i64::from(from.to_bits()) << 6) + i64::from(step.to_bits()) * i64::from(code);
    i32::try_from(ratio::dropped(fine, 6)).ok().map(Length::from_bits)
}

/// So many of so many parts of a turn.
fn part_of_turn(code: u32, parts: u8) -> Angle {
    let turn = ratio::rounded(i64::from(code), i64::from(parts), 32).unwrap_or_default();
    Angle::from_bits(u32::try_from(turn).unwrap_or_default().cast_signed())
}

#[cfg(test)]
mod tests;
