//! The windows of a route: stretches as long as the gap (PLACE-3).

use super::ROUNDING;
use crate::coverage::Sample;

/// Samples that follow each other, on a closed route also over its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Where it begins, metres along the route.
    pub from: f64,
    /// Number of its first sample.
    pub first: usize,
    /// How many samples it has.
    pub count: usize,
}

impl Stretch {
    /// The numbers of its samples on a route of `all` samples.
    pub fn samples(&self, all: usize) -> impl Iterator<Item = usize> {
        (self.first..self.first + self.count).map(move |i| i % all)
    }
}

/// One window behind every sample that has a whole gap of route behind it, from that sample, exclusive, to the gap's end,
/// inclusive, and on an open route one at its beginning (PLACE-3).
///
/// If each has a sample that reads a landmark, two neighbouring readings at `r` and `r'` are at most a gap apart, since
/// the window behind `r` has one; on an open route the first is at most a gap from the beginning, and the last, behind
/// which no window is left, at most a gap from the end. The converse holds as well.
//= reference/SPEC.md#place
//# - **PLACE-3** Every window `(s_i, s_i + G]` of the route, around its end if it is closed, and on an open route also
//# `[0, G]`, MUST have a sample in it from which a landmark is readable, unless an open route ends within it.
#[must_use]
pub fn windows(samples: &[Sample], length: f64, closed: bool, gap: f64) -> Vec<Stretch> {
    let all = samples.len();
    let along = |i: usize| samples[i % all].along + if i >= all { length } else { 0.0 };
    let last = if closed { 2 * all } else { all };
    let mut found = Vec::new();
    let mut end = 0;
    if !closed && gap < length {
        let count = samples.iter().take_while(|sample| sample.along <= gap + ROUNDING).count();
        found.push(Stretch { from: 0.0, first: 0, count });
    }
    for (i, sample) in samples.iter().enumerate() {
        if !closed && sample.along + gap >= length {
            break;
        }
        end = end.max(i + 1);
        while end < last && along(end) <= sample.along + gap + ROUNDING {
            end += 1;
        }
        // A lap has no more samples than the route.
        found.push(Stretch { from: sample.along, first: i + 1, count: (end - i - 1).min(all) });
    }
    found
}
