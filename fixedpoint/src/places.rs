//! Where a site's landmarks stand.

use crate::frame::{self, Pose, World};
use crate::grid::Grid;
use crate::landmark::Format;

/// A landmark of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Listed {
    /// Its format.
    pub format: Format,
    /// Its payload.
    pub payload: u32,
    /// Where it stands.
    pub pose: Pose<World, frame::Landmark>,
}

/// What a site knows of its landmarks (`LOCATE-1`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Places<'a> {
    /// Their payloads are poses on a grid.
    Grid(Grid),
    /// Their payloads are names, listed in any order; of those that are listed twice the first counts.
    Table(&'a [Listed]),
}

impl Places<'_> {
    /// Where the landmark with a format and a payload stands; `None` if the site knows no such landmark (`LOCATE-2`).
    //= reference/SPEC.md#locate
    //# - **LOCATE-1** A landmark's pose in the world MUST be that of its payload on the site's grid (GRID-6), or that
    //# of the table which lists format and payload, whichever the site has.
    #[must_use]
    pub fn landmark_in_world(&self, format: Format, payload: u32) -> Option<Pose<World, frame::Landmark>> {
        match self {
            Self::Grid(grid) => grid.landmark_in_world(format, payload).ok(),
            Self::Table(landmarks) => landmarks
                .iter()
                .find(|known| known.format == format && known.payload == payload)
                .map(|known| known.pose),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::{Angle, Length};

    fn pose(x: i32) -> Pose<World, frame::Landmark> {
        Pose::new(Length::from_num(x), Length::ZERO, Angle::PI)
    }

    //= reference/SPEC.md#locate
    //= type=test
    //# - **LOCATE-1** A landmark's pose in the world MUST be that of its payload on the site's grid (GRID-6), or that
    //# of the table which lists format and payload, whichever the site has.
    #[test]
    fn a_table_is_asked_for_format_and_payload() {
        let listed = |format, payload, x| Listed { format, payload, pose: pose(x) };
        let landmarks = [
            listed(Format::Wide, 7, 1),
            listed(Format::Paper, 9, 2),
            listed(Format::Paper, 7, 3),
            listed(Format::Paper, 7, 4),
        ];
        let places = Places::Table(&landmarks);
        assert_eq!(places.landmark_in_world(Format::Paper, 7), Some(pose(3)));
        assert_eq!(places.landmark_in_world(Format::Wide, 7), Some(pose(1)));
        assert_eq!(places.landmark_in_world(Format::Wide, 9), None);
    }

    /// Twelve headings: the code 12 is no landmark of the site, on which 11 is one.
    #[test]
    fn a_grid_knows_the_landmarks_that_are_on_it() {
        let default = Grid::default();
        let grid = Grid::new([Length::ZERO; 2], [crate::formats::GridStep::ONE; 2], 12).unwrap();
        assert!(Places::Grid(grid).landmark_in_world(Format::Paper, 11).is_some());
        assert_eq!(Places::Grid(grid).landmark_in_world(Format::Paper, 12), None);
        assert!(Places::Grid(default).landmark_in_world(Format::Paper, 12).is_some());
    }
}
