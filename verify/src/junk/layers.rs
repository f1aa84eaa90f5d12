//! Marks of two layers that are not the landmark that is looked for.

use crate::scenes::payload;
use rand::{Rng, RngExt};
use reference::codeword;
use reference::landmark::{Format, stripes};

/// Stripes of the upper and the lower layer, as many in both, true for black.
pub(super) type Layers = [Vec<bool>; 2];

/// A landmark's left guard (LAND-3).
const GUARD: [bool; 4] = [true, false, true, false];

/// Left guards of the same width that are not a landmark's: all that begin with a bar.
const OTHER_GUARDS: [[bool; 4]; 7] = [
    [true, false, false, false],
    [true, false, false, true],
    [true, false, true, true],
    [true, true, false, false],
    [true, true, false, true],
    [true, true, true, false],
    [true, true, true, true],
];

/// Code stripes per layer that no format has; the guards are right.
const OTHER_LENGTHS: [usize; 9] = [8, 9, 10, 11, 13, 14, 15, 17, 18];

/// Left guard, code, mirrored right guard.
fn layer(left: [bool; 4], code: &[bool], right: [bool; 4]) -> Vec<bool> {
    left.iter().chain(code).chain(right.iter().rev()).copied().collect()
}

/// A landmark.
pub(super) fn landmark<R: Rng>(format: Format, rng: &mut R) -> Layers {
    codeword::layers(format, payload(format, rng)).expect("the payload has a code word")
}

/// Guards as a landmark's, random code stripes of another number.
pub(super) fn other_length<R: Rng>(rng: &mut R) -> Layers {
    let count = OTHER_LENGTHS[rng.random_range(0..OTHER_LENGTHS.len())];
    [(); 2].map(|()| {
        let code: Vec<bool> = (0..count).map(|_| rng.random()).collect();
        layer(GUARD, &code, GUARD)
    })
}

/// A landmark whose left, right or both guards are others, the same in both layers.
pub(super) fn other_guards<R: Rng>(rng: &mut R) -> Layers {
    let format = Format::ALL[rng.random_range(0..2)];
    let (left, right) = match rng.random_range(0..3) {
        0 => (other_guard(rng), GUARD),
        1 => (GUARD, other_guard(rng)),
        _ => (other_guard(rng), other_guard(rng)),
    };
    landmark(format, rng).map(|stripes| layer(left, &stripes[GUARD.len()..stripes.len() - GUARD.len()], right))
}

fn other_guard<R: Rng>(rng: &mut R) -> [bool; 4] {
    OTHER_GUARDS[rng.random_range(0..OTHER_GUARDS.len())]
}

/// The upper layer of a `paper` or `wide` landmark and the lower one of another.
pub(super) fn mixed<R: Rng>(rng: &mut R) -> Layers {
    let format = Format::ALL[rng.random_range(0..2)];
    let mut word = || codeword::encode(format, payload(format, rng)).expect("the payload has a code word");
    let ((upper, _), (_, lower)) = (word(), word());
    [stripes(format, upper), stripes(format, lower)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::generator;
    use reference::refusal::PairRefusal;

    /// The payload of layers that are a landmark's, by LAND-1, LAND-3 and CODE.
    fn read(layers: &Layers) -> Option<Result<u32, PairRefusal>> {
        let format = *Format::ALL.iter().find(|format| format.stripes() == layers[0].len())?;
        let words = layers.each_ref().map(|stripes| {
            let code = &stripes[4..stripes.len() - 4];
            let word = code.iter().fold(0, |word, &bar| word << 1 | u32::from(bar));
            (stripes == &reference::landmark::stripes(format, word)).then_some(word)
        });
        Some(codeword::decode(format, words[0]?, words[1]?))
    }

    #[test]
    fn no_mark_is_a_landmark() {
        for index in 0..2000 {
            let rng = &mut generator(2, index);
            assert!(matches!(read(&landmark(Format::Paper, rng)), Some(Ok(_))), "the check itself reads landmarks");
            for layers in [other_length(rng), other_guards(rng)] {
                assert_eq!(layers[0].len(), layers[1].len());
                assert!(layers.iter().all(|stripes| stripes[0] && stripes[stripes.len() - 1]));
                assert_eq!(read(&layers), None);
            }
        }
    }

    /// 100,000 / 256 = 391 with a standard deviation of 20.
    #[test]
    fn one_in_256_mixed_layers_is_a_landmark() {
        let whole = |index| matches!(read(&mixed(&mut generator(3, index))), Some(Ok(_)));
        let count = (0..100_000).filter(|&index| whole(index)).count();
        assert!((311..471).contains(&count), "{count}");
    }
}
