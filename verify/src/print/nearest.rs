//! What can be printed instead of what cannot: the nearest poses of a grid and the nearest identifiers.

use core::f64::consts::{PI, TAU};
use core::ops::RangeInclusive;
use reference::codeword;
use reference::frame::{Landmark, Pose, World};
use reference::grid::{self, Codes, Grid};
use reference::landmark::Format;

/// How many are named (PRINT-8, PRINT-10).
pub const NAMED: usize = 4;

/// How far around the pose's own codes the nearest are looked for. Four in a row suffice where all have a payload; of
/// any nine neighbours in a row at most a few have none.
const AROUND: u32 = 8;

/// Farther than any site reaches, metres.
const FAR: f64 = 1e6;

/// Up to four poses of the grid that have a payload, the nearest first, of equally near ones the lower codes, in metres and
/// radians (PRINT-8, PRINT-9).
//= reference/SPEC.md#print
//# - **PRINT-8** A pose without a payload MUST be refused with up to four poses of the grid that have one, the nearest
//# first, of equally near ones the lower codes.
#[must_use]
pub fn poses(grid: &Grid, format: Format, pose: &Pose<World, Landmark>) -> Vec<Pose<World, Landmark>> {
    // From beyond a thousand kilometres the order is the same, but no longer to be seen in 53 bits.
    let pose = Pose::new(pose.x().clamp(-FAR, FAR), pose.y().clamp(-FAR, FAR), pose.theta());
    let [x_bits, y_bits, _] = grid::field_bits(format);
    let mut found = Vec::new();
    for x in around((pose.x() - grid.origin[0]) / grid.step[0], x_bits) {
        for y in around((pose.y() - grid.origin[1]) / grid.step[1], y_bits) {
            for theta in 0..grid.headings(format) {
                let codes = Codes { x, y, theta };
                if codeword::encode(format, grid::join(format, codes)).is_ok() {
                    let candidate = grid.pose(format, codes);
                    found.push((distance(&pose, &candidate), codes, candidate));
                }
            }
        }
    }
    // In whole nanometres, so that rounding does not choose between equals.
    found.sort_by(|one, other| (one.0 * 1e9).round().total_cmp(&(other.0 * 1e9).round()).then(one.1.cmp(&other.1)));
    found.into_iter().take(NAMED).map(|(_, _, pose)| pose).collect()
}

/// The codes about a place counted in steps, and the field's ends at most.
fn around(steps: f64, bits: u32) -> RangeInclusive<u32> {
    let last = (1 << bits) - 1;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 2^10")]
    let nearest = steps.round().clamp(0.0, f64::from(last)) as u32;
    nearest.saturating_sub(AROUND)..=(nearest + AROUND).min(last)
}

/// The distance of two poses in metres, a radian of heading being as far as a metre (PRINT-9).
//= reference/SPEC.md#print
//# - **PRINT-9** Poses MUST be as far apart as the root of the sum of the squares of their differences in x and y in
//# metres and in heading in radians.
#[must_use]
pub fn distance(one: &Pose<World, Landmark>, other: &Pose<World, Landmark>) -> f64 {
    let turn = (one.theta() - other.theta()).rem_euclid(TAU);
    let turn = if turn > PI { TAU - turn } else { turn };
    (one.x() - other.x()).hypot(one.y() - other.y()).hypot(turn)
}

/// Up to four payloads that have a code word, the nearest first, of equals the lower (PRINT-10).
//= reference/SPEC.md#print
//# - **PRINT-10** An identifier without a code word MUST be refused with up to four of the nearest that have one, of
//# equally near ones the lower first.
#[must_use]
pub fn ids(format: Format, id: u64) -> Vec<u32> {
    let last = (1_u32 << format.payload_bits()) - 1;
    let start = u32::try_from(id).map_or(last, |id| id.min(last));
    let outwards = (0..=last).flat_map(|away| {
        let up = (away > 0).then(|| start.checked_add(away)).flatten();
        [start.checked_sub(away), up.filter(|&id| id <= last)]
    });
    outwards.flatten().filter(|&id| codeword::encode(format, id).is_ok()).take(NAMED).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The distances of the nearest four among all payloads.
    fn by_trying_all(grid: &Grid, pose: &Pose<World, Landmark>) -> Vec<f64> {
        let all = (0..=0xFFFF).filter(|&payload| codeword::encode(Format::Paper, payload).is_ok());
        let poses = all.filter_map(|payload| grid.landmark_in_world(Format::Paper, payload).ok());
        let mut distances: Vec<f64> = poses.map(|candidate| distance(pose, &candidate)).collect();
        distances.sort_by(f64::total_cmp);
        distances.truncate(4);
        distances
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        //= reference/SPEC.md#print
        //= type=test
        //# - **PRINT-8** A pose without a payload MUST be refused with up to four poses of the grid that have one, the
        //# nearest first, of equally near ones the lower codes.
        #[test]
        fn the_nearest_are_the_nearest_of_all(
            x in -1.0..4.0f64, y in -1.0..4.0f64, theta in -4.0..4.0f64,
            step_x in 0.01..0.2f64, step_y in 0.01..0.2f64, headings in 1..=16_u32,
        ) {
            let grid = Grid { origin: [0.1, -0.2], step: [step_x, step_y], theta_steps: Some(headings) };
            let pose = Pose::new(x, y, theta);
            let found = poses(&grid, Format::Paper, &pose);
            prop_assert!(found.iter().all(|found| grid.payload(Format::Paper, found).is_ok()));
            let found: Vec<f64> = found.iter().map(|found| distance(&pose, found)).collect();
            for (found, nearest) in found.iter().zip(by_trying_all(&grid, &pose)) {
                prop_assert!((found - nearest).abs() < 1e-8);
            }
            prop_assert_eq!(found.len(), 4);
        }
    }

    /// Every pose of the default grid whose code word has equal halves.
    #[test]
    fn around_a_pose_without_code_word_are_four() {
        let grid = Grid::default();
        let equal = (0..=0xFFFF_u32).filter(|&payload| codeword::encode(Format::Paper, payload).is_err());
        for payload in equal {
            let pose = grid.pose(Format::Paper, grid::split(Format::Paper, payload));
            let found: Vec<f64> = poses(&grid, Format::Paper, &pose).iter().map(|f| distance(&pose, f)).collect();
            let nearest = by_trying_all(&grid, &pose);
            assert!(
                found.len() == 4 && found.iter().zip(nearest).all(|(found, nearest)| (found - nearest).abs() < 1e-8)
            );
        }
    }

    /// 30 and 40 mm and 120 mrad, the short way round: the root of 9 + 16 + 144 is 13.
    //= reference/SPEC.md#print
    //= type=test
    //# - **PRINT-9** Poses MUST be as far apart as the root of the sum of the squares of their differences in x and y
    //# in metres and in heading in radians.
    #[test]
    fn a_radian_counts_as_a_metre() {
        let (one, other) = (Pose::new(1.0, 2.0, 3.1), Pose::new(1.03, 1.96, 3.22 - core::f64::consts::TAU));
        assert!((distance(&one, &other) - 0.13).abs() < 1e-12);
    }

    //= reference/SPEC.md#print
    //= type=test
    //# - **PRINT-10** An identifier without a code word MUST be refused with up to four of the nearest that have one,
    //# of equally near ones the lower first.
    #[test]
    fn ids_are_the_nearest_that_have_a_code_word() {
        assert_eq!(ids(Format::Paper, u64::MAX), [0xFFFF, 0xFFFE, 0xFFFD, 0xFFFC]);
        let equal = (0..=0xFFFF).find(|&id| codeword::encode(Format::Paper, id).is_err()).unwrap();
        assert_eq!(ids(Format::Paper, u64::from(equal)), [equal - 1, equal + 1, equal - 2, equal + 2]);
    }
}
