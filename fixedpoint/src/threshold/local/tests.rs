use super::*;
use proptest::prelude::*;
use std::vec::Vec;

/// Both ways to a line's thresholds, which have to agree.
fn thresholds(line: &[u8]) -> Vec<Threshold> {
    let mut blocks = Blocks::new();
    blocks.read(line).unwrap();
    let (pixels, streamed): (Vec<_>, Vec<_>) = blocks.thresholds(line).unzip();
    assert_eq!(pixels, line);
    let single: Vec<_> = (0..u16::try_from(line.len()).unwrap()).map(|i| blocks.at(line, i).unwrap()).collect();
    assert_eq!(streamed, single);
    streamed
}

/// `T2(i)` and `R(i)` as `THRESH-5` and `THRESH-6` put it, pixel by pixel.
fn by_definition(line: &[u8], i: usize) -> (i32, i32) {
    let values: Vec<i32> = line.iter().map(|&pixel| i32::from(pixel)).collect();
    let (b, last) = (i / 16, line.len() - 1);
    let left = &values[(16 * b).saturating_sub(128)..=i];
    let right = &values[i..=last.min(16 * (b + 8) + 15)];
    let high = left.iter().max().unwrap().min(right.iter().max().unwrap());
    let left = &values[(16 * b).saturating_sub(128)..=last.min(i + 1)];
    let right = &values[i.saturating_sub(1)..=last.min(16 * (b + 8) + 15)];
    let low = left.iter().min().unwrap().max(right.iter().min().unwrap());
    (high + low, high - low)
}

/// `high(i)` of a pixel in a line of 640 px at 100, with a pixel of 200 at the place `bright`.
fn high(bright: usize, pixel: usize) -> u8 {
    let mut line = std::vec![100; 640];
    line[bright] = 200;
    // Only what is bright on both sides counts, so the other side has it next to the pixel.
    line[if bright < pixel { pixel + 1 } else { pixel - 1 }] = 200;
    thresholds(&line)[pixel].brightest
}

//= reference/SPEC.md#thresh
//= type=test
//# - **THRESH-5** The left window of pixel `i` MUST be the pixels from `max(0, 16 (b - 8))` to `i`, and its right
//# window those from `i` to `min(Q_x - 1, 16 (b + 8) + 15)`, with `b = floor(i/16)`.
#[test]
fn windows_reach_eight_blocks_beyond_the_own() {
    // The block 20 is from 320 to 335; its windows begin at 192 and end at 463.
    for pixel in [320, 327, 335] {
        assert_eq!((high(191, pixel), high(192, pixel)), (100, 200));
        assert_eq!((high(463, pixel), high(464, pixel)), (200, 100));
    }
    // The next block's are 16 px further.
    assert_eq!((high(207, 336), high(208, 336)), (100, 200));
    assert_eq!((high(479, 336), high(480, 336)), (200, 100));
}

#[test]
fn windows_end_with_the_line() {
    assert_eq!((high(0, 143), high(0, 144)), (200, 100));
    assert_eq!((high(639, 495), high(639, 496)), (100, 200));
}

/// White is 240 in the light and 60 in the shadow, black 20 and 5: at the shadow's edge each side keeps its own white.
#[test]
fn a_shadow_s_edge_leaves_both_sides_their_threshold() {
    let line: Vec<u8> = (0..200).map(|i| [[240, 20], [60, 5]][usize::from(i >= 100)][i / 4 % 2]).collect();
    let found = thresholds(&line);
    // The last black and white in the light, 92 to 95 and 96 to 99: 240 is on both sides, the darkest are 20 and 5.
    assert_eq!(found[94], Threshold { darkest: 20, brightest: 240 });
    assert_eq!(found[98], Threshold { darkest: 20, brightest: 240 });
    // The first black and white in the shadow, 100 to 103 and 104 to 107: 5 is on both sides, the brightest are 240, 60.
    assert_eq!(found[101], Threshold { darkest: 5, brightest: 60 });
    assert_eq!(found[105], Threshold { darkest: 5, brightest: 60 });
    // Not the ends of the line, beside which nothing has another colour.
    for (i, (&pixel, threshold)) in line.iter().zip(&found).enumerate().take(196).skip(4) {
        assert_eq!(threshold.is_black(pixel), i / 4 % 2 == 1, "{i}");
        assert!(threshold.is_distinct(pixel), "{i}");
    }
}

/// A half-covered pixel of 130 between white, 240, and black, 20: wherever it lies in its block, and on either side of the
/// bar, what is dark there is the bar, and not the pixel itself.
#[test]
fn what_is_dark_at_an_outer_edge_is_the_bar() {
    for edge in 32..48 {
        let mut line = [240; 96];
        (line[edge], line[edge + 9]) = (130, 130);
        line[edge + 1..edge + 9].fill(20);
        let found = thresholds(&line);
        for pixel in [edge, edge + 9] {
            assert_eq!(found[pixel], Threshold { darkest: 20, brightest: 240 });
            assert!(!found[pixel].is_black(130));
        }
        // One pixel further out there is only the half-covered one to be seen on one side.
        assert_eq!((found[edge - 1].darkest, found[edge + 10].darkest), (130, 130));
        assert_eq!((found[edge - 2].darkest, found[edge + 11].darkest), (240, 240));
    }
}

/// At the ends of a line there is no pixel beyond.
#[test]
fn nothing_is_beyond_the_ends_of_a_line() {
    let found = thresholds(&[7, 9, 8]);
    let expected = [(7, 7), (7, 9), (8, 8)].map(|(darkest, brightest)| Threshold { darkest, brightest });
    assert_eq!(found, expected);
}

#[test]
fn pixels_outside_the_line_have_no_threshold() {
    let mut blocks = Blocks::new();
    blocks.read(&[7; 40]).unwrap();
    assert_eq!(blocks.at(&[7; 40], 39), Some(Threshold { darkest: 7, brightest: 7 }));
    for pixel in [40, 47, 48, 640, u16::MAX] {
        assert_eq!(blocks.at(&[7; 40], pixel), None);
    }
}

#[test]
fn a_line_longer_than_a_camera_s_is_refused() {
    let mut blocks = Blocks::new();
    assert_eq!(blocks.read(&[7; 640]), Ok(()));
    assert_eq!(blocks.read(&[7; 641]), Err(LineRefusal::Width));
}

/// A long line of 7 leaves nothing to the right of a short one of 9, whose pixel of 2 is at the left.
#[test]
fn what_was_read_before_is_forgotten() {
    let mut blocks = Blocks::new();
    blocks.read(&[7; 640]).unwrap();
    let mut line = [9; 10];
    line[0] = 2;
    blocks.read(&line).unwrap();
    assert_eq!(blocks.at(&line, 3), Some(Threshold { darkest: 9, brightest: 9 }));
}

/// Runs of noise, of any level and width.
fn line() -> impl Strategy<Value = Vec<u8>> {
    let run = (any::<u8>(), 0_u8..40, 1_usize..200);
    (prop::collection::vec(run, 1..40), 1_usize..=640, any::<[u8; 7]>()).prop_map(|(runs, width, noise)| {
        let levels = runs.iter().flat_map(|&(level, spread, width)| std::iter::repeat_n((level, spread), width));
        let noise = noise.iter().cycle();
        let mut line: Vec<u8> =
            levels.zip(noise).map(|((level, spread), noise)| level.saturating_add(noise % (spread + 1))).collect();
        line.truncate(width);
        line
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    //= reference/SPEC.md#thresh
    //= type=test
    //# - **THRESH-6** With `high(i)` the smaller of both windows' largest values and `low(i)` the larger of the
    //# smallest values of the left window with pixel `i + 1` and of the right window with pixel `i - 1`, as far as the
    //# line has them, the local threshold MUST have `T2(i) = high(i) + low(i)` and `R(i) = high(i) - low(i)`.
    //= reference/SPEC.md#thresh
    //= type=test
    //# - **THRESH-7** By the local threshold a pixel MUST be black where `R(i) >= 24` and `2 I < T2(i)`, and white
    //# otherwise.
    //= reference/SPEC.md#thresh
    //= type=test
    //# - **THRESH-8** By the local threshold a pixel MUST be distinct where `R(i) < 24` or `8 |2 I - T2(i)| >= R(i)`.
    #[test]
    fn thresholds_are_as_defined(line in line()) {
        let found = thresholds(&line);
        prop_assert_eq!(found.len(), line.len());
        for (i, (&pixel, threshold)) in line.iter().zip(&found).enumerate() {
            let (twice, range) = by_definition(&line, i);
            prop_assert_eq!((i32::from(threshold.twice()), i32::from(threshold.range())), (twice, range));
            let distance = 2 * i32::from(pixel) - twice;
            prop_assert_eq!(threshold.is_black(pixel), range >= 24 && distance < 0);
            prop_assert_eq!(threshold.is_distinct(pixel), range < 24 || 8 * distance.abs() >= range);
        }
    }

    /// The line's brightest pixel is white and distinct (THRESH).
    #[test]
    fn the_brightest_pixel_is_white(line in line()) {
        let brightest = *line.iter().max().unwrap();
        for (&pixel, threshold) in line.iter().zip(thresholds(&line)) {
            prop_assert!(threshold.darkest <= pixel && pixel <= threshold.brightest);
            prop_assert!(pixel < brightest || !threshold.is_black(pixel) && threshold.is_distinct(pixel));
        }
    }
}
