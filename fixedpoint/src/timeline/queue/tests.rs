use super::*;
use proptest::prelude::*;
use std::vec::Vec;

fn time(micros: u64) -> Time {
    Time::from_micros(micros)
}

/// A quarter of 100 ms, of 7 and -3 steps: 1.75 and -0.75, exact in binary.
#[test]
fn steps_are_made_evenly() {
    let (left, right) = (Steps::from_num(7), Steps::from_num(-3));
    let stretch = Stretch { from: time(1_000_000), to: time(1_100_000), left, right };
    let ways = stretch.ways(time(1_050_000), time(1_075_000));
    assert_eq!((ways.left, ways.right), (Steps::from_num(1.75), Steps::from_num(-0.75)));
    let beyond = stretch.ways(time(0), time(1_025_000));
    assert_eq!((beyond.left, beyond.right), (Steps::from_num(1.75), Steps::from_num(-0.75)));
    assert_eq!(stretch.ways(time(1_100_000), time(2_000_000)), Ways::default());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(5_000))]

    /// TIME-3, of stretches from a microsecond to the whole clock.
    #[test]
    fn parts_are_in_proportion_and_add_up(
        steps in any::<[i32; 2]>(),
        from in 0_u64..1 << 40,
        size in 0_u32..64,
        all in any::<u64>(),
        mut cuts in prop::collection::vec(any::<u32>(), 1..6),
    ) {
        let all = (all >> size).max(1).min(u64::MAX - from);
        let [left, right] = steps.map(Steps::from_bits);
        let stretch = Stretch { from: time(from), to: time(from + all), left, right };
        cuts.sort_unstable();
        let mut at = stretch.from;
        let mut sum = Ways::default();
        let cut = |&cut| from + u64::try_from((u128::from(all) * u128::from(cut)) >> 32).unwrap();
        let ends: Vec<u64> = cuts.iter().map(cut).chain([from + all]).collect();
        for end in ends {
            let ways = stretch.ways(at, time(end));
            let share = (end - at.as_micros()) as f64 / all as f64;
            for (found, steps) in [(ways.left, left), (ways.right, right)] {
                let exact = steps.to_num::<f64>() * share;
                // Half a unit at either end, and 2^-31 of the steps where times lose bits.
                let coarse = if all >> 32 == 0 { 0.0 } else { steps.to_num::<f64>().abs() * 2_f64.powi(-30) };
                let bound = 2_f64.powi(-16) + exact.abs() * 1e-12 + coarse;
                prop_assert!((found.to_num::<f64>() - exact).abs() <= bound, "{found} {exact}");
            }
            (sum.left, sum.right) = (sum.left + ways.left, sum.right + ways.right);
            at = time(end);
        }
        prop_assert_eq!(sum, Ways { left, right });
    }
}
