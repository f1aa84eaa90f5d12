//! The detector: all stages from two scan lines to camera poses (LINE).

use crate::accept::View;
use crate::camera::Camera;
use crate::crossing::CrossingRule;
use crate::decode::{DecodedLayer, MAX_LAYERS, decode};
use crate::extents::{Extent, of_line};
use crate::hypotheses::{Hypothesis, hypotheses};
use crate::landmark::{Format, Landmark};
use crate::merge::{Detection, merge, merge_extents, withdraw_ambiguous};
use crate::observer::{Layer, Observer};
use crate::refusal::LineRefusal;
use crate::regions::{Region, regions};
use crate::sampling::Roi;
use crate::skew::Skew;
use crate::threshold::{Threshold, Thresholded, Thresholding, threshold};

/// The landmarks in two scan lines, looked for in the formats of `landmarks` (LINE-1 to LINE-5, MERGE-8). A format that
/// is asked for again is ignored.
//= reference/SPEC.md#line
//# - **LINE-1** A scan line MUST be a slice of 8-bit grey values, one for each column of the camera.
//= reference/SPEC.md#line
//# - **LINE-3** A refusal on one scan line MUST NOT change the results of the other.
//= reference/SPEC.md#line
//# - **LINE-4** Several formats MUST be searched one after the other, each as if it were the only one but for EXTENT-5,
//# before MERGE-7 compares them.
pub fn detect<O: Observer>(
    upper: &[u8],
    lower: &[u8],
    camera: &Camera,
    landmarks: &[Landmark],
    rule: CrossingRule,
    observer: &mut O,
) -> Vec<Detection> {
    detect_moving(upper, lower, camera, landmarks, rule, &Skew::at_rest(), observer)
}

/// The landmarks in two scan lines between whose exposures the camera moves (SKEW); otherwise as [`detect`].
pub fn detect_moving<O: Observer>(
    upper: &[u8],
    lower: &[u8],
    camera: &Camera,
    landmarks: &[Landmark],
    rule: CrossingRule,
    skew: &Skew,
    observer: &mut O,
) -> Vec<Detection> {
    let mut asked: Vec<Landmark> = Vec::new();
    for landmark in landmarks {
        if asked.iter().all(|before| before.format != landmark.format) {
            asked.push(*landmark);
        }
    }
    let mut search = Search { camera, formats: asked.iter().map(|landmark| landmark.format).collect(), rule, observer };
    let (above, below) = (search.line(Layer::Upper, upper), search.line(Layer::Lower, lower));
    let mut detections = Vec::new();
    for (i, landmark) in asked.iter().enumerate() {
        let view = View { lines: [upper, lower], camera, landmark, rule, skew: *skew };
        let tried = merge(&above.found[i].layers, &below.found[i].layers, &view, &mut detections, observer);
        let [dark_above, dark_below] = [above.extents(upper, landmark.format), below.extents(lower, landmark.format)];
        merge_extents(&dark_above, &dark_below, &view, &mut detections, tried, observer);
    }
    withdraw_ambiguous(&detections, observer)
}

/// The decoded ROIs of one line in one format, in the order of MERGE-6.
#[derive(Clone, Debug, Default)]
struct Found {
    layers: Vec<DecodedLayer>,
    /// There were more than [`MAX_LAYERS`]: there are none, and the search has ended (DECODE-2).
    crowded: bool,
}

/// What a line gave.
struct Searched {
    /// The global threshold, `None` for a line that was refused.
    threshold: Option<Threshold>,
    /// Its layers by format.
    found: Vec<Found>,
}

impl Searched {
    fn extents(&self, line: &[u8], format: Format) -> Vec<Extent> {
        self.threshold.map_or(Vec::new(), |threshold| of_line(line, &threshold, format))
    }
}

/// What is looked for, and how.
struct Search<'a, O> {
    camera: &'a Camera,
    formats: Vec<Format>,
    rule: CrossingRule,
    observer: &'a mut O,
}

impl<O: Observer> Search<'_, O> {
    /// What a line gives in each format, first by its global threshold and then by its local one (LINE-5).
    //= reference/SPEC.md#line
    //# - **LINE-5** The upper line MUST be searched before the lower one, each in all formats by its global threshold
    //# (THRESH-1) and then in all formats by its local one (THRESH-6).
    fn line(&mut self, layer: Layer, line: &[u8]) -> Searched {
        let mut found = vec![Found::default(); self.formats.len()];
        let threshold = match self.global_threshold(layer, line) {
            Err(refusal) => {
                self.observer.line_refused(layer, Thresholding::Global, refusal);
                None
            }
            Ok(threshold) => {
                self.thresholded(layer, &Thresholded::global(line, threshold), &mut found);
                self.thresholded(layer, &Thresholded::local(line), &mut found);
                Some(threshold)
            }
        };
        Searched { threshold, found }
    }

    //= reference/SPEC.md#line
    //# - **LINE-2** A scan line whose length is not the camera's width MUST be refused (`Width`).
    fn global_threshold(&mut self, layer: Layer, line: &[u8]) -> Result<Threshold, LineRefusal> {
        if line.len() != self.camera.width {
            return Err(LineRefusal::Width);
        }
        let threshold = threshold(line)?;
        self.observer.threshold(layer, &threshold);
        Ok(threshold)
    }

    /// Adds what a line gives in each format by one of its thresholds.
    fn thresholded(&mut self, layer: Layer, line: &Thresholded<'_>, found: &mut [Found]) {
        let regions = match regions(line) {
            Ok(regions) => regions,
            Err(refusal) => return self.observer.line_refused(layer, line.thresholding(), refusal),
        };
        self.observer.regions(layer, line.thresholding(), &regions);
        for (i, found) in found.iter_mut().enumerate().filter(|(_, found)| !found.crowded) {
            if self.layers(layer, line, &regions, self.formats[i], &mut found.layers).is_err() {
                self.observer.line_refused(layer, line.thresholding(), LineRefusal::TooManyLayers);
                *found = Found { layers: Vec::new(), crowded: true };
            }
        }
    }

    /// Adds the decoded ROIs of one format by one threshold to those before, up to a ninth one (DECODE-2).
    //= reference/SPEC.md#decode
    //# - **DECODE-2** A line MUST give no layers of a format of which it has more than 8 by both thresholds together,
    //# and the search in that format end with the ninth (`TooManyLayers`).
    fn layers(
        &mut self,
        layer: Layer,
        line: &Thresholded<'_>,
        regions: &[Region],
        format: Format,
        layers: &mut Vec<DecodedLayer>,
    ) -> Result<(), Crowded> {
        let decoded_before: Vec<Hypothesis> = layers.iter().map(|layer| layer.hypothesis).collect();
        for hypothesis in hypotheses(regions, format) {
            self.observer.hypothesis(layer, line.thresholding(), format, &hypothesis);
            let (hypothesis, decoded_before) = (&hypothesis, &decoded_before);
            let roi = Roi { line, regions, hypothesis, decoded_before, format, rule: self.rule };
            match decode(&roi, self.camera, self.observer) {
                Err(refusal) => self.observer.refused(refusal),
                Ok(_) if layers.len() == MAX_LAYERS => return Err(Crowded),
                Ok(decoded) => {
                    self.observer.decoded(&decoded);
                    layers.push(decoded);
                }
            }
        }
        Ok(())
    }
}

/// A ninth layer of one line and format.
struct Crowded;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codeword;
    use crate::merge::Decoder;
    use crate::observer::Silent;
    use crate::refusal::HypothesisRefusal;

    /// Two white lines with landmarks whose stripes are 1.5 px wide; half a pixel of black is 128, which is white.
    fn lines(landmarks: &[(u32, usize)]) -> [Vec<u8>; 2] {
        striped(landmarks, 3)
    }

    /// Two white lines with landmarks whose stripes are `halves` half pixels wide.
    fn striped(landmarks: &[(u32, usize)], halves: usize) -> [Vec<u8>; 2] {
        let mut lines = [vec![255_u8; 480], vec![255_u8; 480]];
        for &(payload, first) in landmarks {
            let layers = codeword::layers(Format::Paper, payload).unwrap();
            for (line, stripes) in lines.iter_mut().zip(layers) {
                for half in (0..halves * stripes.len()).filter(|half| stripes[half / halves]) {
                    let pixel = &mut line[first + half / 2];
                    *pixel = if *pixel == 255 { 128 } else { 0 };
                }
            }
        }
        lines
    }

    fn payloads([upper, lower]: &[Vec<u8>; 2], landmarks: &[Landmark]) -> Vec<u32> {
        let found = detect(upper, lower, &Camera::epuck(), landmarks, CrossingRule::Interpolated, &mut Silent);
        found.iter().map(|detection| detection.payload).collect()
    }

    const PAPER: [Format; 1] = [Format::Paper];

    /// Bars of 1.5 px are seeds of 1 px, which reach 50 px: barcodes of 30 px may be 22 px apart.
    //= reference/SPEC.md#decode
    //= type=test
    //# - **DECODE-2** A line MUST give no layers of a format of which it has more than 8 by both thresholds together,
    //# and the search in that format end with the ninth (`TooManyLayers`).
    #[test]
    fn eight_layers_are_read_and_nine_are_too_many() {
        let row = |count: u32| (0..count).map(|i| (0x1234 + i, 10 + 52 * i as usize)).collect::<Vec<_>>();
        let paper = PAPER.map(Landmark::new);
        assert_eq!(payloads(&lines(&row(8)), &paper), (0x1234..0x123C).collect::<Vec<u32>>());
        assert_eq!(payloads(&lines(&row(9)), &paper), []);
    }

    //= reference/SPEC.md#line
    //= type=test
    //# - **LINE-2** A scan line whose length is not the camera's width MUST be refused (`Width`).
    //= reference/SPEC.md#line
    //= type=test
    //# - **LINE-3** A refusal on one scan line MUST NOT change the results of the other.
    #[test]
    fn a_line_of_another_width_or_colour_does_not_change_the_other() {
        #[derive(Default)]
        struct Heard(Vec<(Layer, Option<LineRefusal>)>);
        impl Observer for Heard {
            fn line_refused(&mut self, layer: Layer, thresholding: Thresholding, refusal: LineRefusal) {
                assert_eq!(thresholding, Thresholding::Global);
                self.0.push((layer, Some(refusal)));
            }
            fn decoded(&mut self, _: &DecodedLayer) {
                self.0.push((Layer::Lower, None));
            }
        }
        let [upper, lower] = lines(&[(0x1234, 100)]);
        let paper = PAPER.map(Landmark::new);
        for (bad, refusal) in [(&upper[1..], LineRefusal::Width), (&[9; 480], LineRefusal::LowContrast)] {
            let mut heard = Heard::default();
            let rule = CrossingRule::Interpolated;
            assert_eq!(detect(bad, &lower, &Camera::epuck(), &paper, rule, &mut heard), []);
            assert_eq!(heard.0, [(Layer::Upper, Some(refusal)), (Layer::Lower, None)]);
        }
    }

    #[test]
    fn a_format_that_is_asked_for_twice_is_searched_once() {
        let lines = lines(&[(0x1234, 100)]);
        let twice = [Format::Paper, Format::Wide, Format::Paper].map(Landmark::new);
        assert_eq!(payloads(&lines, &twice), [0x1234]);
        assert_eq!(payloads(&lines, &[]), []);
    }

    /// What the search reports, in order.
    #[derive(Clone, Debug, PartialEq)]
    enum Event {
        Threshold(Layer),
        Regions(Layer, Thresholding),
        Refused(Layer, Thresholding, LineRefusal),
        Hypothesis(Layer, Thresholding, Format),
        Repeated,
        Decoded(Thresholding),
    }

    #[derive(Default)]
    struct Events(Vec<Event>);

    impl Observer for Events {
        fn threshold(&mut self, layer: Layer, _: &Threshold) {
            self.0.push(Event::Threshold(layer));
        }
        fn regions(&mut self, layer: Layer, thresholding: Thresholding, _: &[Region]) {
            self.0.push(Event::Regions(layer, thresholding));
        }
        fn line_refused(&mut self, layer: Layer, thresholding: Thresholding, refusal: LineRefusal) {
            self.0.push(Event::Refused(layer, thresholding, refusal));
        }
        fn hypothesis(&mut self, layer: Layer, thresholding: Thresholding, format: Format, _: &Hypothesis) {
            self.0.push(Event::Hypothesis(layer, thresholding, format));
        }
        fn refused(&mut self, refusal: HypothesisRefusal) {
            if refusal == HypothesisRefusal::Repeated {
                self.0.push(Event::Repeated);
            }
        }
        fn decoded(&mut self, layer: &DecodedLayer) {
            self.0.push(Event::Decoded(layer.thresholding));
        }
    }

    fn events([upper, lower]: &[Vec<u8>; 2], formats: &[Format]) -> (Vec<Detection>, Vec<Event>) {
        let landmarks: Vec<Landmark> = formats.iter().copied().map(Landmark::new).collect();
        let mut heard = Events::default();
        let found = detect(upper, lower, &Camera::epuck(), &landmarks, CrossingRule::Interpolated, &mut heard);
        (found, heard.0)
    }

    //= reference/SPEC.md#line
    //= type=test
    //# - **LINE-4** Several formats MUST be searched one after the other, each as if it were the only one but for
    //# EXTENT-5, before MERGE-7 compares them.
    //= reference/SPEC.md#line
    //= type=test
    //# - **LINE-5** The upper line MUST be searched before the lower one, each in all formats by its global threshold
    //# (THRESH-1) and then in all formats by its local one (THRESH-6).
    #[test]
    fn each_line_is_searched_in_all_formats_globally_and_then_locally() {
        use Event::{Decoded, Hypothesis, Regions, Repeated, Threshold};
        use Format::{Paper, Wide};
        use Layer::{Lower, Upper};
        use Thresholding::{Global, Local};
        // A payload whose stripes are no layer of `wide`, however much its transitions may be off.
        let (found, heard) = events(&lines(&[(0x2d5a, 100)]), &[Wide, Paper]);
        let expected = [Upper, Lower].into_iter().flat_map(|layer| {
            vec![
                Threshold(layer),
                Regions(layer, Global),
                Hypothesis(layer, Global, Wide),
                Hypothesis(layer, Global, Paper),
                Decoded(Global),
                Regions(layer, Local),
                Hypothesis(layer, Local, Wide),
                Hypothesis(layer, Local, Paper),
                Repeated,
            ]
        });
        assert_eq!(heard, expected.collect::<Vec<_>>());
        let read: Vec<_> = found.iter().map(|d| (d.payload, d.decoder)).collect();
        assert_eq!(read, [(0x2d5a, Decoder::Threshold)]);
    }

    /// A shadow from `column` on: white is 63 there, half a pixel of black 38, which is white, and black 12, all less than the
    /// mean of black and white in the light.
    fn shade(lines: &mut [Vec<u8>; 2], column: usize) {
        for line in lines {
            line[column..].iter_mut().for_each(|pixel| *pixel = u8::try_from((u32::from(*pixel) + 64) / 5).unwrap());
        }
    }

    #[test]
    fn what_the_global_threshold_loses_in_a_shadow_the_local_one_reads() {
        let mut lines = striped(&[(0x1234, 50), (0x1235, 250)], 8);
        shade(&mut lines, 160);
        let (found, heard) = events(&lines, &PAPER);
        let read: Vec<_> = found.iter().map(|d| (d.payload, d.decoder)).collect();
        assert_eq!(read, [(0x1234, Decoder::Threshold), (0x1235, Decoder::Threshold)]);
        let decoded_by = |by| heard.iter().filter(|event| **event == Event::Decoded(by)).count();
        assert_eq!((decoded_by(Thresholding::Global), decoded_by(Thresholding::Local)), (2, 2));
        assert_eq!(heard.iter().filter(|event| **event == Event::Repeated).count(), 2);
    }

    /// Both thresholds together: four in the light and four or five in the shadow.
    #[test]
    fn nine_layers_by_both_thresholds_are_too_many() {
        let row = |count: u32| {
            let mut lines = lines(&(0..count).map(|i| (0x1234 + i, 10 + 52 * i as usize)).collect::<Vec<_>>());
            shade(&mut lines, 10 + 52 * 4 - 10);
            events(&lines, &PAPER)
        };
        let (_, heard) = row(8);
        assert_eq!(heard.iter().filter(|event| matches!(event, Event::Decoded(_))).count(), 2 * 8);
        let (nine, heard) = row(9);
        assert_eq!(nine, []);
        let refused = |layer| Event::Refused(layer, Thresholding::Local, LineRefusal::TooManyLayers);
        let refusals: Vec<_> = heard.iter().filter(|event| matches!(event, Event::Refused(..))).cloned().collect();
        assert_eq!(refusals, [refused(Layer::Upper), refused(Layer::Lower)]);
    }

    /// Nine in even light: the search by the local threshold does not begin in that format.
    #[test]
    fn a_crowded_format_is_not_searched_by_the_local_threshold() {
        let crowd = lines(&(0..9).map(|i| (0x1234 + i, 10 + 52 * i as usize)).collect::<Vec<_>>());
        let (_, heard) = events(&crowd, &PAPER);
        assert!(heard.contains(&Event::Refused(Layer::Upper, Thresholding::Global, LineRefusal::TooManyLayers)));
        assert!(heard.contains(&Event::Regions(Layer::Upper, Thresholding::Local)));
        assert!(!heard.contains(&Event::Hypothesis(Layer::Upper, Thresholding::Local, Format::Paper)));
    }

    /// A landmark in the light, and in the dark 140 bars of 1 px which only the local threshold tells apart.
    #[test]
    fn too_many_regions_by_one_threshold_leave_the_other() {
        let mut fence = lines(&[(0x1234, 20)]);
        for line in &mut fence {
            line[190..470].fill(60);
            (190..470).step_by(2).for_each(|i| line[i] = 30);
        }
        let (found, heard) = events(&fence, &PAPER);
        assert_eq!(found.iter().map(|d| d.payload).collect::<Vec<_>>(), [0x1234]);
        let refused = |layer| Event::Refused(layer, Thresholding::Local, LineRefusal::TooManyRegions);
        let refusals: Vec<_> = heard.iter().filter(|event| matches!(event, Event::Refused(..))).cloned().collect();
        assert_eq!(refusals, [refused(Layer::Upper), refused(Layer::Lower)]);
    }
}
