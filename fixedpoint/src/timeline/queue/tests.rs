use super::*;
use proptest::prelude::*;
use std::vec::Vec;

fn time(micros: u64) -> Time {
    Time::from_micros(micros)
}

/// A quarter of 100 ms, of 7 and -3 steps: 1.75 and -0.75, exact in binary.
//= reference/SPEC.md#time
//= type=test
//# - **TIME-1** A reading's steps MUST count as made evenly from the end of the reading before it to its own time.
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
    //= reference/SPEC.md#time
    //= type=test
    //# - **TIME-3** An observation between two readings MUST part the later one's steps in proportion to the time.
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

/// `TIME-6`: what is not after the new begin is gone; `TIME-11`: what is after the newest reading waits.
#[test]
fn what_is_settled_is_forgotten() {
    let mut queue: Queue = Queue::new(time(1_000));
    for at in [1_100, 1_200, 1_300] {
        queue.insert_reading(super::super::Reading { time: time(at), left: Steps::ONE, right: Steps::ONE });
    }
    for at in [1_200, 1_250, 1_300, 1_301, 1_400] {
        queue.insert_observation(super::super::tests::observation(time(at), 1, 0.0));
    }
    assert_eq!(queue.waiting(), 2);
    queue.forget(time(1_200));
    assert_eq!((queue.begin(), queue.newest(), queue.waiting()), (time(1_200), time(1_300), 2));
    assert_eq!((queue.readings.len(), queue.observations.len()), (1, 4));
    assert_eq!(<Queue>::new(time(1_000)).waiting(), 0);
}
