//! The set cover against brute force, and windows against gaps.

use super::cover::Cover;
use super::windows::{Stretch, windows};
use super::{Candidate, solve};
use crate::coverage::{longest_gap, samples};
use crate::site::Route;
use proptest::prelude::*;
use reference::frame::Pose;
use reference::grid::Codes;
use reference::landmark::{Format, Landmark};
use reference::render::Posted;

/// Candidates on one wall, `steps` of 30 mm from its beginning: 30 mm wide, so that those less than 75 mm from each other,
/// 2.5 widths, are too near.
fn on_one_wall(steps: &[u32]) -> Vec<Candidate> {
    let candidate = |&x: &u32| Candidate {
        posted: Posted {
            landmark_in_world: Pose::new(0.03 * f64::from(x), 0.0, core::f64::consts::FRAC_PI_2),
            landmark: Landmark::new(Format::Paper),
            payload: x,
        },
        codes: Codes { x, y: 0, theta: 3 },
        wall: 0,
    };
    steps.iter().map(candidate).collect()
}

/// The size of the smallest choice that holds, if there is one.
fn brute_force(rows: &[Vec<usize>], candidates: &[Candidate]) -> Option<usize> {
    let apart = |a: usize, b: usize| candidates[a].codes.x.abs_diff(candidates[b].codes.x) >= 3;
    let holds = |choice: u32| {
        let taken = |i: usize| choice >> i & 1 == 1;
        let count = candidates.len();
        rows.iter().all(|row| row.iter().any(|&i| taken(i)))
            && (0..count).all(|a| (0..a).all(|b| !(taken(a) && taken(b)) || apart(a, b)))
    };
    (0..1_u32 << candidates.len()).filter(|&choice| holds(choice)).map(|choice| choice.count_ones() as usize).min()
}

proptest! {
    //= reference/SPEC.md#place
    //= type=test
    //# - **PLACE-4** Two landmarks on one wall MUST be at least 1.5 widths of the wider barcode apart.
    //= reference/SPEC.md#place
    //= type=test
    //# - **PLACE-5** Of the choices that fulfil PLACE-3 and PLACE-4 one with the fewest landmarks MUST be taken, and
    //# from it, one landmark after the other exchanged as long as that makes more samples read.
    #[test]
    fn fewest_is_fewest(
        steps in proptest::collection::btree_set(0..24_u32, 1..9),
        rows in proptest::collection::vec(proptest::collection::btree_set(0..9_usize, 1..4), 1..9),
    ) {
        let candidates = on_one_wall(&steps.into_iter().collect::<Vec<_>>());
        let keep = |row: &std::collections::BTreeSet<usize>| -> Vec<usize> {
            row.iter().map(|i| i % candidates.len()).collect()
        };
        let rows: Vec<Vec<usize>> = rows.iter().map(keep).collect();
        // A window of one sample for each row.
        let stretches: Vec<Stretch> = (0..rows.len()).map(|first| Stretch { from: 0.0, first, count: 1 }).collect();
        let seen: Vec<Vec<usize>> =
            (0..candidates.len()).map(|i| (0..rows.len()).filter(|&row| rows[row].contains(&i)).collect()).collect();
        let cover = Cover::new(&stretches, rows.len(), &vec![false; rows.len()], &seen, &candidates);
        let expected = brute_force(&rows, &candidates);
        match solve::fewest(&cover) {
            Ok((chosen, proven)) => {
                prop_assert!(cover.holds(&chosen) && proven);
                prop_assert_eq!(Some(chosen.len()), expected);
                let bound = solve::bound(&cover).unwrap();
                prop_assert!(bound.landmarks <= chosen.len());
                let better = solve::exchange(&cover, chosen.clone());
                prop_assert!(cover.holds(&better) && better.len() == chosen.len());
                prop_assert!(cover.reach(&better) >= cover.reach(&chosen));
            }
            Err(error) => {
                prop_assert_eq!(error, super::PlaceError::TooNear);
                prop_assert_eq!(expected, None);
            }
        }
    }

    /// PLACE-3: every window has a reading sample just where the longest gap (SITE-13) is no longer than the window.
    //= reference/SPEC.md#place
    //= type=test
    //# - **PLACE-3** Every window `(s_i, s_i + G]` of the route, around its end if it is closed, and on an open route
    //# also `[0, G]`, MUST have a sample in it from which a landmark is readable, unless an open route ends within it.
    #[test]
    fn served_windows_are_short_gaps(
        read in proptest::collection::vec(proptest::bool::weighted(0.2), 40),
        closed in any::<bool>(),
        gap in 0.03..1.3f64,
    ) {
        // 1 m in 40 samples: 0.6 m and 0.4 m, or 0.5 m and back.
        let points = if closed { vec![[0.0, 0.0], [0.5, 0.0]] } else { vec![[0.0, 0.0], [0.6, 0.0], [0.6, 0.4]] };
        let samples = samples(&Route { points, closed }, 0.025, 1).unwrap();
        prop_assert_eq!(samples.len(), 40);
        let served = windows(&samples, 1.0, closed, gap).iter().all(|window| window.samples(40).any(|i| read[i]));
        let along: Vec<f64> = (0..40).filter(|&i| read[i]).map(|i| samples[i].along).collect();
        let longest = longest_gap(&along, 1.0, closed).map_or(f64::INFINITY, |gap| gap.length);
        // Not where rounding decides.
        prop_assume!((longest - gap).abs() > 1e-6);
        prop_assert_eq!(served, longest < gap, "{} against {}", longest, gap);
    }
}
