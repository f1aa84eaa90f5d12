//! Where a site's landmarks are (LOCATE).

use crate::frame::{Landmark, Pose, World};
use crate::grid::Grid;
use crate::landmark::Format;

/// A landmark of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Its format.
    pub format: Format,
    /// Its payload, an identifier.
    pub payload: u32,
    /// Its pose.
    pub landmark_in_world: Pose<World, Landmark>,
}

/// How a payload says where its landmark is (LOCATE-1).
#[derive(Clone, Debug, PartialEq)]
pub enum Places {
    /// It is the codes of its pose.
    Grid(Grid),
    /// It is looked up; of two equal entries the first counts.
    Table(Vec<Entry>),
}

impl Places {
    /// The pose of a landmark; `None` if the site knows of none (LOCATE-1, LOCATE-2).
    //= reference/SPEC.md#locate
    //# - **LOCATE-1** A landmark's pose in the world MUST be that of its payload on the site's grid (GRID-6), or that
    //# of the table which lists format and payload, whichever the site has.
    #[must_use]
    pub fn landmark_in_world(&self, format: Format, payload: u32) -> Option<Pose<World, Landmark>> {
        match self {
            Self::Grid(grid) => grid.landmark_in_world(format, payload).ok(),
            Self::Table(entries) => {
                let found = entries.iter().find(|entry| entry.format == format && entry.payload == payload);
                found.map(|entry| entry.landmark_in_world)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_knows_its_headings() {
        let places = Places::Grid(Grid { theta_steps: Some(12), ..Grid::default() });
        let pose = places.landmark_in_world(Format::Paper, 0b0000_1100_0101_0011).unwrap();
        assert!((pose.x() - 0.15).abs() < 1e-12 && (pose.y() - 0.25).abs() < 1e-12);
        assert!(places.landmark_in_world(Format::Paper, 0b0000_1100_0101_1100).is_none());
    }

    //= reference/SPEC.md#locate
    //= type=test
    //# - **LOCATE-1** A landmark's pose in the world MUST be that of its payload on the site's grid (GRID-6), or that
    //# of the table which lists format and payload, whichever the site has.
    #[test]
    fn a_table_knows_formats_and_identifiers() {
        let entry = |format, payload, x| Entry { format, payload, landmark_in_world: Pose::new(x, 0.0, 0.0) };
        let places = Places::Table(vec![entry(Format::Paper, 7, 1.0), entry(Format::Wide, 7, 2.0)]);
        let x = |format, payload| places.landmark_in_world(format, payload).map(|pose| pose.x());
        assert_eq!((x(Format::Paper, 7), x(Format::Wide, 7)), (Some(1.0), Some(2.0)));
        assert_eq!(x(Format::Paper, 8), None);
    }
}
