//! Target `filter`: a program of readings and observations, late, double and out of order, through both timelines and filters.
//!
//! Input: a byte of options, then steps of a program: a byte of what happens, then its numbers. A robot makes at most 1000
//! steps of a wheel in a second (SCENARIO-4), and sees landmarks as LAYER says that it does: from where it believes to be
//! or aside of that, with the noise that the measurement claims to have.
//!
//! Besides SAME-7, both timelines are held against what they were given in order: the reference's against its filter,
//! which has no queue, the port's against another timeline, to the last bit (TIME-2, TIME-5).

mod in_order;
mod program;

use crate::draw::Draw;
use crate::fault;
use in_order::InOrder;
use program::{Observation, Program, Reading, Step};
use reference::filter::{Filter, Outcome};
use reference::timeline::{Timeline, Untimely};
use verify::filters::Apart;

/// The most steps of a program.
const LONGEST: usize = 96;

/// How far the pipelines may be from each other: metres, and 0.1° (SAME-7).
const TOGETHER: (f64, f64) = (1e-3, 0.1 * core::f64::consts::PI / 180.0);

/// How near to the gate a NIS may be for the pipelines to decide differently, as a share (SAME-7).
const NEAR_GATE: f64 = 1e-3;

/// One input.
///
/// # Panics
/// If the pipelines take something differently, are too far from each other, or the order in which things came shows.
pub fn run(data: &[u8]) {
    let mut draw = Draw::new(data);
    let mut program = Program::new(&mut draw);
    let mut both = Both::new(&program);
    for _ in 0..LONGEST {
        if draw.is_empty() {
            break;
        }
        let step = program.step(&both.reference, &mut draw);
        match &step {
            Step::Read(reading) => both.read(reading),
            Step::Observe(observation) => both.observe(observation),
            Step::Restart(micros) => both.restart(*micros),
            Step::Nothing => continue,
        }
        let (filter, outcomes) = both.taken.run(&both.begin.0);
        if outcomes.iter().any(is_near_gate) || !both.is_within_declared() {
            return;
        }
        both.stay_together(&filter);
    }
    both.port_is_as_if_in_order();
}

/// Both timelines and what they have taken.
struct Both {
    reference: Timeline,
    port: fixedpoint::timeline::Timeline,
    /// As both timelines began.
    begin: (Filter, fixedpoint::timeline::Timeline),
    taken: InOrder,
}

impl Both {
    fn new(program: &Program) -> Self {
        let (filters, begin) = program.begin();
        let reference = Timeline::new(filters.reference.clone(), reference::exposure::Time::from_micros(begin));
        let port = fixedpoint::timeline::Timeline::new(filters.port, fixedpoint::exposure::Time::from_micros(begin));
        let begin = (filters.reference, port.clone());
        Self { reference, port, begin, taken: InOrder::new(program.begin().1) }
    }

    fn read(&mut self, reading: &Reading) {
        let expected = self.reference.read(&reading.reference());
        let found = self.port.read(&reading.port());
        assert_eq!(expected, found.map_err(untimely), "{reading:?}");
        if expected.is_ok() {
            self.taken.reading(*reading);
        }
    }

    fn observe(&mut self, observation: &Observation) {
        let expected = self.reference.observe(&observation.reference());
        let found = self.port.observe(&observation.port());
        let found = found.map(|outcome| fault::outcome(&self.reference, outcome)).map_err(untimely);
        assert_eq!(expected.map(|_| ()), found.map(|_| ()), "{observation:?}");
        if let (Ok(expected), Ok(found)) = (expected, found) {
            self.taken.observation(observation);
            let near = || self.taken.run(&self.begin.0).1.iter().any(is_near_gate);
            assert!(decided_alike(expected, found) || near(), "decided differently: {expected:?}, {found:?}");
        }
    }

    fn restart(&mut self, micros: u64) {
        self.reference.restart(reference::exposure::Time::from_micros(micros));
        self.port.restart(fixedpoint::exposure::Time::from_micros(micros));
        self.taken.restart(micros);
    }

    /// Whether the wheels' shares are what the port declares to hold; along a route they are 0.2 % and 0.5 % (SAME-7,
    /// ROUTE-10).
    fn is_within_declared(&self) -> bool {
        let most = fixedpoint::motion::State::LARGEST_SHARE.to_num::<f64>();
        let state = self.reference.estimate().state;
        state.wheel_difference.abs().max(state.axle_excess.abs()) < most
    }

    /// SAME-7, and that the reference's queue shows nowhere (TIME-5).
    fn stay_together(&self, filter: &Filter) {
        let [one, other] = [self.reference.estimate(), filter.estimate()];
        let pose = |estimate: &reference::filter::Estimate| {
            let pose = estimate.state.pose;
            [pose.x(), pose.y(), pose.theta()].map(f64::to_bits)
        };
        assert_eq!(pose(one), pose(other), "TIME-5 of the reference");
        assert_eq!(self.reference.counts().filter, filter.counts(), "TIME-5 of the reference");
        assert_eq!(self.reference.time().as_micros(), self.port.time().as_micros(), "TIME-4");
        let apart = Apart::of(self.reference.estimate(), self.port.estimate());
        assert!(apart.position < TOGETHER.0 && apart.heading < TOGETHER.1, "{apart:?}");
        let (counts, found) = (self.reference.counts(), self.port.counts());
        let refused = [counts.late, counts.duplicate, counts.full, counts.dropped];
        assert_eq!(refused, [found.late, found.duplicate, found.full, found.dropped].map(u64::from));
        let decided = [counts.filter.used, counts.filter.gated, counts.filter.recovered];
        let found = [found.filter.used, found.filter.gated, found.filter.recovered].map(u64::from);
        assert_eq!(decided, found, "used, gated, recovered");
    }

    /// TIME-5 of the port: to the last bit.
    fn port_is_as_if_in_order(&self) {
        if let Some(in_order) = self.taken.run_port(self.begin.1.clone()) {
            assert_eq!(in_order.estimate(), self.port.estimate(), "TIME-5 of the port");
            assert_eq!(in_order.counts().filter, self.port.counts().filter, "TIME-5 of the port");
        }
    }
}

/// Whether something has been decided so nearly that the pipelines need not agree on it (SAME-7).
fn is_near_gate(outcome: &Outcome) -> bool {
    outcome.from_gate() < NEAR_GATE
}

fn untimely(refusal: fixedpoint::refusal::Untimely) -> Untimely {
    use fixedpoint::refusal::Untimely as Port;
    match refusal {
        Port::Late => Untimely::Late,
        Port::Duplicate => Untimely::Duplicate,
        Port::Full => Untimely::Full,
    }
}

fn decided_alike(reference: Option<Outcome>, port: Option<fixedpoint::filter::Outcome>) -> bool {
    use fixedpoint::filter::Outcome as Port;
    matches!(
        (reference, port),
        (None, None)
            | (Some(Outcome::Used { .. }), Some(Port::Used))
            | (Some(Outcome::Gated { .. }), Some(Port::Gated))
            | (Some(Outcome::Recovered { .. }), Some(Port::Recovered))
    )
}
