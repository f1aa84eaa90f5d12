//! Sampling of an ROI from the borders to the centre, improving the homography on the way (SAMPLE).

use crate::crossing::{Crossing, CrossingRule, crossing, subpixel_bits};
use crate::homography::{Fit, Homography, coordinate};
use crate::hypotheses::Hypothesis;
use crate::landmark::{Format, GUARD_PAIRS};
use crate::observer::Observer;
use crate::refusal::HypothesisRefusal;
use crate::regions::{Colour, Region};
use crate::threshold::{Thresholded, Thresholding};

/// Declared error of the float64 arithmetic up to a stripe's middle, pixels, and up to `k` (SAMPLE-4).
///
/// The normal matrix is summed from at most 25 rows of entries within ±1 and factored, with a backward error below 30 u
/// times its trace, at most 75, u = 2^-53. Its smallest eigenvalue is at least that of the guards alone, which is 0.13 in a
/// frontal view and 0.039 for the worst columns that grow from the left guard to the right one. So the solution is good to
/// 2250 u/0.039 = 6.4e-12 of half the ROI's extent, at most 320 px, and a column, a sum of three such terms over
/// 1 + k t >= 1/2, to 1.3e-8 px. `verify` compares every middle with the port's, which is exact.
pub const DECLARED_ERROR: f64 = 1.0 / (1 << 26) as f64;

/// One sampled stripe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The stripe, counted from the left.
    pub stripe: usize,
    /// The region that contains its middle, `None` if that is not one of those which SAMPLE-5 and SAMPLE-6 allow.
    pub region: Option<usize>,
    /// Column of its middle relative to the ROI's middle, pixels.
    pub middle: f64,
    /// Distance from the nearest boundary that decides about `region`, pixels.
    pub margin: f64,
}

/// How well the transitions of an ROI lie where the format has edges (SAMPLE-10).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual {
    /// Largest difference between two like transitions, pixels.
    pub difference: f64,
    /// What is allowed, pixels.
    pub limit: f64,
}

/// A scan line with what is known about it, and the ROI to be sampled.
#[derive(Clone, Copy, Debug)]
pub struct Roi<'a> {
    /// Grey values and threshold.
    pub line: &'a Thresholded<'a>,
    /// Its regions by that threshold.
    pub regions: &'a [Region],
    /// The ROI among them.
    pub hypothesis: &'a Hypothesis,
    /// What the global threshold decoded in this line and format, if the ROI is one of the local threshold (HYPO-12).
    pub decoded_before: &'a [Hypothesis],
    /// The format that is looked for.
    pub format: Format,
    /// Where transitions lie.
    pub rule: CrossingRule,
}

/// A side of the barcode from which stripes are sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Left,
    Right,
}

impl Roi<'_> {
    /// The edge number `v` of the left edge of stripe `j`.
    fn edge(&self, j: usize) -> i32 {
        // At most 24 stripes.
        i32::try_from(j).unwrap_or(i32::MAX) - i32::try_from(self.format.stripes() / 2).unwrap_or(i32::MAX)
    }

    /// The transition from `region` to the next one on its right, as the edge left of stripe `j`.
    fn transition(&self, region: usize, j: usize) -> Crossing {
        let column = crossing(self.line, self.rule, self.hypothesis, self.regions[region].last);
        Crossing { edge: self.edge(j), column }
    }

    /// HOMOG-2: guard transitions, outermost first, left before right.
    //= reference/SPEC.md#homog
    //# - **HOMOG-2** The first homography of an ROI MUST be that of the `4 N_guard` transitions of its guards: from the
    //# left end the edges `j = 0 .. 2 N_guard - 1`, from the right end `j = N .. N - 2 N_guard + 1`, each with the next
    //# transition inwards.
    fn guard_transitions(&self) -> impl Iterator<Item = Crossing> {
        let (first, last) = (self.hypothesis.first_region, self.hypothesis.last_region);
        (0..2 * GUARD_PAIRS).flat_map(move |g| {
            [self.transition(first - 1 + g, g), self.transition(last - g, self.format.stripes() - g)]
        })
    }

    /// Distance of `middle` from the left and from the right boundary of a region, positive inside (SAMPLE-3).
    //= reference/SPEC.md#sample
    //# - **SAMPLE-3** A region MUST contain the columns from `first - 1/2` inclusive to `last + 1/2` exclusive, so that
    //# a middle that falls on a boundary belongs to the pixel at its right.
    fn inside(&self, region: usize, middle: f64) -> (f64, f64) {
        let column = self.hypothesis.middle() + middle;
        let region = &self.regions[region];
        (column - (region.first as f64 - 0.5), region.last as f64 + 0.5 - column)
    }

    /// The one of `allowed` that contains stripe `j` (SAMPLE-2 to SAMPLE-4).
    //= reference/SPEC.md#sample
    //# - **SAMPLE-2** A stripe MUST have the colour of the region that contains the projection of its middle `t = (2 j
    //# + 1)/N - 1` by the homography at that time.
    //= reference/SPEC.md#sample
    //# - **SAMPLE-4** A pipeline whose arithmetic is not exact MUST treat a middle within its declared error of a
    //# boundary as on it.
    fn sample(&self, homography: &Homography, j: usize, allowed: &[usize]) -> Sample {
        let n = self.format.stripes() as f64;
        let middle = homography.column((2 * j + 1) as f64 / n - 1.0);
        let contains = |&region: &usize| {
            let (left, right) = self.inside(region, middle);
            left >= -DECLARED_ERROR && right > DECLARED_ERROR
        };
        let margin = allowed
            .iter()
            .map(|&region| self.inside(region, middle))
            .fold(f64::INFINITY, |margin, (left, right)| margin.min(left.abs()).min(right.abs()));
        Sample { stripe: j, region: allowed.iter().copied().find(contains), middle, margin }
    }

    /// The regions in which stripe `j`, the `depth`-th of its side, may fall, given the region of the one before it.
    //= reference/SPEC.md#sample
    //# - **SAMPLE-6** A code stripe that does not fall in the region of the stripe sampled before it on its side, or in
    //# the next region inwards within the ROI, MUST be refused (`Transition`).
    fn allowed(&self, side: Side, depth: usize, before: usize) -> Vec<usize> {
        let (first, last) = (self.hypothesis.first_region, self.hypothesis.last_region);
        match (side, depth < 2 * GUARD_PAIRS) {
            (Side::Left, true) => vec![first + depth],
            (Side::Right, true) => vec![last - depth],
            (Side::Left, false) if before < last => vec![before, before + 1],
            (Side::Right, false) if before > first => vec![before, before - 1],
            (_, false) => vec![before],
        }
    }
}

/// What sampling found: the colours from left to right, and the homography relative to the ROI's middle.
#[derive(Clone, Debug, PartialEq)]
pub struct Stripes {
    /// N colours.
    pub colours: Vec<Colour>,
    /// The homography after the last transition.
    pub homography: Homography,
}

/// The transitions so far and their homography.
struct Improving<'o, O> {
    fit: Fit,
    crossings: Vec<Crossing>,
    homography: Homography,
    observer: &'o mut O,
}

impl<'o, O: Observer> Improving<'o, O> {
    fn new(roi: &Roi<'_>, observer: &'o mut O) -> Result<Self, HypothesisRefusal> {
        let mut fit = Fit::new(roi.format, roi.hypothesis.extent(), subpixel_bits(roi.hypothesis));
        let crossings: Vec<Crossing> = roi.guard_transitions().collect();
        for crossing in &crossings {
            observer.crossing(crossing);
            fit.add(crossing);
        }
        let homography = plausible(&fit, observer)?;
        Ok(Self { fit, crossings, homography, observer })
    }

    fn improve(&mut self, crossing: &Crossing) -> Result<(), HypothesisRefusal> {
        self.observer.crossing(crossing);
        self.fit.add(crossing);
        self.crossings.push(*crossing);
        self.homography = plausible(&self.fit, self.observer)?;
        Ok(())
    }

    /// SAMPLE-10, SAMPLE-11
    //= reference/SPEC.md#sample
    //# - **SAMPLE-10** With `ρ = a + s t - k t z - z` the residual of a transition in HOMOG-1 by the last homography,
    //# an ROI MUST be refused (`Residual`) if two of its transitions that have one transition between them differ in ρ
    //# by more than `e/64` px, to which the whole-pixel rule adds 1 px and the local threshold 1 px.
    //= reference/SPEC.md#sample
    //# - **SAMPLE-11** A pipeline whose arithmetic is not exact MUST treat a difference of SAMPLE-10 within its
    //# declared error of the limit as on it.
    fn check_residuals(&mut self, roi: &Roi<'_>) -> Result<(), HypothesisRefusal> {
        let unit = f64::from(1 << subpixel_bits(roi.hypothesis));
        self.crossings.sort_unstable_by_key(|crossing| crossing.edge);
        let residual = |crossing: &Crossing| {
            self.homography.residual(coordinate(roi.format, crossing.edge), f64::from(crossing.column) / unit)
        };
        let differences = self.crossings.windows(3).map(|three| (residual(&three[0]) - residual(&three[2])).abs());
        let slack = [roi.rule == CrossingRule::WholePixel, roi.line.thresholding() == Thresholding::Local]
            .map(|adds| if adds { 1.0 } else { 0.0 });
        let found = Residual {
            difference: differences.fold(0.0, f64::max),
            limit: roi.hypothesis.extent() as f64 / 64.0 + slack[0] + slack[1],
        };
        self.observer.residual(&found);
        if found.difference > found.limit + DECLARED_ERROR { Err(HypothesisRefusal::Residual) } else { Ok(()) }
    }
}

/// HOMOG-3
fn plausible<O: Observer>(fit: &Fit, observer: &mut O) -> Result<Homography, HypothesisRefusal> {
    let homography = fit.solve().ok_or(HypothesisRefusal::Implausible)?;
    observer.homography(&homography);
    if homography.is_plausible(DECLARED_ERROR) { Ok(homography) } else { Err(HypothesisRefusal::Implausible) }
}

/// Samples all stripes of an ROI that passed its checks (SAMPLE-1 to SAMPLE-11).
pub fn sample<O: Observer>(roi: &Roi<'_>, observer: &mut O) -> Result<Stripes, HypothesisRefusal> {
    let n = roi.format.stripes();
    let mut improving = Improving::new(roi, observer)?;
    let mut colours = vec![Colour::White; n];
    let (mut left, mut right) = (roi.hypothesis.first_region, roi.hypothesis.last_region);
    //= reference/SPEC.md#sample
    //# - **SAMPLE-1** Stripes MUST be sampled from the borders to the centre, alternating, the left one first: 0, N-1,
    //# 1, N-2, and so on.
    for depth in 0..n / 2 {
        for side in [Side::Left, Side::Right] {
            let (j, before) = match side {
                Side::Left => (depth, &mut left),
                Side::Right => (n - 1 - depth, &mut right),
            };
            let sampled = roi.sample(&improving.homography, j, &roi.allowed(side, depth, *before));
            improving.observer.sample(&sampled);
            //= reference/SPEC.md#sample
            //# - **SAMPLE-5** A guard stripe `j` from either end that does not fall in the region `j` places from that
            //# end of the ROI MUST be refused (`Guard`).
            let in_guard = depth < 2 * GUARD_PAIRS;
            let refusal = if in_guard { HypothesisRefusal::Guard } else { HypothesisRefusal::Transition };
            let region = sampled.region.ok_or(refusal)?;
            colours[j] = roi.regions[region].colour;
            let entered = if region == *before || in_guard { None } else { Some(*before) };
            *before = region;
            //= reference/SPEC.md#sample
            //# - **SAMPLE-7** Where a code stripe falls in the next region inwards, the transition between both MUST be
            //# added to the homography as the edge between both stripes, and the homography be solved again before the
            //# next stripe.
            match (entered, side) {
                (None, _) => {}
                (Some(from), Side::Left) => improving.improve(&roi.transition(from, j))?,
                (Some(_), Side::Right) => improving.improve(&roi.transition(region, j + 1))?,
            }
        }
    }
    //= reference/SPEC.md#sample
    //# - **SAMPLE-8** When all stripes are sampled, the left and the right side's last regions MUST be the same or
    //# neighbours, with the left one at the left, or else the ROI be refused (`Transition`).
    //= reference/SPEC.md#sample
    //# - **SAMPLE-9** Where SAMPLE-8 finds neighbours, the transition between both MUST be added as the middle edge `j
    //# = N/2`, and the homography be solved again.
    if left + 1 == right {
        improving.improve(&roi.transition(left, n / 2))?;
    } else if left != right {
        return Err(HypothesisRefusal::Transition);
    }
    improving.check_residuals(roi)?;
    Ok(Stripes { colours, homography: improving.homography })
}
