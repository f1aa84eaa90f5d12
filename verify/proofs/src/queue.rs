//! The timeline's queue: whom it refuses. What any short sequence leaves of it, a sweep shows.
//!
//! Any well-formed queue is what inserting its items in order makes of an empty one. What it does is the same for any
//! capacity, so a small one is enough.

use fixedpoint::exposure::Time;
use fixedpoint::formats::Steps;
use fixedpoint::refusal::Untimely;
use fixedpoint::timeline::Reading;
use fixedpoint::timeline::queue::Queue;

/// Readings that the queue has room for.
const READINGS: usize = 2;

type Small = Queue<READINGS, 1>;

fn any_time() -> Time {
    Time::from_micros(u64::from(kani::any::<u32>()))
}

fn any_reading() -> Reading {
    Reading { time: any_time(), left: Steps::ZERO, right: Steps::ZERO }
}

/// Any queue of so many readings.
fn any_queue(count: usize) -> Small {
    let mut queue = Small::new(any_time());
    for _ in 0..count {
        let reading = any_reading();
        kani::assume(reading.time > queue.newest());
        queue.insert_reading(reading);
    }
    queue
}

/// Each number of readings by itself, so that places in the queue are constants.
fn by_count(check: fn(usize)) {
    match kani::any::<u8>() {
        0 => check(0),
        1 => check(1),
        _ => check(2),
    }
}

/// A reading is refused exactly where TIME-7, TIME-8 and TIME-9 say.
///
/// - Domain: all queues of up to 2 readings of 2, times of 32 bits.
/// - Fault: `timeline/queue.rs`: `earliest.is_some_and(|earliest| reading.time <= earliest)` →
///   `earliest.is_some_and(|earliest| reading.time > earliest)`: a full queue refuses what is new.
/// - Memory: by cells.
#[kani::proof]
#[kani::unwind(4)]
fn readings_are_refused_as_defined() {
    by_count(reading_is_refused_as_defined);
}

fn reading_is_refused_as_defined(count: usize) {
    let queue = any_queue(count);
    let reading = any_reading();
    let readings = queue.readings();
    let full = readings.len() == READINGS;
    let expected = if reading.time <= queue.begin() {
        Err(Untimely::Late)
    } else if readings.iter().any(|known| known.time == reading.time) {
        Err(Untimely::Duplicate)
    } else if full && reading.time <= readings[0].time {
        Err(Untimely::Late)
    } else {
        Ok(full.then(|| readings[0].time))
    };
    kani::cover!(full && expected == Err(Untimely::Late) && reading.time > queue.begin());
    kani::cover!(expected == Err(Untimely::Duplicate));
    assert_eq!(queue.admit_reading(&reading), expected);
}
