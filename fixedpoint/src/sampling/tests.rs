use super::*;
use crate::decode::half_word;
use crate::drawing::{draw, runs, stripes};
use crate::observer::Silent;
use crate::regions::{Regions, regions};
use crate::threshold::local::Blocks;
use crate::threshold::{Threshold, Thresholds};
use std::vec::Vec;

const RULES: [CrossingRule; 2] = [CrossingRule::Interpolated, CrossingRule::WholePixel];

/// Records the order of transitions and samples.
#[derive(Default)]
struct Recorder {
    samples: Vec<Sample>,
    crossings: Vec<Crossing>,
    order: Vec<&'static str>,
}

impl Observer for Recorder {
    fn crossing(&mut self, crossing: &Crossing) {
        self.crossings.push(*crossing);
        self.order.push("crossing");
    }

    fn sample(&mut self, sample: &Sample) {
        self.samples.push(*sample);
        self.order.push("sample");
    }
}

fn regions_of(line: &[u8]) -> Regions {
    let mut found = Regions::new();
    regions(line, &Thresholds::Global(Threshold { darkest: 0, brightest: 255 }), &mut found).unwrap();
    found
}

/// The half word of the ROI from the first to the last black region of a line that begins and ends white.
fn sampled<O: Observer>(
    line: &[u8],
    format: Format,
    rule: CrossingRule,
    observer: &mut O,
) -> Result<u16, HypothesisRefusal> {
    let thresholds = Thresholds::Global(Threshold { darkest: 0, brightest: 255 });
    sampled_by(thresholds, line, format, rule, observer)
}

fn sampled_by<O: Observer>(
    thresholds: Thresholds<'_>,
    line: &[u8],
    format: Format,
    rule: CrossingRule,
    observer: &mut O,
) -> Result<u16, HypothesisRefusal> {
    let mut found = Regions::new();
    regions(line, &thresholds, &mut found).unwrap();
    let last_region = found.len() - 2;
    let (first_pixel, last_pixel) = (found.first(1).unwrap(), found.last(last_region).unwrap());
    let hypothesis = Hypothesis { first_region: 1, last_region, first_pixel, last_pixel };
    let scan = Scan { line, thresholds, regions: &found };
    sample(&scan, &hypothesis, format, rule, observer).map(|(stripes, _)| half_word(&stripes, format))
}

/// A layer of stripes of 4 px in a white line of 120 px, from pixel 10 on.
fn layer(format: Format, half_word: u16) -> Vec<u8> {
    let mut line = std::vec![255; 120];
    draw(&mut line, 10, 4, &stripes(format, half_word));
    line
}

//= reference/SPEC.md#sample
//= type=test
//# - **SAMPLE-2** A stripe MUST have the colour of the region that contains the projection of its middle `t = (2 j +
//# 1)/N - 1` by the homography at that time.
//= reference/SPEC.md#decode
//= type=test
//# - **DECODE-1** The half word MUST be the colours of the `N_code` stripes between the guards, black as 1, the
//# left-most stripe as the most significant bit.
#[test]
fn every_half_word_is_sampled() {
    for rule in RULES {
        for word in 0..1 << 12 {
            assert_eq!(sampled(&layer(Format::Paper, word), Format::Paper, rule, &mut Silent), Ok(word));
        }
        for word in (0..=u16::MAX).step_by(7) {
            assert_eq!(sampled(&layer(Format::Wide, word), Format::Wide, rule, &mut Silent), Ok(word));
        }
    }
}

/// The region in which a stripe was sampled.
fn region_of(line: &[u8], rule: CrossingRule, stripe: u8) -> Option<u8> {
    let mut recorder = Recorder::default();
    // Half a stripe is no stripe, so what it decodes to does not matter.
    let _ = sampled(line, Format::Paper, rule, &mut recorder);
    recorder.samples.iter().find(|sample| sample.stripe == stripe).unwrap().region
}

/// Left edges are on columns 9.5 + 4 j, so every middle is on the boundary of two pixels: stripe 6 has its middle at
/// 35.5. Its left half is black (region 5), its right half white (region 6): it belongs to the pixel at its right.
#[test]
fn a_middle_on_a_boundary_belongs_to_the_pixel_at_its_right() {
    for rule in RULES {
        let mut line = layer(Format::Paper, 0b1100_0000_0000);
        line[34..36].fill(0);
        assert_eq!(region_of(&line, rule, 6), Some(6));
        // One pixel more is beyond the tie.
        line[36] = 0;
        assert_eq!(sampled(&line, Format::Paper, rule, &mut Silent), Ok(0b1110_0000_0000));
    }
}

/// The mirror image: stripe 13 has its middle at 63.5, its left half is white (region 4), its right half black.
#[test]
fn a_middle_on_a_boundary_belongs_to_the_pixel_at_its_right_from_the_right_side_too() {
    for rule in RULES {
        let mut line = layer(Format::Paper, 0b0000_0000_0011);
        line[64..66].fill(0);
        assert_eq!(region_of(&line, rule, 13), Some(5));
        line[64] = 255;
        assert_eq!(sampled(&line, Format::Paper, rule, &mut Silent), Ok(0b0000_0000_0011));
    }
}

/// The left edges of two bars, moved apart by `pixels` each. The extent is 80 px: a difference of 1.25 px is allowed by the
/// interpolated rule, of 2.25 px by the other. The least squares follow such a pair by less than a third.
//= reference/SPEC.md#sample
//= type=test
//# - **SAMPLE-10** With `ρ = a + s t - k t z - z` the residual of a transition in HOMOG-1 by the last homography, an
//# ROI MUST be refused (`Residual`) if two of its transitions that have one transition between them differ in ρ by more
//# than `e/64` px, to which the whole-pixel rule adds 1 px and the local threshold 1 px.
#[test]
fn transitions_that_are_not_where_edges_are_are_refused() {
    let moved = |pixels: usize| {
        let mut line = layer(Format::Paper, 0b0101_0000_0000);
        line[30 - pixels..30].fill(0);
        line[38..38 + pixels].fill(255);
        line
    };
    let outcome = |pixels, rule| sampled(&moved(pixels), Format::Paper, rule, &mut Silent);
    let refused = Err(HypothesisRefusal::Residual);
    assert_eq!(outcome(0, CrossingRule::Interpolated), Ok(0b0101_0000_0000));
    assert_eq!(outcome(1, CrossingRule::Interpolated), refused);
    assert_eq!(outcome(1, CrossingRule::WholePixel), Ok(0b0101_0000_0000));
    // Bars that are all wider than spaces are none the worse for it: only the right edges of bars have moved.
    let mut wide = layer(Format::Paper, 0b1010_1010_1010);
    for pixel in (1..wide.len()).rev() {
        if wide[pixel] == 255 && wide[pixel - 1] == 0 {
            wide[pixel] = 0;
        }
    }
    assert_eq!(sampled(&wide, Format::Paper, CrossingRule::Interpolated, &mut Silent), Ok(0b1010_1010_1010));
}

/// As above, to the local threshold, to which black and white are the same here: it allows 1 px more, 2.25 px of 80 and
/// 4.125 px of 200. Moved apart by 2 px in the one and 7 px in the other are 4/3 to 2 and 14/3 to 7 px.
#[test]
fn the_local_threshold_allows_a_pixel_more() {
    let outcome = |width: usize, left: usize, right: usize, local: bool| {
        let mut line = std::vec![255; 240];
        draw(&mut line, 10, width, &stripes(Format::Paper, 0b0101_0000_0000));
        line[10 + 5 * width - left..10 + 5 * width].fill(0);
        line[10 + 7 * width..10 + 7 * width + right].fill(255);
        let mut blocks = Blocks::new();
        blocks.read(&line).unwrap();
        let global = Thresholds::Global(Threshold { darkest: 0, brightest: 255 });
        let thresholds = if local { Thresholds::Local(&blocks) } else { global };
        sampled_by(thresholds, &line, Format::Paper, CrossingRule::Interpolated, &mut Silent)
    };
    let refused = Err(HypothesisRefusal::Residual);
    assert_eq!((outcome(4, 1, 1, true), outcome(4, 1, 1, false)), (Ok(0b0101_0000_0000), refused));
    assert_eq!((outcome(10, 4, 3, true), outcome(10, 4, 3, false)), (refused, refused));
}

/// A layer of one format is not one of the other: the residuals of its guards differ by e/53 (SAMPLE).
#[test]
fn a_layer_of_one_format_is_not_one_of_the_other() {
    let read_as_wide =
        |word| sampled(&layer(Format::Paper, word), Format::Wide, CrossingRule::Interpolated, &mut Silent);
    let read_as_paper =
        |word| sampled(&layer(Format::Wide, word), Format::Paper, CrossingRule::Interpolated, &mut Silent);
    assert!((0..1 << 12).all(|word| read_as_wide(word).is_err()));
    assert!((0..=u16::MAX).step_by(7).all(|word| read_as_paper(word).is_err()));
    let refused = Err(HypothesisRefusal::Residual);
    assert!((0..1 << 12).any(|word| read_as_wide(word) == refused));
    assert!((0..=u16::MAX).step_by(7).any(|word| read_as_paper(word) == refused));
}

/// Transitions and samples of an affine layer in full: middle of the ROI at 49.5 px, 32 units to a pixel.
//= reference/SPEC.md#land
//= type=test
//# - **LAND-3** The left guard MUST be the stripes bar, space repeated `N_guard` times, and the right guard its mirror
//# image.
//= reference/SPEC.md#homog
//= type=test
//# - **HOMOG-2** The first homography of an ROI MUST be that of the `4 N_guard` transitions of its guards: from the
//# left end the edges `j = 0 .. 2 N_guard - 1`, from the right end `j = N .. N - 2 N_guard + 1`, each with the next
//# transition inwards.
//= reference/SPEC.md#sample
//= type=test
//# - **SAMPLE-1** Stripes MUST be sampled from the borders to the centre, alternating, the left one first: 0, N-1, 1,
//# N-2, and so on.
//= reference/SPEC.md#sample
//= type=test
//# - **SAMPLE-7** Where a code stripe falls in the next region inwards, the transition between both MUST be added to
//# the homography as the edge between both stripes, and the homography be solved again before the next stripe.
//= reference/SPEC.md#sample
//= type=test
//# - **SAMPLE-9** Where SAMPLE-8 finds neighbours, the transition between both MUST be added as the middle edge `j =
//# N/2`, and the homography be solved again.
#[test]
fn stripes_are_sampled_from_the_borders_to_the_centre() {
    let mut recorder = Recorder::default();
    let line = layer(Format::Paper, 0b1000_0011_1111);
    sampled(&line, Format::Paper, CrossingRule::Interpolated, &mut recorder).unwrap();

    let order: Vec<u8> = recorder.samples.iter().map(|sample| sample.stripe).collect();
    let expected: Vec<u8> = (0..10).flat_map(|place| [place, 19 - place]).collect();
    assert_eq!(order, expected);
    // The guards, then edges as the sampling meets them: 4, 16, 5, and 10 in the middle.
    let edges: Vec<i8> = recorder.crossings.iter().map(|crossing| crossing.edge).collect();
    assert_eq!(edges, [-10, -9, -8, -7, 10, 9, 8, 7, -6, 6, -5, 0]);
    for crossing in &recorder.crossings {
        assert_eq!(crossing.column, i16::from(crossing.edge) * 4 * 32);
    }
    for sample in &recorder.samples {
        assert_eq!(sample.subpixel_bits, 5);
        let column = (2 * i64::from(sample.stripe) + 1 - 20) * 2 * 32;
        assert_eq!(sample.numerator, column * sample.denominator);
    }
    // Regions: white, then bar 1, 2, bar 3, 4, bar 5 (stripe 4), 6 (5 to 9), bar 7 (10 to 15), 8, bar 9, 10, bar 11.
    let regions: Vec<u8> = recorder.samples.iter().map(|sample| sample.region.unwrap()).collect();
    assert_eq!(regions[..12], [1, 11, 2, 10, 3, 9, 4, 8, 5, 7, 6, 7]);
    assert!(regions[12..].chunks(2).all(|pair| pair == [6, 7]));
    // Each transition is added after the sample that found it.
    let mut expected = std::vec!["crossing"; 8];
    expected.extend(["sample"; 9]);
    expected.extend(["crossing", "sample", "crossing", "sample", "crossing"]);
    expected.extend(["sample"; 9]);
    expected.push("crossing");
    assert_eq!(recorder.order, expected);
}

/// Four bars of one width: the best homography has the middle of stripe 0 in the first space, at 0.95 · 2.483 of the
/// bars' width from the middle, within the 2.5 where that begins.
//= reference/SPEC.md#sample
//= type=test
//# - **SAMPLE-5** A guard stripe `j` from either end that does not fall in the region `j` places from that end of the
//# ROI MUST be refused (`Guard`).
#[test]
fn guards_are_where_they_belong() {
    let mut recorder = Recorder::default();
    let line = runs(&[40, 4, 4, 4, 4, 4, 4, 4, 40]);
    let result = sampled(&line, Format::Paper, CrossingRule::Interpolated, &mut recorder);
    assert_eq!(result, Err(HypothesisRefusal::Guard));
    assert_eq!(recorder.samples.len(), 1);
    assert_eq!((recorder.samples[0].stripe, recorder.samples[0].region), (0, None));
}

//= reference/SPEC.md#sample
//= type=test
//# - **SAMPLE-6** A code stripe that does not fall in the region of the stripe sampled before it on its side, or in the
//# next region inwards within the ROI, MUST be refused (`Transition`).
//= reference/SPEC.md#sample
//= type=test
//# - **SAMPLE-8** When all stripes are sampled, the left and the right side's last regions MUST be the same or
//# neighbours, with the left one at the left, or else the ROI be refused (`Transition`).
#[test]
fn a_bar_between_two_middles_is_one_transition_too_many() {
    let mut line = layer(Format::Paper, 0);
    // Between the middles of the stripes 8 and 9: SAMPLE-6, at stripe 9.
    line[46] = 0;
    let mut recorder = Recorder::default();
    let result = sampled(&line, Format::Paper, CrossingRule::Interpolated, &mut recorder);
    assert_eq!(result, Err(HypothesisRefusal::Transition));
    assert_eq!(recorder.samples.last().map(|s| (s.stripe, s.region)), Some((9, None)));
    // Between the middles of 9 and 10, where both sides meet: SAMPLE-8.
    (line[46], line[49]) = (255, 0);
    let mut recorder = Recorder::default();
    let result = sampled(&line, Format::Paper, CrossingRule::Interpolated, &mut recorder);
    assert_eq!(result, Err(HypothesisRefusal::Transition));
    assert_eq!(recorder.samples.len(), 20);
    assert!(recorder.samples.iter().all(|sample| sample.region.is_some()));
}

/// Bars of 20 px at the left and of 1 px at the right: with `(1 + 0.85 k)²/(1 - 0.85 k)²` = 20, k is 0.75.
#[test]
fn too_oblique_a_barcode_is_implausible() {
    let line = runs(&[10, 20, 20, 20, 52, 1, 1, 1, 20]);
    let mut recorder = Recorder::default();
    let result = sampled(&line, Format::Paper, CrossingRule::Interpolated, &mut recorder);
    assert_eq!(result, Err(HypothesisRefusal::Implausible));
    assert_eq!((recorder.crossings.len(), recorder.samples.len()), (8, 0));
}

/// Hypotheses that belong to no line end in a refusal.
#[test]
fn nonsense_is_refused() {
    let line = layer(Format::Paper, 0x5A5);
    let found = regions_of(&line);
    let thresholds = Thresholds::Global(Threshold { darkest: 0, brightest: 255 });
    let scan = Scan { line: &line, thresholds, regions: &found };
    for (first_region, last_region) in [(0, 0), (7, 1), (0, 255), (255, 0), (200, 255)] {
        for (first_pixel, last_pixel) in [(0, 0), (9, 3), (0, u16::MAX), (u16::MAX, 0), (u16::MAX, u16::MAX)] {
            let hypothesis = Hypothesis { first_region, last_region, first_pixel, last_pixel };
            for format in [Format::Paper, Format::Wide] {
                let result = sample(&scan, &hypothesis, format, CrossingRule::Interpolated, &mut Silent);
                assert!(result.is_err());
            }
        }
    }
}
