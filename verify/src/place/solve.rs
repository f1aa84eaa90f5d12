//! The fewest candidates that serve all windows: bounds, the mixed-integer program, and a last improvement (PLACE-5).

use super::PlaceError;
use super::cover::Cover;
use super::windows::Stretch;
use microlp::{ComparisonOp, Error, LinearExpr, OptimizationDirection, Problem, SolveOptions, SolveOutcome, Variable};
use std::collections::{BTreeMap, BTreeSet};

/// Nodes of branch and bound after which the best choice so far is taken; a limit in time would not be repeatable.
const MOST_NODES: u64 = 20_000;

/// What the linear program's optimum may be off by.
const LINEAR_ROUNDING: f64 = 1e-6;

/// How few landmarks would do at best.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// Optimum of the linear relaxation.
    pub relaxation: f64,
    /// Windows of which no candidate serves two: each needs a landmark of its own.
    pub disjoint: Vec<Stretch>,
    /// Whether branch and bound proved that fewer do not serve all windows.
    pub proven: bool,
    /// No placement has fewer: the most that one of the three says.
    pub landmarks: usize,
}

impl Bound {
    pub(super) fn with_solution(mut self, count: usize, proven: bool) -> Self {
        self.proven = proven;
        self.landmarks = if proven { count.max(self.landmarks) } else { self.landmarks };
        self
    }
}

/// Bounds that need no integers: the relaxation and disjoint windows.
//= reference/SPEC.md#place
//# - **PLACE-8** The number of landmarks MUST be reported with a lower bound: the most of the linear relaxation's
//# optimum, rounded up, the number of windows of which no landmark serves two, and, if branch and bound came to its
//# end, its optimum.
pub(super) fn bound(cover: &Cover) -> Result<Bound, PlaceError> {
    let disjoint = disjoint(cover);
    let relaxation = if cover.is_trivial() { 0.0 } else { solve(cover, false, None)?.0 };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to the number of windows")]
    let rounded = (relaxation - LINEAR_ROUNDING).ceil().max(0.0) as usize;
    Ok(Bound { relaxation, proven: false, landmarks: rounded.max(disjoint.len()), disjoint })
}

/// Windows of which no candidate serves two, those with the fewest candidates first.
fn disjoint(cover: &Cover) -> Vec<Stretch> {
    let mut used: BTreeSet<usize> = BTreeSet::new();
    let mut found = Vec::new();
    for (window, row) in &cover.rows {
        if used.is_disjoint(row) {
            used.extend(row);
            found.push(*window);
        }
    }
    found
}

/// The fewest candidates, and whether it is proven that they are.
pub(super) fn fewest(cover: &Cover) -> Result<(Vec<usize>, bool), PlaceError> {
    if cover.is_trivial() {
        return Ok((vec![], true));
    }
    let greedy = greedy(cover);
    match solve(cover, true, greedy.as_deref()) {
        Ok((_, chosen, proven)) if cover.holds(&chosen) => Ok((chosen, proven)),
        Err(PlaceError::TooNear) => Err(PlaceError::TooNear),
        // The library says that hard programs may fail; the greedy choice then stands, unproven.
        Ok(_) => greedy.map(|chosen| (chosen, false)).ok_or_else(|| PlaceError::Solver("a wrong answer".to_owned())),
        Err(error) => greedy.map(|chosen| (chosen, false)).ok_or(error),
    }
}

/// Optimum, choice, and whether the optimum is proven.
fn solve(cover: &Cover, integers: bool, start: Option<&[usize]>) -> Result<(f64, Vec<usize>, bool), PlaceError> {
    let mut program = Problem::new(OptimizationDirection::Minimize);
    let columns = cover.columns();
    let add = |&i: &usize| (i, if integers { program.add_binary_var(1.0) } else { program.add_var(1.0, (0.0, 1.0)) });
    let variables: BTreeMap<usize, Variable> = columns.iter().map(add).collect();
    constrain(&mut program, cover, &variables);
    let warm_start = start.map(|chosen| {
        variables.iter().map(|(i, &variable)| (variable, f64::from(u8::from(chosen.contains(i))))).collect()
    });
    let mut options = SolveOptions::default();
    options.node_limit = Some(MOST_NODES);
    options.mip_gap = 0.0;
    options.warm_start = warm_start;
    let outcome = program.solve_with(options).map_err(|error| match error {
        Error::Infeasible => PlaceError::TooNear,
        error => PlaceError::Solver(error.to_string().split_whitespace().collect::<Vec<_>>().join(" ")),
    })?;
    let proven = outcome.is_optimal();
    let SolveOutcome::Solution(solution) = outcome else {
        return Err(PlaceError::Solver("too many nodes".to_owned()));
    };
    let taken = variables.iter().filter(|&(_, &variable)| solution.var_value(variable) > 0.5).map(|(&i, _)| i);
    Ok((solution.objective(), taken.collect(), proven))
}

/// Every window served, no excluded pair.
fn constrain(program: &mut Problem, cover: &Cover, variables: &BTreeMap<usize, Variable>) {
    for (_, row) in &cover.rows {
        let mut sum = LinearExpr::empty();
        row.iter().filter_map(|i| variables.get(i)).for_each(|&variable| sum.add(variable, 1.0));
        program.add_constraint(sum, ComparisonOp::Ge, 1.0);
    }
    for (a, b) in &cover.excluded {
        if let (Some(&a), Some(&b)) = (variables.get(a), variables.get(b)) {
            program.add_constraint([(a, 1.0), (b, 1.0)], ComparisonOp::Le, 1.0);
        }
    }
}

/// Candidate after candidate, the one that serves most of what is left, the lowest number of equals; none if it gets stuck.
fn greedy(cover: &Cover) -> Option<Vec<usize>> {
    let mut left: Vec<&BTreeSet<usize>> = cover.rows.iter().map(|(_, row)| row).collect();
    let mut free = cover.columns();
    let mut chosen = Vec::new();
    while !left.is_empty() {
        let serves = |i: usize| left.iter().filter(|row| row.contains(&i)).count();
        let best = free.iter().copied().max_by_key(|&i| (serves(i), core::cmp::Reverse(i)))?;
        if serves(best) == 0 {
            return None;
        }
        left.retain(|row| !row.contains(&best));
        free.retain(|&i| i != best && !cover.excluded.contains(&(i.min(best), i.max(best))));
        chosen.push(best);
    }
    chosen.sort_unstable();
    Some(chosen)
}

/// Exchanges one landmark at a time for one that lets more of the route be read, as long as there is one (PLACE-5).
pub(super) fn exchange(cover: &Cover, mut chosen: Vec<usize>) -> Vec<usize> {
    let columns = cover.columns();
    let mut reach = cover.reach(&chosen);
    loop {
        let before = reach;
        for place in 0..chosen.len() {
            for &other in &columns {
                let mut changed = chosen.clone();
                changed[place] = other;
                let changed_reach = cover.reach(&changed);
                if changed_reach > reach && cover.holds(&changed) {
                    (chosen, reach) = (changed, changed_reach);
                }
            }
        }
        // The reach grows with every exchange and has an end.
        if reach == before {
            chosen.sort_unstable();
            return chosen;
        }
    }
}
