//! Exact ties: a stripe's middle that falls on a boundary between regions belongs to the pixel at its right (SAMPLE-3),
//! in both pipelines, by both rules.

use reference::camera::Camera;
use reference::crossing::CrossingRule;
use reference::landmark::Format;
use reference::observer::Layer;
use reference::refusal::HypothesisRefusal;
use reference::threshold::Thresholding;
use verify::bounds::DECLARED_ERROR;
use verify::lockstep::Setting;
use verify::port::{Cameras, Landmarks};
use verify::trace::{HypothesisTrace, Outcome, SampleTrace, Trace};

/// Pixels of one stripe: an even number, so that a middle falls between two pixels.
const STRIPE: usize = 4;

/// A line with a layer of ideal stripes that begins at pixel `start`, all code stripes white but for the pixels `black`,
/// counted from the layer's left end.
fn line(format: Format, start: usize, black: core::ops::Range<usize>) -> Vec<u8> {
    let n = format.stripes();
    let mut line = vec![255_u8; 480];
    for guard_bar in [0, 2, n - 3, n - 1] {
        line[start + guard_bar * STRIPE..start + (guard_bar + 1) * STRIPE].fill(0);
    }
    line[start + black.start..start + black.end].fill(0);
    line
}

fn setting(format: Format, rule: CrossingRule) -> Setting {
    let cameras = Cameras::new(Camera::epuck()).unwrap();
    Setting { cameras, landmarks: Landmarks::new(&[format]).unwrap(), rule }
}

/// The sample of a stripe in the upper line's only ROI of the global threshold.
fn sample(trace: &Trace, stripe: usize) -> SampleTrace {
    let upper = |roi: &&HypothesisTrace| roi.layer == Layer::Upper && roi.thresholding == Thresholding::Global;
    let rois: Vec<_> = trace.hypotheses.iter().filter(upper).collect();
    assert_eq!(rois.len(), 1);
    *rois[0].samples.iter().find(|sample| sample.stripe == stripe).expect("the stripe was sampled")
}

/// Runs a tie at the middle of `stripe` and checks that it is one and that both pipelines put it in `region`.
fn check(format: Format, black: &core::ops::Range<usize>, stripe: usize, region: usize) {
    for rule in [CrossingRule::Interpolated, CrossingRule::WholePixel] {
        let setting = setting(format, rule);
        for start in 20..60 {
            let line = line(format, start, black.clone());
            let [reference, port] = setting.run(&line, &line);
            let [reference, port] = [sample(&reference, stripe), sample(&port, stripe)];
            assert!(reference.margin < DECLARED_ERROR, "no tie: {reference:?}");
            assert_eq!(reference.region, Some(region), "{rule:?} at {start}");
            assert_eq!(port.region, Some(region), "{rule:?} at {start}");
        }
    }
}

//= reference/SPEC.md#sample
//= type=test
//# - **SAMPLE-4** A pipeline whose arithmetic is not exact MUST treat a middle within its declared error of a boundary
//# as on it.
#[test]
fn on_the_left_side_a_tie_enters_the_next_region() {
    // White up to the middle of stripe 4, black from there: the black region 5 is at the right.
    // Regions: 0 white, 1 bar, 2 space, 3 bar, 4 space and half of stripe 4, 5 black.
    check(Format::Paper, &(4 * STRIPE + 2..7 * STRIPE), 4, 5);
    check(Format::Wide, &(4 * STRIPE + 2..7 * STRIPE), 4, 5);
}

//= reference/SPEC.md#sample
//= type=test
//# - **SAMPLE-3** A region MUST contain the columns from `first - 1/2` inclusive to `last + 1/2` exclusive, so that a
//# middle that falls on a boundary belongs to the pixel at its right.
#[test]
fn on_the_right_side_a_tie_stays_in_the_region() {
    // Black up to the middle of stripe 15, white from there on into the guard: region 6 is at the right.
    check(Format::Paper, &(13 * STRIPE..15 * STRIPE + 2), 15, 6);
    check(Format::Wide, &(17 * STRIPE..19 * STRIPE + 2), 19, 6);
}

/// A white line with a layer of `wide`, its stripes 8 px wide and its code alternating from black on, whose edges lie
/// beside their places by what `moved` says of each, counted from the middle.
fn displaced(start: usize, moved: impl Fn(i32) -> i32) -> Vec<u8> {
    let mut line = vec![255_u8; 480];
    let column = |edge: i32| (i32::try_from(start).unwrap() + 8 * (edge + 12) + moved(edge)).try_into().unwrap();
    // Bars begin at every second edge; the right guard is the left one's mirror image.
    for edge in (-12..8).step_by(2).chain([9, 11]) {
        let (first, end): (usize, usize) = (column(edge), column(edge + 1));
        line[first..end].fill(0);
    }
    line
}

/// SAMPLE-11. Of an extent of 192 px the whole-pixel rule allows differences of 3 + 1 px. Edges that are moved by `d(v)` with
/// `d(-v) = -d(v)`, `Σ v d = 0` leave the least squares where they were: `Σ d`, `Σ v² d` and `Σ v d²` are 0. So ±2 px at the
/// edges 2, 4 and 6 (6 - 4 - 2 = 0) come to exactly 4 px between 4 and 6, and ±3 px to 6 px.
//= reference/SPEC.md#sample
//= type=test
//# - **SAMPLE-11** A pipeline whose arithmetic is not exact MUST treat a difference of SAMPLE-10 within its declared
//# error of the limit as on it.
#[test]
fn a_difference_on_the_limit_is_allowed() {
    let setting = setting(Format::Wide, CrossingRule::WholePixel);
    for (by, refused) in [(2, false), (3, true)] {
        let line = displaced(100, |edge| match edge {
            6 | -4 | -2 => by,
            -6 | 4 | 2 => -by,
            _ => 0,
        });
        for trace in setting.run(&line, &line) {
            let rois: Vec<_> = trace.hypotheses.iter().filter(|roi| roi.layer == Layer::Upper).collect();
            let roi = rois.iter().find(|roi| roi.thresholding == Thresholding::Global).unwrap();
            let residual = roi.residual.expect("all stripes were sampled");
            assert!((residual.difference - f64::from(2 * by)).abs() < DECLARED_ERROR, "{residual:?}");
            assert_eq!(roi.outcome == Outcome::Refused(HypothesisRefusal::Residual), refused, "{:?}", roi.outcome);
        }
    }
}
