//! The set cover: which candidates serve which windows, and which exclude each other.

use super::candidates::Candidate;
use super::windows::Stretch;
use std::collections::{BTreeMap, BTreeSet};

/// A set cover with excluded pairs.
#[derive(Clone, Debug)]
pub(super) struct Cover {
    /// For each window that must still be served, its candidates; none has all of another one's.
    pub(super) rows: Vec<(Stretch, BTreeSet<usize>)>,
    /// Pairs of candidates, the lower number first, that must not both be chosen.
    pub(super) excluded: BTreeSet<(usize, usize)>,
    /// Candidates that must not be chosen.
    pub(super) banned: BTreeSet<usize>,
    /// For each candidate the samples that show it.
    pub(super) seen: Vec<Vec<usize>>,
    original: bool,
}

impl Cover {
    pub(super) fn new(
        windows: &[Stretch],
        samples: usize,
        served: &[bool],
        seen: &[Vec<usize>],
        candidates: &[Candidate],
    ) -> Self {
        let mut by_sample = vec![Vec::new(); samples];
        for (candidate, numbers) in seen.iter().enumerate() {
            for &i in numbers {
                by_sample[i].push(candidate);
            }
        }
        let open = windows.iter().filter(|window| !window.samples(samples).any(|i| served[i]));
        let mut distinct: BTreeMap<BTreeSet<usize>, Stretch> = BTreeMap::new();
        for window in open {
            let row: BTreeSet<usize> = window.samples(samples).flat_map(|i| by_sample[i].iter().copied()).collect();
            distinct.entry(row).or_insert(*window);
        }
        let rows = minimal(distinct);
        let used: BTreeSet<usize> = rows.iter().flat_map(|(_, row)| row.iter().copied()).collect();
        let pairs = used.iter().flat_map(|&a| used.range(a + 1..).map(move |&b| (a, b)));
        let excluded = pairs.filter(|&(a, b)| candidates[a].too_near(&candidates[b])).collect();
        Self { rows, excluded, banned: BTreeSet::new(), seen: seen.to_vec(), original: true }
    }

    /// Whether every window has a candidate.
    pub(super) fn is_possible(&self) -> bool {
        self.rows.iter().all(|(_, row)| !row.is_empty())
    }

    /// Whether there is nothing to serve.
    pub(super) fn is_trivial(&self) -> bool {
        self.rows.is_empty()
    }

    /// Whether nothing was excluded since it was made, so that its optimum is a bound for every placement.
    pub(super) fn is_original(&self) -> bool {
        self.original
    }

    /// Excludes a pair; whether it was not excluded before.
    pub(super) fn exclude_pair(&mut self, a: usize, b: usize) -> bool {
        self.original = false;
        self.excluded.insert((a.min(b), a.max(b)))
    }

    /// Excludes a candidate; whether it was not excluded before.
    pub(super) fn exclude(&mut self, a: usize) -> bool {
        self.original = false;
        self.banned.insert(a)
    }

    /// Candidates that serve a window, ascending.
    pub(super) fn columns(&self) -> Vec<usize> {
        let used: BTreeSet<usize> = self.rows.iter().flat_map(|(_, row)| row.iter().copied()).collect();
        used.difference(&self.banned).copied().collect()
    }

    /// Whether the candidates serve every window and none excludes another.
    pub(super) fn holds(&self, chosen: &[usize]) -> bool {
        let served = self.rows.iter().all(|(_, row)| chosen.iter().any(|i| row.contains(i)));
        let mut pairs = chosen.iter().flat_map(|&a| chosen.iter().map(move |&b| (a, b)));
        served && !chosen.iter().any(|i| self.banned.contains(i)) && !pairs.any(|pair| self.excluded.contains(&pair))
    }

    /// How many samples show one of the candidates.
    pub(super) fn reach(&self, chosen: &[usize]) -> usize {
        let shown: BTreeSet<usize> = chosen.iter().flat_map(|&i| self.seen[i].iter().copied()).collect();
        shown.len()
    }
}

/// The rows that have no other row in them: whatever serves those serves all.
fn minimal(rows: BTreeMap<BTreeSet<usize>, Stretch>) -> Vec<(Stretch, BTreeSet<usize>)> {
    let mut by_size: Vec<(Stretch, BTreeSet<usize>)> = rows.into_iter().map(|(row, window)| (window, row)).collect();
    by_size.sort_by_key(|(_, row)| row.len());
    let mut kept: Vec<(Stretch, BTreeSet<usize>)> = Vec::new();
    for (window, row) in by_size {
        if !kept.iter().any(|(_, smaller)| smaller.is_subset(&row)) {
            kept.push((window, row));
        }
    }
    kept
}
