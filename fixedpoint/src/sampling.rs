//! Sampling: the colour of every stripe, from the borders to the centre, with a homography that improves on the way.

use crate::crossing::{Crossing, CrossingRule, Grid, Scan};
use crate::homography::{Normal, Solution};
use crate::hypotheses::Hypothesis;
use crate::landmark::{Format, GUARD_PAIRS};
use crate::observer::Observer;
use crate::refusal::HypothesisRefusal;
use crate::regions::Colour;
use crate::threshold::Thresholding;

/// A stripe that was sampled. Its middle is `numerator / denominator / 2^Q` px from the ROI's middle, exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample {
    /// The stripe, 0 at the left.
    pub stripe: u8,
    /// The region it falls in; none if it is outside the regions that `SAMPLE-5` or `SAMPLE-6` allow.
    pub region: Option<u8>,
    /// Within ±2^60.8.
    pub numerator: i64,
    /// Positive, below 2^49.
    pub denominator: i64,
    /// `Q` (`CROSS-1`).
    pub subpixel_bits: u8,
}

/// How far the residuals of two like transitions are apart at most (`SAMPLE-10`): `numerator / denominator / 2^Q` px,
/// exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Residual {
    /// From 0 to 2^61.8.
    pub numerator: i64,
    /// Positive, below 2^47.3.
    pub denominator: i64,
    /// `Q` (`CROSS-1`).
    pub subpixel_bits: u8,
}

/// The transitions of an ROI, from the left: one place for each edge of the wider format.
type Transitions = [Option<Crossing>; 25];

/// The colours of a layer's stripes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stripes {
    /// Bit `j` stands for stripe `j`.
    black: u32,
}

impl Stripes {
    /// The colour of a stripe, counted from 0 at the left.
    #[must_use]
    pub fn colour(&self, stripe: u8) -> Colour {
        if self.black.checked_shr(u32::from(stripe)).unwrap_or(0) & 1 == 1 { Colour::Black } else { Colour::White }
    }

    fn set(&mut self, stripe: u8, colour: Colour) {
        if colour == Colour::Black {
            self.black |= 1_u32.checked_shl(u32::from(stripe)).unwrap_or(0);
        }
    }
}

/// Samples an ROI that [`crate::hypotheses::check`] accepted: its stripes and its last homography
/// (`HOMOG-2`, `SAMPLE-1` to `SAMPLE-11`).
///
/// Middles are compared with boundaries exactly, so `SAMPLE-4` asks for nothing here.
///
/// # Errors
/// `Implausible` (`HOMOG-3`) for any of the homographies, `Guard`, `Transition` and `Residual` as `SAMPLE` says.
//= reference/SPEC.md#sample
//# - **SAMPLE-1** Stripes MUST be sampled from the borders to the centre, alternating, the left one first: 0, N-1, 1,
//# N-2, and so on.
pub fn sample<O: Observer>(
    scan: &Scan<'_>,
    hypothesis: &Hypothesis,
    format: Format,
    rule: CrossingRule,
    observer: &mut O,
) -> Result<(Stripes, Solution), HypothesisRefusal> {
    let grid = Grid::new(hypothesis).ok_or(HypothesisRefusal::Transition)?;
    let normal = Normal::new();
    let solution = normal.solve();
    let transitions = [None; 25];
    let mut sampler = Sampler { scan, hypothesis, format, rule, grid, normal, transitions, solution, observer };
    sampler.add_guards()?;
    let mut stripes = Stripes::default();
    let (mut left, mut right) = (hypothesis.first_region, hypothesis.last_region);
    for place in 0..format.stripes() / 2 {
        left = sampler.sample(Side::Left, place, left, &mut stripes)?;
        right = sampler.sample(Side::Right, place, right, &mut stripes)?;
    }
    sampler.join(left, right)?;
    sampler.check_residuals()?;
    Ok((stripes, sampler.solution))
}

/// The side of the ROI from which stripes are counted.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Left,
    Right,
}

struct Sampler<'a, O> {
    scan: &'a Scan<'a>,
    hypothesis: &'a Hypothesis,
    format: Format,
    rule: CrossingRule,
    grid: Grid,
    normal: Normal,
    transitions: Transitions,
    solution: Solution,
    observer: &'a mut O,
}

impl<O: Observer> Sampler<'_, O> {
    /// The first homography, from the transitions of both guards (`HOMOG-2`).
    //= reference/SPEC.md#homog
    //# - **HOMOG-2** The first homography of an ROI MUST be that of the `4 N_guard` transitions of its guards: from the
    //# left end the edges `j = 0 .. 2 N_guard - 1`, from the right end `j = N .. N - 2 N_guard + 1`, each with the next
    //# transition inwards.
    fn add_guards(&mut self) -> Result<(), HypothesisRefusal> {
        let Hypothesis { first_region, last_region, .. } = *self.hypothesis;
        for place in 0..2 * GUARD_PAIRS {
            self.add(place, first_region.checked_add(place))?;
        }
        for place in 0..2 * GUARD_PAIRS {
            // The right end of a region is the left end of the next.
            let region = last_region.checked_sub(place).and_then(|region| region.checked_add(1));
            self.add(self.format.stripes() - place, region)?;
        }
        self.solve()
    }

    /// Samples the stripe `place` places from a side's end and returns its region (`SAMPLE-2`).
    ///
    /// `current` is the region of the stripe sampled before it on its side.
    //= reference/SPEC.md#sample
    //# - **SAMPLE-5** A guard stripe `j` from either end that does not fall in the region `j` places from that end of
    //# the ROI MUST be refused (`Guard`).
    //= reference/SPEC.md#sample
    //# - **SAMPLE-6** A code stripe that does not fall in the region of the stripe sampled before it on its side, or in
    //# the next region inwards within the ROI, MUST be refused (`Transition`).
    fn sample(&mut self, side: Side, place: u8, current: u8, stripes: &mut Stripes) -> Result<u8, HypothesisRefusal> {
        let guard = place < 2 * GUARD_PAIRS;
        let stripe = match side {
            Side::Left => place,
            Side::Right => self.format.stripes() - 1 - place,
        };
        let (allowed, refusal) = if guard && place == 0 {
            ([Some(current), None], HypothesisRefusal::Guard)
        } else if guard {
            ([self.inwards(side, current), None], HypothesisRefusal::Guard)
        } else {
            ([Some(current), self.inwards(side, current)], HypothesisRefusal::Transition)
        };
        let region = self.locate(stripe, allowed).ok_or(refusal)?;
        stripes.set(stripe, self.scan.regions.colour(region));
        if !guard && region != current {
            //= reference/SPEC.md#sample
            //# - **SAMPLE-7** Where a code stripe falls in the next region inwards, the transition between both MUST be
            //# added to the homography as the edge between both stripes, and the homography be solved again before the
            //# next stripe.
            // SAMPLE-7: the edge and the region at the right of the transition.
            match side {
                Side::Left => self.add(stripe, Some(region))?,
                Side::Right => self.add(stripe + 1, Some(current))?,
            }
            self.solve()?;
        }
        Ok(region)
    }

    /// The next region inwards, as far as there are any in the ROI.
    fn inwards(&self, side: Side, region: u8) -> Option<u8> {
        match side {
            Side::Left => region.checked_add(1).filter(|&next| next <= self.hypothesis.last_region),
            Side::Right => region.checked_sub(1).filter(|&next| next >= self.hypothesis.first_region),
        }
    }

    /// Which of the allowed regions contains the middle of a stripe; reports the sample.
    //= reference/SPEC.md#sample
    //# - **SAMPLE-2** A stripe MUST have the colour of the region that contains the projection of its middle `t = (2 j
    //# + 1)/N - 1` by the homography at that time.
    fn locate(&mut self, stripe: u8, allowed: [Option<u8>; 2]) -> Option<u8> {
        let (numerator, denominator) = self.solution.middle(stripe, self.format);
        let region =
            allowed.into_iter().flatten().find(|&region| self.contains(region, numerator, denominator) == Some(true));
        let subpixel_bits = self.grid.subpixel_bits();
        self.observer.sample(&Sample { stripe, region, numerator, denominator, subpixel_bits });
        region
    }

    /// Whether a region contains a column, its left boundary included and its right one not (`SAMPLE-3`).
    ///
    /// Boundaries are within ±2^11 and the denominator below 2^49, so the products are below 2^60.
    //= reference/SPEC.md#sample
    //# - **SAMPLE-3** A region MUST contain the columns from `first - 1/2` inclusive to `last + 1/2` exclusive, so that
    //# a middle that falls on a boundary belongs to the pixel at its right.
    //= reference/SPEC.md#sample
    //# - **SAMPLE-4** A pipeline whose arithmetic is not exact MUST treat a middle within its declared error of a
    //# boundary as on it.
    fn contains(&self, region: u8, numerator: i64, denominator: i64) -> Option<bool> {
        let left = self.grid.left_boundary(self.scan.regions.first(region)?)?;
        let right = self.grid.left_boundary(self.scan.regions.last(region)?.checked_add(1)?)?;
        Some(numerator >= i64::from(left) * denominator && numerator < i64::from(right) * denominator)
    }

    /// Joins both sides in the middle (`SAMPLE-8`, `SAMPLE-9`).
    //= reference/SPEC.md#sample
    //# - **SAMPLE-8** When all stripes are sampled, the left and the right side's last regions MUST be the same or
    //# neighbours, with the left one at the left, or else the ROI be refused (`Transition`).
    //= reference/SPEC.md#sample
    //# - **SAMPLE-9** Where SAMPLE-8 finds neighbours, the transition between both MUST be added as the middle edge `j
    //# = N/2`, and the homography be solved again.
    fn join(&mut self, left: u8, right: u8) -> Result<(), HypothesisRefusal> {
        match right.checked_sub(left) {
            Some(0) => Ok(()),
            Some(1) => {
                self.add(self.format.stripes() / 2, Some(right))?;
                self.solve()
            }
            _ => Err(HypothesisRefusal::Transition),
        }
    }

    /// Adds the transition at the left end of a region as the edge `j`.
    ///
    /// There is such a transition, on the grid, for every region of an ROI that is not cut off, and the one after it.
    fn add(&mut self, edge: u8, region: Option<u8>) -> Result<(), HypothesisRefusal> {
        let crossing = region.and_then(|region| {
            let column = self.grid.transition(self.rule, self.scan, region)?;
            let edge = edge.checked_signed_diff(self.format.stripes() / 2)?;
            Some(Crossing { edge, column })
        });
        let crossing = crossing.ok_or(HypothesisRefusal::Transition)?;
        self.normal.add(&crossing).ok_or(HypothesisRefusal::Transition)?;
        if let Some(place) = self.transitions.get_mut(usize::from(edge)) {
            *place = Some(crossing);
        }
        self.observer.crossing(&crossing);
        Ok(())
    }

    /// Refuses an ROI whose transitions do not lie where the format has edges (`SAMPLE-10`). Exact, so that
    /// `SAMPLE-11` asks for nothing here.
    //= reference/SPEC.md#sample
    //# - **SAMPLE-10** With `ρ = a + s t - k t z - z` the residual of a transition in HOMOG-1 by the last homography,
    //# an ROI MUST be refused (`Residual`) if two of its transitions that have one transition between them differ in ρ
    //# by more than `e/64` px, to which the whole-pixel rule adds 1 px and the local threshold 1 px.
    //= reference/SPEC.md#sample
    //# - **SAMPLE-11** A pipeline whose arithmetic is not exact MUST treat a difference of SAMPLE-10 within its
    //# declared error of the limit as on it.
    fn check_residuals(&mut self) -> Result<(), HypothesisRefusal> {
        let mut largest = 0;
        let mut before = [None; 2];
        for crossing in self.transitions.iter().flatten() {
            let residual = self.solution.residual(crossing);
            if let Some(like) = before[0] {
                largest = largest.max(i64::abs(residual - like));
            }
            before = [before[1], Some(residual)];
        }
        let (denominator, subpixel_bits) = (self.solution.denominator(), self.grid.subpixel_bits());
        self.observer.residual(&Residual { numerator: largest, denominator, subpixel_bits });
        // e 2^Q is at most 2^12, so the product is below 2^59.3. Rounding down does not change a comparison of integers.
        let unit = 1_i64 << subpixel_bits;
        let extent = (i64::from(self.hypothesis.extent()) * unit * denominator) >> 6;
        let by_rule = i64::from(self.rule == CrossingRule::WholePixel);
        let by_light = i64::from(self.scan.thresholds.thresholding() == Thresholding::Local);
        let slack = (by_rule + by_light) * unit * denominator;
        if largest > extent + slack { Err(HypothesisRefusal::Residual) } else { Ok(()) }
    }

    /// Solves the homography again (`HOMOG-1`, `HOMOG-3`).
    fn solve(&mut self) -> Result<(), HypothesisRefusal> {
        self.solution = self.normal.solve();
        if self.solution.is_plausible(self.format) { Ok(()) } else { Err(HypothesisRefusal::Implausible) }
    }
}

#[cfg(test)]
mod tests;
