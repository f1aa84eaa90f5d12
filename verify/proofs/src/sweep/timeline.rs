//! The timeline's queue: what any short sequence leaves of it.

use fixedpoint::covariance::PoseCovariance;
use fixedpoint::exposure::Time;
use fixedpoint::formats::{Angle, Length, Steps};
use fixedpoint::frame::Pose;
use fixedpoint::landmark::Landmark;
use fixedpoint::layers::MeasuredLayer;
use fixedpoint::observation::{Seen, Sighting};
use fixedpoint::timeline::queue::Queue;
use fixedpoint::timeline::{LATENESS, Observation, Reading};

/// Readings and observations that the queue has room for.
type Small = Queue<3, 2>;

fn reading(time: u64) -> Reading {
    Reading { time: Time::from_micros(time), left: Steps::ZERO, right: Steps::ZERO }
}

fn observation(time: u64, payload: u32) -> Observation {
    let nowhere = || (Length::ZERO, Length::ZERO, Angle::ZERO);
    let ((x, y, theta), landmark) = (nowhere(), Landmark::paper());
    let sighting = Sighting {
        place: Pose::new(x, y, theta),
        landmark,
        pose: Pose::new(x, y, theta),
        covariance: PoseCovariance::default(),
        seen: Seen::Pose,
    };
    Observation { time: Time::from_micros(time), image: 0, payload, layer: MeasuredLayer::Both, sighting }
}

fn is_well_formed(queue: &Small) -> bool {
    let (readings, seen) = (queue.readings(), queue.observations());
    readings.windows(2).all(|pair| pair[0].time < pair[1].time)
        && seen.windows(2).all(|pair| (pair[0].time, pair[0].payload) < (pair[1].time, pair[1].payload))
        && readings.iter().all(|reading| reading.time > queue.begin())
        && seen.iter().all(|seen| seen.time > queue.begin())
}

/// What is admitted finds room and is in the queue, in order and after the queue's begin, and what was in it and is not settled
/// still is; what is refused changes nothing.
///
/// - Domain: all sequences of 6 readings and observations of 2 landmarks, at 5 times 300 ms apart, in a queue for 3 and 2.
/// - Fault: `timeline/queue.rs`: `self.observations.retain(|observation| observation.time > to);` →
///   `self.observations.retain(|observation| observation.time >= to);`: what is settled stays.
/// - Seconds: 120
pub(crate) fn a_queue_stays_well_formed() {
    follow(&Small::new(Time::from_micros(0)), 6);
}

fn follow(queue: &Small, left: u8) {
    assert!(is_well_formed(queue), "{queue:?}");
    if left == 0 {
        return;
    }
    for time in (0..5).map(|step| step * LATENESS / 2) {
        follow(&with_reading(queue.clone(), &reading(time)), left - 1);
        for payload in [1, 2] {
            follow(&with_observation(queue.clone(), &observation(time, payload)), left - 1);
        }
    }
}

fn with_reading(mut queue: Small, reading: &Reading) -> Small {
    let Ok(settled) = queue.admit_reading(reading) else { return queue };
    forget(&mut queue, settled);
    let before = queue.readings().len();
    assert!(before < 3, "{queue:?}");
    queue.insert_reading(*reading);
    assert!(queue.readings().len() == before + 1 && queue.readings().contains(reading), "{queue:?}");
    if let Some(outdated) = queue.outdated() {
        forget(&mut queue, Some(outdated));
    }
    let newest = queue.newest();
    assert!(queue.readings().iter().all(|reading| newest.since(reading.time) < LATENESS), "{queue:?}");
    queue
}

fn with_observation(mut queue: Small, observation: &Observation) -> Small {
    let Ok(settled) = queue.admit_observation(observation) else { return queue };
    forget(&mut queue, settled);
    let before = queue.observations().len();
    assert!(before < 2, "{queue:?}");
    queue.insert_observation(*observation);
    assert!(queue.observations().len() == before + 1 && queue.observations().contains(observation), "{queue:?}");
    queue
}

/// Settles a queue up to a reading: only what is not after it goes.
fn forget(queue: &mut Small, settled: Option<Time>) {
    let Some(settled) = settled else { return };
    assert!(queue.readings().iter().any(|reading| reading.time == settled), "{queue:?}");
    let readings = queue.readings().iter().filter(|reading| reading.time > settled).count();
    let observations = queue.observations().iter().filter(|seen| seen.time > settled).count();
    queue.forget(settled);
    assert_eq!((queue.readings().len(), queue.observations().len()), (readings, observations));
    assert_eq!(queue.begin(), settled);
}
