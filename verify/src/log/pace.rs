//! Whether a file's times go on evenly (LOG-12).

use super::fault::Reason;
use super::time::Time;
use std::collections::VecDeque;

/// How many steps of time the median is of.
const WINDOW: usize = 99;

/// A reading that comes so many times the median step after the one before is after a gap.
const FACTOR: u64 = 5;

/// A reading that comes more than so much after the one before is after a gap, microseconds.
const LONGEST_STEP: u64 = 1_000_000;

/// What was seen of a file's times.
#[derive(Debug, Default)]
pub(super) struct Pace {
    last: Option<Time>,
    steps: Steps,
}

impl Pace {
    /// What is odd about a row's arrival; of a reading also that it comes at the same time or after a gap.
    //= reference/SPEC.md#log
    //# - **LOG-12** A row whose arrival is before that of the row before it in its file MUST be warned, as a reading is
    //# that repeats the time before it, that comes more than 1 s after it, or that comes after more than five times the
    //# median of the up to 99 last steps of time.
    pub(super) fn next(&mut self, time: Time, reading: bool) -> Option<(Reason, String)> {
        let last = self.last.replace(time)?;
        if time < last {
            return Some((Reason::StepBack, format!("{time} s is before the row before, {last} s")));
        }
        if !reading {
            return None;
        }
        let step = time.micros() - last.micros();
        if step == 0 {
            return Some((Reason::Repeated, format!("{time} s is the time of the row before")));
        }
        let median = self.steps.median();
        self.steps.push(step);
        let beyond = step > LONGEST_STEP || median.is_some_and(|median| step > FACTOR.saturating_mul(median));
        let gap = Time::from_micros(step).unwrap_or_default();
        beyond.then(|| (Reason::Gap, format!("{time} s is {gap} s after the row before")))
    }
}

/// The last steps of time, in the order in which they came and in that of their sizes.
#[derive(Debug, Default)]
struct Steps {
    recent: VecDeque<u64>,
    sorted: Vec<u64>,
}

impl Steps {
    /// Of an even number of steps the larger of the two in the middle.
    fn median(&self) -> Option<u64> {
        self.sorted.get(self.sorted.len() / 2).copied()
    }

    fn push(&mut self, step: u64) {
        if self.recent.len() == WINDOW
            && let Some(oldest) = self.recent.pop_front()
        {
            let place = self.sorted.partition_point(|&other| other < oldest);
            self.sorted.remove(place);
        }
        self.recent.push_back(step);
        let place = self.sorted.partition_point(|&other| other < step);
        self.sorted.insert(place, step);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reasons(millis: &[u64], readings: bool) -> Vec<Option<Reason>> {
        let mut pace = Pace::default();
        let time = |millis: u64| Time::from_micros(1000 * millis).unwrap();
        millis.iter().map(|&at| pace.next(time(at), readings).map(|(reason, _)| reason)).collect()
    }

    #[test]
    fn a_gap_is_more_than_five_steps_or_a_second() {
        let gap = Some(Reason::Gap);
        // Steps of 100 ms; 500 ms is five times that and no gap, 501 ms is one.
        assert_eq!(reasons(&[0, 100, 200, 700, 800, 1301, 1401], true), [None, None, None, None, None, gap, None]);
        // A second is no gap where steps are long, more is one, from the first step on.
        assert_eq!(reasons(&[0, 1000, 2000, 3001], true), [None, None, None, gap]);
        assert_eq!(reasons(&[0, 1001], true), [None, gap]);
        // Images come when they come.
        assert_eq!(reasons(&[0, 100, 200, 9000], false), [None; 4]);
    }

    #[test]
    fn steps_back_and_repetitions() {
        let (back, same) = (Some(Reason::StepBack), Some(Reason::Repeated));
        assert_eq!(reasons(&[100, 200, 150, 250, 250, 350], true), [None, None, back, None, same, None]);
        // Landmarks of one image have one time.
        assert_eq!(reasons(&[100, 100, 50], false), [None, None, back]);
    }

    /// Against sorting the last 99 steps.
    #[test]
    fn the_median_is_of_the_last_steps() {
        let mut steps = Steps::default();
        let mut all: Vec<u64> = Vec::new();
        for i in 0..1000_u64 {
            let step = i * i * 7919 % 1009;
            steps.push(step);
            all.push(step);
            let mut recent = all[all.len().saturating_sub(99)..].to_vec();
            recent.sort_unstable();
            assert_eq!(steps.median(), Some(recent[recent.len() / 2]));
        }
    }
}
