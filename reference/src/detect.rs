//! The detector: all stages from two scan lines to camera poses (LINE).

use crate::camera::Camera;
use crate::crossing::CrossingRule;
use crate::decode::{DecodedLayer, MAX_LAYERS, decode};
use crate::hypotheses::hypotheses;
use crate::landmark::{Format, Landmark};
use crate::merge::{Detection, merge, withdraw_ambiguous};
use crate::observer::{Layer, Observer};
use crate::refusal::LineRefusal;
use crate::regions::{Region, regions};
use crate::sampling::Roi;
use crate::threshold::{Threshold, threshold};

/// A line whose first two stages succeeded.
struct Segmented<'a> {
    layer: Layer,
    line: &'a [u8],
    threshold: Threshold,
    regions: Vec<Region>,
}

/// The landmarks in two scan lines, looked for in the formats of `landmarks` (LINE-1 to LINE-4, MERGE-8). A format that
/// is asked for again is ignored.
pub fn detect<O: Observer>(
    upper: &[u8],
    lower: &[u8],
    camera: &Camera,
    landmarks: &[Landmark],
    rule: CrossingRule,
    observer: &mut O,
) -> Vec<Detection> {
    let upper = segment(Layer::Upper, upper, camera, observer);
    let lower = segment(Layer::Lower, lower, camera, observer);
    let mut detections = Vec::new();
    let mut asked: Vec<Format> = Vec::new();
    for landmark in landmarks {
        if !asked.contains(&landmark.format) {
            asked.push(landmark.format);
            let mut search =
                |line: &Option<Segmented<'_>>| layers(line.as_ref(), landmark.format, camera, rule, observer);
            let (above, below) = (search(&upper), search(&lower));
            merge(&above, &below, camera, landmark, &mut detections, observer);
        }
    }
    withdraw_ambiguous(&detections, observer)
}

fn segment<'a, O: Observer>(layer: Layer, line: &'a [u8], camera: &Camera, observer: &mut O) -> Option<Segmented<'a>> {
    let found = try_segment(layer, line, camera, observer);
    found.map_err(|refusal| observer.line_refused(layer, refusal)).ok()
}

fn try_segment<'a, O: Observer>(
    layer: Layer,
    line: &'a [u8],
    camera: &Camera,
    observer: &mut O,
) -> Result<Segmented<'a>, LineRefusal> {
    if line.len() != camera.width {
        return Err(LineRefusal::Width);
    }
    let threshold = threshold(line)?;
    observer.threshold(layer, &threshold);
    let regions = regions(line, &threshold)?;
    observer.regions(layer, &regions);
    Ok(Segmented { layer, line, threshold, regions })
}

/// All decoded ROIs of a line in one format; none if they are too many (DECODE-2).
fn layers<O: Observer>(
    line: Option<&Segmented<'_>>,
    format: Format,
    camera: &Camera,
    rule: CrossingRule,
    observer: &mut O,
) -> Vec<DecodedLayer> {
    let Some(Segmented { layer, line, threshold, regions }) = line else { return Vec::new() };
    let mut layers = Vec::new();
    for hypothesis in hypotheses(regions, format) {
        observer.hypothesis(*layer, format, &hypothesis);
        let roi = Roi { line, threshold, regions, hypothesis: &hypothesis, format, rule };
        match decode(&roi, camera, observer) {
            Err(refusal) => observer.refused(refusal),
            Ok(_) if layers.len() == MAX_LAYERS => {
                observer.line_refused(*layer, LineRefusal::TooManyLayers);
                return Vec::new();
            }
            Ok(decoded) => {
                observer.decoded(&decoded);
                layers.push(decoded);
            }
        }
    }
    layers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codeword;
    use crate::observer::Silent;

    /// Two white lines with landmarks whose stripes are 1.5 px wide; half a pixel of black is 128, which is white.
    fn lines(landmarks: &[(u32, usize)]) -> [Vec<u8>; 2] {
        let mut lines = [vec![255_u8; 480], vec![255_u8; 480]];
        for &(payload, first) in landmarks {
            let layers = codeword::layers(Format::Paper, payload).unwrap();
            for (line, stripes) in lines.iter_mut().zip(layers) {
                for half in (0..3 * stripes.len()).filter(|half| stripes[half / 3]) {
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
    #[test]
    fn eight_layers_are_read_and_nine_are_too_many() {
        let row = |count: u32| (0..count).map(|i| (0x1234 + i, 10 + 52 * i as usize)).collect::<Vec<_>>();
        let paper = PAPER.map(Landmark::new);
        assert_eq!(payloads(&lines(&row(8)), &paper), (0x1234..0x123C).collect::<Vec<u32>>());
        assert_eq!(payloads(&lines(&row(9)), &paper), []);
    }

    #[test]
    fn a_line_of_another_width_or_colour_does_not_change_the_other() {
        #[derive(Default)]
        struct Heard(Vec<(Layer, Option<LineRefusal>)>);
        impl Observer for Heard {
            fn line_refused(&mut self, layer: Layer, refusal: LineRefusal) {
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
}
