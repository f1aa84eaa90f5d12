//! Numbers drawn from a generator, and proofs that are run with them.

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::cell::RefCell;
use std::panic::{catch_unwind, resume_unwind};

/// How often a proof is tried.
const TRIES: u32 = 4_000;

/// How many tries that fulfil all assumptions are enough.
const ENOUGH: u32 = 400;

thread_local!(static GENERATOR: RefCell<ChaCha8Rng> = RefCell::new(ChaCha8Rng::seed_from_u64(0)));

/// How a try ends whose numbers do not fulfil an assumption.
struct Discarded;

/// Any number of so many bits, in the lowest ones: of a few, of all, or next to where the sign changes.
pub(crate) fn bits(count: u32) -> u64 {
    GENERATOR.with_borrow_mut(|generator| {
        let all = u64::MAX >> (64 - count);
        let few = generator.next_u64() & (all >> generator.random_range(0..count));
        let drawn = match generator.random_range(0..8) {
            0..=2 => generator.next_u64(),
            3..=4 => few,
            5 => few.wrapping_neg(),
            6 => generator.random_range(0..4_u64).wrapping_sub(2),
            _ => (all >> 1).wrapping_add(generator.random_range(0..4_u64)).wrapping_sub(1),
        };
        drawn & all
    })
}

/// Goes on only where a condition holds.
pub fn assume(condition: bool) {
    if !condition {
        resume_unwind(Box::new(Discarded));
    }
}

/// As the macro of this name: asked by the checker only.
pub fn cover(_line: u32, _condition: bool) {}

/// Runs a proof with numbers from a seed, which its name is.
///
/// # Panics
/// If the proof does, or if no numbers fulfilled its assumptions.
pub fn sample(name: &str, proof: fn()) {
    let mut seed = [0; 32];
    for (i, byte) in name.bytes().enumerate() {
        seed[i % 32] ^= byte.rotate_left(u32::from(i >= 32));
    }
    GENERATOR.set(ChaCha8Rng::from_seed(seed));
    let mut kept = 0;
    for _ in 0..TRIES {
        match catch_unwind(proof) {
            Ok(()) => kept += 1,
            Err(end) if end.is::<Discarded>() => {}
            Err(failure) => resume_unwind(failure),
        }
        if kept == ENOUGH {
            return;
        }
    }
    assert!(kept > 0, "no numbers that were drawn fulfil the assumptions of {name}");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::any;

    #[test]
    #[should_panic(expected = "assumptions of never")]
    fn a_proof_of_nothing_fails() {
        sample("never", || assume(false));
    }

    #[test]
    #[should_panic(expected = "too large")]
    fn what_is_not_so_is_found() {
        sample("large", || assert!(any::<i64>() < i64::MAX, "too large"));
    }
}
