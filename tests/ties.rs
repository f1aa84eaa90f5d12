//! Exact ties: a stripe's middle that falls on a boundary between regions belongs to the pixel at its right (SAMPLE-3),
//! in both pipelines, by both rules.

use reference::camera::Camera;
use reference::crossing::CrossingRule;
use reference::landmark::Format;
use reference::observer::Layer;
use reference::threshold::Thresholding;
use verify::bounds::DECLARED_ERROR;
use verify::lockstep::Setting;
use verify::port::{Cameras, Landmarks};
use verify::trace::{HypothesisTrace, SampleTrace, Trace};

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

#[test]
fn on_the_left_side_a_tie_enters_the_next_region() {
    // White up to the middle of stripe 4, black from there: the black region 5 is at the right.
    // Regions: 0 white, 1 bar, 2 space, 3 bar, 4 space and half of stripe 4, 5 black.
    check(Format::Paper, &(4 * STRIPE + 2..7 * STRIPE), 4, 5);
    check(Format::Wide, &(4 * STRIPE + 2..7 * STRIPE), 4, 5);
}

#[test]
fn on_the_right_side_a_tie_stays_in_the_region() {
    // Black up to the middle of stripe 15, white from there on into the guard: region 6 is at the right.
    check(Format::Paper, &(13 * STRIPE..15 * STRIPE + 2), 15, 6);
    check(Format::Wide, &(17 * STRIPE..19 * STRIPE + 2), 19, 6);
}
