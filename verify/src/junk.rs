//! Pairs of scan lines that show no landmark: noise, texture, text, clutter, foreign bar codes, other dual-layer marks.
//!
//! Whatever a detector accepts in them is false. A pair is a function of kind, seed and index alone. The things are drawn
//! as ink from 0 (white) to 1 (black), from edges that are blurred and integrated over the pixels (RENDER-1, RENDER-2);
//! light and sensor follow RENDER-4 and RENDER-5 with a contrast, a gradient, a blur and a noise of their own.

mod bars;
mod clutter;
mod edges;
mod layers;
mod noise;
mod sensor;
mod symbols;
mod text;

use crate::scenes::generator;
use edges::Blur;
use reference::camera::Camera;
use reference::landmark::Format;
use sensor::Sensor;

/// Largest width of a camera (CAM-7).
const MAX_WIDTH: usize = 640;

/// Ink of the upper and the lower row; what lies beyond the camera's width is not looked at.
type Ink = [[f32; MAX_WIDTH]; 2];

/// What is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// Independent pixels.
    WhiteNoise,
    /// Noise of first order, another in each row.
    SmoothNoise,
    /// Noise of first order, the same in both rows.
    SmoothNoiseSameRows,
    /// Black and white runs of random widths, others in each row.
    Runs,
    /// The same runs in both rows.
    RunsSameRows,
    /// The same runs in both rows, but for a slant and a little of each edge.
    RunsSlanted,
    /// Bars of whole modules between quiet zones, as wide as a landmark and up to twice that.
    ModuleBars,
    /// EAN-13.
    Ean13,
    /// Code 128 in the character sets B and C.
    Code128,
    /// Interleaved 2 of 5.
    Itf,
    /// One foreign bar code in the upper row and another of the same symbology in the lower one.
    Stacked,
    /// Lines of words; the rows cut different parts of the letters.
    Text,
    /// Tall letters of upright strokes; both rows cut the same line of them.
    Strokes,
    /// Posts and fences.
    Clutter,
    /// Two layers with a landmark's guards and another number of code stripes.
    OtherLength,
    /// Two layers with a landmark's number of stripes and other guards.
    OtherGuards,
    /// A `wide` landmark, for a detector that looks for `paper`.
    WideForPaper,
    /// A `paper` landmark, for a detector that looks for `wide`.
    PaperForWide,
    /// The upper layer of one landmark above the lower layer of another: only the check byte tells it, so that 1 in 256
    /// is accepted by design.
    MixedLayers,
}

impl Kind {
    /// The kinds of which none may be accepted.
    pub const ALL: [Self; 18] = [
        Self::WhiteNoise,
        Self::SmoothNoise,
        Self::SmoothNoiseSameRows,
        Self::Runs,
        Self::RunsSameRows,
        Self::RunsSlanted,
        Self::ModuleBars,
        Self::Ean13,
        Self::Code128,
        Self::Itf,
        Self::Stacked,
        Self::Text,
        Self::Strokes,
        Self::Clutter,
        Self::OtherLength,
        Self::OtherGuards,
        Self::WideForPaper,
        Self::PaperForWide,
    ];

    /// Its name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::WhiteNoise => "white noise",
            Self::SmoothNoise => "smooth noise",
            Self::SmoothNoiseSameRows => "smooth noise, same rows",
            Self::Runs => "runs",
            Self::RunsSameRows => "runs, same rows",
            Self::RunsSlanted => "runs, slanted",
            Self::ModuleBars => "module bars",
            Self::Ean13 => "EAN-13",
            Self::Code128 => "Code 128",
            Self::Itf => "ITF",
            Self::Stacked => "stacked bar codes",
            Self::Text => "text",
            Self::Strokes => "upright strokes",
            Self::Clutter => "posts and fences",
            Self::OtherLength => "other length",
            Self::OtherGuards => "other guards",
            Self::WideForPaper => "wide for paper",
            Self::PaperForWide => "paper for wide",
            Self::MixedLayers => "mixed layers",
        }
    }

    /// The formats in which nothing may be found in it.
    #[must_use]
    pub fn formats(self) -> &'static [Format] {
        match self {
            Self::WideForPaper => &[Format::Paper],
            Self::PaperForWide => &[Format::Wide],
            _ => &Format::ALL,
        }
    }
}

/// The upper and the lower scan line of number `index` of a kind, as wide as the camera, which is one that CAM-7 allows.
#[must_use]
pub fn lines(kind: Kind, seed: u64, index: u64, camera: &Camera) -> [Vec<u8>; 2] {
    // A seed of its own for every kind, and a stream for every index.
    let rng = &mut generator(seed ^ (kind as u64 + 1) << 56, index);
    let sensor = Sensor::draw(rng);
    let blur = Blur::draw(rng);
    let ink = match kind {
        Kind::WhiteNoise => noise::white(rng),
        Kind::SmoothNoise => noise::smooth(false, rng),
        Kind::SmoothNoiseSameRows => noise::smooth(true, rng),
        Kind::Runs => bars::runs(bars::Rows::Own, camera, blur, rng),
        Kind::RunsSameRows => bars::runs(bars::Rows::Same, camera, blur, rng),
        Kind::RunsSlanted => bars::runs(bars::Rows::Slanted, camera, blur, rng),
        Kind::ModuleBars => bars::symbol(&symbols::modules(rng), camera, blur, rng),
        Kind::Ean13 => bars::symbol(&symbols::ean13(rng), camera, blur, rng),
        Kind::Code128 => bars::symbol(&symbols::code128(rng), camera, blur, rng),
        Kind::Itf => bars::symbol(&symbols::itf(rng), camera, blur, rng),
        Kind::Stacked => bars::stacked(&symbols::pair(rng), camera, blur, rng),
        Kind::Text => text::draw(text::Style::Words, camera, blur, rng),
        Kind::Strokes => text::draw(text::Style::Strokes, camera, blur, rng),
        Kind::Clutter => clutter::draw(camera, blur, rng),
        Kind::OtherLength => bars::layers(&layers::other_length(rng), camera, blur, rng),
        Kind::OtherGuards => bars::layers(&layers::other_guards(rng), camera, blur, rng),
        Kind::WideForPaper => bars::layers(&layers::landmark(Format::Wide, rng), camera, blur, rng),
        Kind::PaperForWide => bars::layers(&layers::landmark(Format::Paper, rng), camera, blur, rng),
        Kind::MixedLayers => bars::layers(&layers::mixed(rng), camera, blur, rng),
    };
    sensor.digitise(&ink, camera.width, rng)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;
    use std::collections::BTreeSet;

    const SEED: u64 = 11;

    fn every() -> impl Iterator<Item = Kind> {
        Kind::ALL.into_iter().chain([Kind::MixedLayers])
    }

    #[test]
    fn lines_are_a_function_of_kind_seed_and_index() {
        let camera = Camera::epuck();
        let jobs: Vec<(Kind, u64)> = every().flat_map(|kind| (0..20).map(move |index| (kind, index))).collect();
        let in_order: Vec<_> = jobs.iter().map(|&(kind, index)| lines(kind, SEED, index, &camera)).collect();
        let at_once: Vec<_> = jobs.par_iter().rev().map(|&(kind, index)| lines(kind, SEED, index, &camera)).collect();
        assert!(in_order.iter().eq(at_once.iter().rev()));
        assert_eq!(in_order.iter().collect::<BTreeSet<_>>().len(), jobs.len(), "no pair comes twice");
        assert_ne!(lines(Kind::Text, SEED, 0, &camera), lines(Kind::Text, SEED + 1, 0, &camera));
    }

    #[test]
    fn lines_are_as_wide_as_the_camera() {
        for width in [32, 333, 640] {
            let camera = Camera { width, principal_column: 15.0, ..Camera::epuck() };
            for kind in every() {
                assert!((0..20).all(|index| lines(kind, SEED, index, &camera).iter().all(|line| line.len() == width)));
            }
        }
    }

    #[test]
    fn names_are_not_shared() {
        assert_eq!(every().map(Kind::name).collect::<BTreeSet<_>>().len(), Kind::ALL.len() + 1);
    }

    /// Transitions across the middle of a line's range with a hysteresis of a sixth of it to either side.
    fn edges(line: &[u8]) -> usize {
        let (dark, bright) = (f64::from(*line.iter().min().unwrap()), f64::from(*line.iter().max().unwrap()));
        let level = |&grey: &u8| ((f64::from(grey) - dark) / (bright - dark) * 6.0 - 3.0).trunc();
        let clear: Vec<bool> =
            line.iter().map(level).filter(|level| level.abs() >= 1.0).map(|level| level > 0.0).collect();
        clear.windows(2).filter(|pair| pair[0] != pair[1]).count()
    }

    fn contrast(line: &[u8]) -> u8 {
        line.iter().max().unwrap() - line.iter().min().unwrap()
    }

    /// Share of a kind's pairs that a test holds for.
    fn share(kind: Kind, test: impl Fn(&[Vec<u8>; 2]) -> bool) -> f64 {
        let camera = Camera::epuck();
        (0..500).filter(|&index| test(&lines(kind, SEED, index, &camera))).count() as f64 / 500.0
    }

    /// THRESH-4 asks for 24 grey levels, a landmark for 8 transitions: lines that have neither would show nothing.
    #[test]
    fn lines_have_contrast_and_edges() {
        for kind in every() {
            let contrasty = share(kind, |lines| lines.iter().all(|line| contrast(line) >= 24));
            assert!(contrasty > 0.8, "{kind:?}: {contrasty}");
            let edged = share(kind, |lines| lines.iter().all(|line| edges(line) >= 8));
            assert!(edged > 0.45, "{kind:?}: {edged}");
        }
    }

    /// Correlation of both rows' grey levels.
    fn correlation([upper, lower]: &[Vec<u8>; 2]) -> f64 {
        let centred = |line: &[u8]| {
            let mean = line.iter().map(|&grey| f64::from(grey)).sum::<f64>() / line.len() as f64;
            line.iter().map(|&grey| f64::from(grey) - mean).collect::<Vec<f64>>()
        };
        let (u, l) = (centred(upper), centred(lower));
        let product = |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(a, b)| a * b).sum::<f64>();
        product(&u, &l) / (product(&u, &u) * product(&l, &l)).sqrt()
    }

    /// From one seed both kinds would draw the same upper row.
    #[test]
    fn kinds_have_seeds_of_their_own() {
        let camera = Camera::epuck();
        let upper = |kind, index| lines(kind, SEED, index, &camera)[0].clone();
        let alike = |&index: &u64| correlation(&[upper(Kind::Runs, index), upper(Kind::RunsSameRows, index)]) > 0.7;
        assert_eq!((0..20).find(alike), None);
    }

    #[test]
    fn same_rows_are_alike_and_own_rows_are_not() {
        for kind in [Kind::SmoothNoiseSameRows, Kind::RunsSameRows] {
            assert!(share(kind, |lines| correlation(lines) > 0.85) > 0.95, "{kind:?}");
        }
        // Half of the symbols are slanted; strokes begin and end in different heights.
        for kind in [Kind::Ean13, Kind::Code128, Kind::Itf, Kind::Clutter] {
            assert!(share(kind, |lines| correlation(lines) > 0.85) > 0.3, "{kind:?}");
        }
        let alike = |kind| share(kind, |lines| correlation(lines) > 0.6);
        assert!(alike(Kind::Strokes) > 0.5, "{}", alike(Kind::Strokes));
        assert!(alike(Kind::Text) < 0.25, "{}", alike(Kind::Text));
        for kind in [Kind::WhiteNoise, Kind::SmoothNoise, Kind::Runs, Kind::Text] {
            assert!(share(kind, |lines| correlation(lines) < 0.7) > 0.85, "{kind:?}");
        }
    }
}
