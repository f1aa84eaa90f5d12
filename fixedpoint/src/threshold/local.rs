//! The local threshold: what is bright to the left and to the right of a pixel, and what is dark there.
//!
//! A pixel's windows begin and end with whole blocks of 16 px (`THRESH-5`), so the extremes of the blocks, found once,
//! leave only the pixels of its own block to be looked at. Nothing is kept for each pixel: all of them are met from left
//! to right while the regions are found, and a single one is found again where a transition asks for it.

use super::Threshold;
use crate::camera::MAX_WIDTH;
use crate::refusal::LineRefusal;

/// Pixels of a block.
const BLOCK: usize = 16;

/// Whole blocks of a window, beside the pixel's own (`THRESH-5`).
//= reference/SPEC.md#thresh
//# - **THRESH-5** The left window of pixel `i` MUST be the pixels from `max(0, 16 (b - 8))` to `i`, and its right
//# window those from `i` to `min(Q_x - 1, 16 (b + 8) + 15)`, with `b = floor(i/16)`.
const REACH: usize = 8;

/// Blocks of the longest line.
const MAX_BLOCKS: usize = MAX_WIDTH as usize / BLOCK;

/// The smallest and the largest of some pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Extremes {
    darkest: u8,
    brightest: u8,
}

impl Extremes {
    /// Those of no pixels.
    const NONE: Self = Self { darkest: u8::MAX, brightest: 0 };

    fn and(self, other: Self) -> Self {
        Self { darkest: self.darkest.min(other.darkest), brightest: self.brightest.max(other.brightest) }
    }

    fn and_pixel(self, pixel: u8) -> Self {
        self.and(Self { darkest: pixel, brightest: pixel })
    }

    fn and_pixels(self, pixels: &[u8]) -> Self {
        pixels.iter().copied().fold(self, Self::and_pixel)
    }
}

/// The threshold of a pixel with these windows and neighbours, which the line's ends do not have (`THRESH-6`).
//= reference/SPEC.md#thresh
//# - **THRESH-6** With `high(i)` the smaller of both windows' largest values and `low(i)` the larger of the smallest
//# values of the left window with pixel `i + 1` and of the right window with pixel `i - 1`, as far as the line has
//# them, the local threshold MUST have `T2(i) = high(i) + low(i)` and `R(i) = high(i) - low(i)`.
fn between(left: Extremes, right: Extremes, previous: Option<u8>, next: Option<u8>) -> Threshold {
    let darkest = |window: Extremes, beyond: Option<u8>| window.darkest.min(beyond.unwrap_or(u8::MAX));
    Threshold {
        darkest: darkest(left, next).max(darkest(right, previous)),
        brightest: left.brightest.min(right.brightest),
    }
}

/// The extremes of a line's blocks of 16 px, 80 bytes: what its local threshold is found from.
///
/// The line itself is the caller's, and to be passed again with every question.
#[derive(Clone, Debug)]
pub struct Blocks([Extremes; MAX_BLOCKS]);

impl Blocks {
    /// Those of a line without pixels.
    #[must_use]
    pub const fn new() -> Self {
        Self([Extremes::NONE; MAX_BLOCKS])
    }

    /// Reads a line.
    ///
    /// # Errors
    /// `Width` if it has more than 640 pixels, which no camera's has (`CAM-7`).
    pub fn read(&mut self, line: &[u8]) -> Result<(), LineRefusal> {
        *self = Self::new();
        if line.len() > usize::from(MAX_WIDTH) {
            return Err(LineRefusal::Width);
        }
        for (block, pixels) in self.0.iter_mut().zip(line.chunks(BLOCK)) {
            *block = Extremes::NONE.and_pixels(pixels);
        }
        Ok(())
    }

    /// The threshold of one pixel of the line that was read; `None` outside of it.
    #[must_use]
    pub fn at(&self, line: &[u8], pixel: u16) -> Option<Threshold> {
        let (block, place) = (usize::from(pixel) / BLOCK, usize::from(pixel) % BLOCK);
        let pixels = line.chunks(BLOCK).nth(block)?;
        let left = self.before(block).and_pixels(pixels.get(..=place)?);
        let right = self.after(block).and_pixels(pixels.get(place..)?);
        let next = line.get(usize::from(pixel) + 1).copied();
        Some(between(left, right, before(line, usize::from(pixel)), next))
    }

    /// All pixels of the line that was read and their thresholds, from left to right.
    pub fn thresholds<'a>(&'a self, line: &'a [u8]) -> impl Iterator<Item = (u8, Threshold)> + 'a {
        line.chunks(BLOCK).enumerate().flat_map(|(block, pixels)| self.in_block(block, pixels, line))
    }

    /// A block's pixels and their thresholds: the right windows are found from the right, the left ones on the way.
    fn in_block<'a>(
        &self,
        block: usize,
        pixels: &'a [u8],
        line: &'a [u8],
    ) -> impl Iterator<Item = (u8, Threshold)> + 'a {
        let mut right = self.after(block);
        let mut windows = [Extremes::NONE; BLOCK];
        for (window, &pixel) in windows.iter_mut().zip(pixels).rev() {
            right = right.and_pixel(pixel);
            *window = right;
        }
        let first = block * BLOCK;
        let (mut left, mut previous) = (self.before(block), before(line, first));
        let nexts = line.iter().skip(first + 1).copied().map(Some).chain([None]);
        pixels.iter().zip(windows).zip(nexts).map(move |((&pixel, right), next)| {
            left = left.and_pixel(pixel);
            (pixel, between(left, right, previous.replace(pixel), next))
        })
    }

    /// The extremes of a left window's whole blocks.
    fn before(&self, block: usize) -> Extremes {
        let blocks = self.0.get(block.saturating_sub(REACH)..block).unwrap_or_default();
        blocks.iter().copied().fold(Extremes::NONE, Extremes::and)
    }

    /// The extremes of a right window's whole blocks; beyond the line's end there are none.
    fn after(&self, block: usize) -> Extremes {
        self.0.iter().skip(block + 1).take(REACH).copied().fold(Extremes::NONE, Extremes::and)
    }
}

/// The pixel at the left of one.
fn before(line: &[u8], pixel: usize) -> Option<u8> {
    line.get(pixel.checked_sub(1)?).copied()
}

impl Default for Blocks {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests;
