//! What lines are too long for the model checker.

use fixedpoint::crossing::{Crossing, CrossingRule, Grid, Scan};
use fixedpoint::homography::Normal;
use fixedpoint::hypotheses::{Hypothesis, Taken, check, hypotheses};
use fixedpoint::landmark::Format;
use fixedpoint::refusal::LineRefusal;
use fixedpoint::regions::{Colour, Regions, regions};
use fixedpoint::threshold::local::Blocks;
use fixedpoint::threshold::{Threshold, Thresholds};

/// The windows of THRESH-5 reach as far as they say, and a threshold is the same whether it is asked for alone or met
/// on the way.
///
/// - Domain: lines of 640 and of 313 pixels of one value but for two that are darker or brighter, 256 to 272 pixels
///   apart or the second beyond the end, wherever; all pixels.
/// - Fault: `threshold/local.rs`: `const REACH: usize = 8;` → `const REACH: usize = 9;`: windows of a block more.
pub(crate) fn local_thresholds_are_those_of_their_windows() {
    let mut blocks = Blocks::new();
    for (length, apart) in [640_usize, 313].into_iter().flat_map(|length| (256..=272).map(move |apart| (length, apart)))
    {
        for (place, value) in (0..length).flat_map(|place| [(place, 0), (place, 255)]) {
            let mut line = vec![100_u8; length];
            line.iter_mut().skip(place).step_by(apart).take(2).for_each(|pixel| *pixel = value);
            blocks.read(&line).expect("a camera has as many pixels");
            for (pixel, (met, threshold)) in (0..length).zip(blocks.thresholds(&line)) {
                let expected = defined(&line, pixel);
                assert_eq!((met, threshold), (line[pixel], expected), "{length} {place} {value} {pixel}");
                let alone = blocks.at(&line, u16::try_from(pixel).expect("it is short"));
                assert_eq!(alone, Some(expected), "{length} {place} {value} {pixel}");
            }
        }
    }
}

/// THRESH-5 and THRESH-6 as they stand.
fn defined(line: &[u8], pixel: usize) -> Threshold {
    let (block, end) = (pixel / 16, line.len() - 1);
    let left = &line[16 * block.saturating_sub(8)..=pixel];
    let right = &line[pixel..=end.min(16 * (block + 8) + 15)];
    let smallest = |window: &[u8], beyond: &[u8]| window.iter().chain(beyond).min().copied().unwrap_or(u8::MAX);
    let largest = |window: &[u8]| window.iter().max().copied().unwrap_or(0);
    let next = &line[(pixel + 1).min(end)..=(pixel + 1).min(end)];
    let previous = &line[pixel.saturating_sub(1)..=pixel.saturating_sub(1)];
    Threshold {
        darkest: smallest(left, next).max(smallest(right, previous)),
        brightest: largest(left).min(largest(right)),
    }
}

/// A region is a maximal run of pixels of one colour after the contrast filter: of a raw region without a distinct pixel, the
/// colour of the nearest one to its left that has one, or else of the first that has.
///
/// - Domain: all lines of up to 10 pixels that are each black or white, distinct or not; nothing else of a pixel counts.
/// - Fault: `regions.rs`: `if region_colour != Some(colour) && threshold.is_distinct(pixel)` →
///   `if region_colour != Some(colour) && run_first == index && threshold.is_distinct(pixel)`: a run counts by its first
///   pixel only.
pub(crate) fn regions_are_as_defined() {
    let threshold = Threshold { darkest: 0, brightest: 160 }; // distinct from 5 grey levels on
    let kinds =
        [(0, Colour::Black, true), (79, Colour::Black, false), (80, Colour::White, false), (160, Colour::White, true)];
    let mut found = Regions::new();
    for length in 1..=10_u32 {
        for number in 0..4_usize.pow(length) {
            let line: Vec<_> = (0..length).map(|i| kinds[number >> (2 * i) & 3]).collect();
            let pixels: Vec<u8> = line.iter().map(|pixel| pixel.0).collect();
            regions(&pixels, &Thresholds::Global(threshold), &mut found).expect("at most 10 regions");
            let mut expected: Vec<(u16, Colour)> = Vec::new();
            let mut first = 0;
            for run in line.chunk_by(|one, other| one.1 == other.1) {
                let colour = run[0].1;
                if run.iter().any(|pixel| pixel.2) && expected.last().is_none_or(|known| known.1 != colour) {
                    expected.push((if expected.is_empty() { 0 } else { first }, colour));
                }
                first += u16::try_from(run.len()).expect("it is short");
            }
            let regions: Vec<_> = (0..found.len())
                .map(|region| (found.first(region).expect("it is there"), found.colour(region)))
                .collect();
            assert_eq!(regions, expected, "{pixels:?}");
        }
    }
}

/// The 256th region is refused, and none is left.
///
/// - Domain: black and white pixels in turn, 250 to 260 of them, either colour first, one of them twice, wherever.
/// - Fault: `regions.rs`: `self.firsts.push(first).map_err(|_| LineRefusal::TooManyRegions)?;` →
///   `self.firsts.push(first).ok();`: regions are lost without a word.
pub(crate) fn too_many_regions_are_refused() {
    let thresholds = Thresholds::Global(Threshold { darkest: 0, brightest: 255 });
    let mut found = Regions::new();
    for (count, first) in (250..=260).flat_map(|count| [(count, 0), (count, 1)]) {
        for twice in 0..count {
            let mut line: Vec<u8> = (0..count).map(|i| if (i + first) % 2 == 0 { 0 } else { 255 }).collect();
            line.insert(twice, line[twice]);
            let outcome = regions(&line, &thresholds, &mut found);
            let fits = count <= 255;
            assert_eq!(outcome, if fits { Ok(()) } else { Err(LineRefusal::TooManyRegions) }, "{count} {twice}");
            assert_eq!(usize::from(found.len()), if fits { count } else { 0 }, "{count} {twice}");
        }
    }
}

/// A transition lies where the straight line between its pixels meets the threshold, to the nearest unit, halves up.
///
/// - Domain: all thresholds with a darkest value of 0 or 1, all pairs of a black and a white pixel, ROIs of 15 and of
///   32 pixels.
/// - Fault: `crossing.rs`: `let share = ((e0 << (self.subpixel_bits + 1)) + e0 + e1)` →
///   `let share = ((e0 << (self.subpixel_bits + 1)) + e0)`: halves are rounded otherwise.
pub(crate) fn transitions_lie_where_the_threshold_is_met() {
    let mut found = Regions::new();
    for threshold in (0..=255).flat_map(|brightest| [0, 1].map(|darkest| Threshold { darkest, brightest })) {
        if threshold.range() < 24 || threshold.brightest == 0 {
            continue;
        }
        let thresholds = Thresholds::Global(threshold);
        let values = || (threshold.darkest..=threshold.brightest).filter(|&value| threshold.is_distinct(value));
        for black in values().filter(|&value| threshold.is_black(value)) {
            for white in values().filter(|&value| !threshold.is_black(value)) {
                let line = [black, white];
                regions(&line, &thresholds, &mut found).expect("two regions");
                let scan = Scan { line: &line, thresholds, regions: &found };
                for last_pixel in [14, 31] {
                    let roi = Hypothesis { first_region: 0, last_region: 0, first_pixel: 0, last_pixel };
                    let grid = Grid::new(&roi).expect("it is narrow");
                    let unit = 1_i32 << grid.subpixel_bits();
                    let twice = i32::from(threshold.twice());
                    let (e0, e1) = (twice - 2 * i32::from(black), 2 * i32::from(white) - twice);
                    let share = (2 * unit * e0 + e0 + e1).div_euclid(2 * (e0 + e1));
                    let expected = share - unit * i32::from(last_pixel) / 2;
                    let column = grid.transition(CrossingRule::Interpolated, &scan, 1).map(i32::from);
                    assert_eq!(column, Some(expected).filter(|column| column.abs() <= 2048), "{threshold:?} {line:?}");
                }
            }
        }
    }
}

/// Every black region is in exactly one ROI, and every ROI begins and ends with a black one.
///
/// - Domain: all lines of 16 black and white pixels, both formats.
/// - Fault: `hypotheses.rs`: `            self.taken.insert(region);\n` → ` `: what an ROI grows by is not taken.
pub(crate) fn rois_share_no_region() {
    let thresholds = Thresholds::Global(Threshold { darkest: 0, brightest: 255 });
    let (mut found, mut taken) = (Regions::new(), Taken::new());
    for pixels in 0..=u16::MAX {
        let line: [u8; 16] = std::array::from_fn(|i| if pixels >> i & 1 == 1 { 0 } else { 255 });
        regions(&line, &thresholds, &mut found).expect("at most 16 regions");
        for format in [Format::Paper, Format::Wide] {
            let mut count = [0; 16];
            for roi in hypotheses(&found, format, &mut taken).take(9) {
                assert!(roi.first_region <= roi.last_region && roi.last_region < found.len(), "{line:?}");
                assert_eq!(found.first(roi.first_region), Some(roi.first_pixel), "{line:?}");
                assert_eq!(found.last(roi.last_region), Some(roi.last_pixel), "{line:?}");
                assert_eq!(found.colour(roi.last_region), Colour::Black, "{line:?}");
                for region in (roi.first_region..=roi.last_region).step_by(2) {
                    assert_eq!(found.colour(region), Colour::Black, "{line:?}");
                    count[usize::from(region)] += 1;
                }
            }
            for region in 0..found.len() {
                let black = i32::from(found.colour(region) == Colour::Black);
                assert_eq!(count[usize::from(region)], black, "{line:?} {region}");
            }
        }
    }
}

/// Any ROI can be asked whether it may be decoded, and what may be has as many bars, pixels and stripes as HYPO-6,
/// HYPO-7, HYPO-8 and HYPO-11 say.
///
/// - Domain: ROIs of all 2^16 pairs of regions and of pixels 0 to 41, also where there are none, over a line of 40 pixels
///   with six bars, both formats.
/// - Fault: `hypotheses.rs`: `if 4 * hypothesis.extent() < 5 * u32::from(format.stripes())` →
///   `if 4 * hypothesis.extent() < 4 * u32::from(format.stripes())`: a pixel a stripe.
pub(crate) fn any_roi_can_be_checked() {
    // Six bars, of 4 pixels and the last of 6, with 2 pixels between them and beside them.
    let line: [u8; 40] =
        std::array::from_fn(|pixel| if !(2..=37).contains(&pixel) || pixel < 32 && pixel % 6 < 2 { 255 } else { 0 });
    let mut found = Regions::new();
    regions(&line, &Thresholds::Global(Threshold { darkest: 0, brightest: 255 }), &mut found)
        .expect("thirteen regions");
    let mut may_be_decoded = 0;
    for (first_pixel, last_pixel) in (0..=41).flat_map(|first| (0..=41).map(move |last| (first, last))) {
        for (first_region, last_region) in (0..=255).flat_map(|first| (0..=255).map(move |last| (first, last))) {
            let hypothesis = Hypothesis { first_region, last_region, first_pixel, last_pixel };
            for (format, stripes) in [(Format::Paper, 20), (Format::Wide, 24)] {
                if check(&hypothesis, &found, format).is_ok() {
                    may_be_decoded += 1;
                    assert!((4..=stripes / 2).contains(&hypothesis.bars()), "{hypothesis:?}");
                    assert!(4 * hypothesis.extent() >= 5 * u32::from(stripes), "{hypothesis:?}");
                    assert!(first_pixel > 0 && last_pixel < 39, "{hypothesis:?}");
                }
            }
        }
    }
    assert!(may_be_decoded > 0);
}

/// The sums of a homography take every edge of a layer once, a column within ±2048, and nothing else.
///
/// - Domain: all transitions by themselves; after one of them, all edges again, the columns at the limits.
/// - Fault: `homography.rs`: `        self.edges |= edge;\n` → ` `: an edge may come twice.
pub(crate) fn transitions_come_once() {
    let fits = |edge: i8, column: i16| edge.unsigned_abs() <= 12 && column.unsigned_abs() <= 2048;
    for edge in i8::MIN..=i8::MAX {
        for column in i16::MIN..=i16::MAX {
            let mut normal = Normal::new();
            let added = normal.add(&Crossing { edge, column }).is_some();
            assert_eq!(added, fits(edge, column), "{edge} {column}");
            assert!(added || normal == Normal::new(), "{edge} {column}");
        }
        let mut one = Normal::new();
        let known = one.add(&Crossing { edge, column: 1 }).is_some();
        for other in i8::MIN..=i8::MAX {
            for column in [i16::MIN, -2049, -2048, 0, 2048, 2049, i16::MAX] {
                let mut both = one;
                let added = both.add(&Crossing { edge: other, column }).is_some();
                assert_eq!(added, fits(other, column) && !(known && edge == other), "{edge} {other} {column}");
                assert!(added || both == one, "{edge} {other} {column}");
            }
        }
    }
}
