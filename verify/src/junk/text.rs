//! Lines of text in an 8 x 8 font. Every row of the camera integrates over the part of the letters that it covers.

use super::Ink;
use super::edges::{Blur, Edges};
use font8x8::legacy::BASIC_LEGACY;
use rand::{Rng, RngExt};
use reference::camera::Camera;

/// Letters about as often as in English.
const LETTERS: &[u8] =
    b"eeeeeeeeeeeetttttttttaaaaaaaaoooooooiiiiiiinnnnnnnsssssshhhhhhrrrrrrddddllllcccuuummwwffggyyppbbvkxjqz";

/// Letters of which most is upright, and blanks.
const STROKES: &[u8] = b"llII||1iHHNMUtfr  ";

/// Font pixels from line to line: letters of 8 and a gap of 2.
const PITCH: usize = 10;

/// Font pixels of a letter's width and height.
const LETTER: usize = 8;

/// What is written.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Style {
    /// Words; letters as high as wide, in half of the pairs up to six times as high.
    Words,
    /// Strokes, as high as it takes for both rows to cut the same line.
    Strokes,
}

/// A page of text, whose lines are written when they are looked at.
struct Page {
    style: Style,
    /// Letters per line.
    letters: usize,
    /// Lines by number.
    lines: Vec<(usize, Vec<u8>)>,
}

impl Page {
    fn line<R: Rng>(&mut self, number: usize, rng: &mut R) -> &[u8] {
        if let Some(known) = self.lines.iter().position(|line| line.0 == number) {
            return &self.lines[known].1;
        }
        let text = match self.style {
            Style::Words => words(self.letters, rng),
            Style::Strokes => (0..self.letters).map(|_| STROKES[rng.random_range(0..STROKES.len())]).collect(),
        };
        self.lines.push((number, text));
        &self.lines[self.lines.len() - 1].1
    }

    /// The share of ink in each font column between two heights, in font pixels from the page's top.
    fn columns<R: Rng>(&mut self, top: f32, bottom: f32, rng: &mut R) -> Vec<f32> {
        let mut columns = vec![0.0; self.letters * LETTER];
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "heights are not negative")]
        let rows = top as usize..=bottom as usize;
        for row in rows.filter(|row| row % PITCH < LETTER) {
            let share = ((row as f32 + 1.0).min(bottom) - (row as f32).max(top)) / (bottom - top);
            let line = self.line(row / PITCH, rng);
            for (columns, &letter) in columns.chunks_exact_mut(LETTER).zip(line) {
                let bits = BASIC_LEGACY[usize::from(letter)][row % PITCH];
                // The left-most pixel is the least significant bit.
                for (bit, column) in columns.iter_mut().enumerate() {
                    *column += share * f32::from(bits >> bit & 1);
                }
            }
        }
        columns
    }
}

fn words<R: Rng>(letters: usize, rng: &mut R) -> Vec<u8> {
    let mut text = Vec::with_capacity(letters + 16);
    while text.len() < letters {
        let begin = text.len();
        text.extend((0..rng.random_range(1..10)).map(|_| LETTERS[rng.random_range(0..LETTERS.len())]));
        match rng.random_range(0..8) {
            0 => text[begin].make_ascii_uppercase(),
            1 => text.push(b'.'),
            2 => text[begin..].fill_with(|| rng.random_range(b'0'..=b'9')),
            _ => {}
        }
        text.push(b' ');
    }
    text.truncate(letters);
    text
}

/// How large a text is, and where it stands.
struct Layout {
    /// Pixels per font pixel, along the line.
    scale: f32,
    /// Height of a row of the camera, font pixels.
    row_height: f32,
    /// Height at which the upper row begins, font pixels from the page's top.
    top: f32,
}

impl Layout {
    /// Scales are evenly distributed in their logarithm.
    fn draw<R: Rng>(style: Style, camera: &Camera, rng: &mut R) -> Self {
        let scale = 0.8 * 12.0_f32.powf(rng.random());
        let letter = LETTER as f32;
        if style == Style::Strokes {
            let span = rng.random_range(0.1 * letter..0.9 * letter);
            let rows = (camera.lower_row - camera.upper_row + 1) as f32;
            return Self { scale, row_height: span / rows, top: rng.random_range(0.0..=letter - span) };
        }
        let stretch: f32 = if rng.random() { 1.0 } else { rng.random_range(1.0..6.0) };
        #[expect(clippy::cast_possible_truncation, reason = "a ratio of focal lengths")]
        let aspect = (camera.focal_length / camera.focal_length_vertical) as f32;
        Self { scale, row_height: aspect / (scale * stretch), top: rng.random_range(0.0..PITCH as f32) }
    }
}

/// Text of random size at a random place, black on white or, in one of eight pairs, white on black.
pub(super) fn draw<R: Rng>(style: Style, camera: &Camera, blur: Blur, rng: &mut R) -> Ink {
    let Layout { scale, row_height, top } = Layout::draw(style, camera, rng);
    let left = -rng.random_range(0.0..LETTER as f32 * scale);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a line is at most 640 px wide")]
    let letters = (camera.width as f32 / (scale * LETTER as f32)) as usize + 3;
    let mut page = Page { style, letters, lines: Vec::new() };
    let sign = if rng.random_range(0..8) == 0 { -1.0 } else { 1.0 };
    let mut edges = Edges::new(camera.width, blur);
    for (row, below) in [0.0, (camera.lower_row - camera.upper_row) as f32].into_iter().enumerate() {
        let top = top + below * row_height;
        let columns = page.columns(top, top + row_height, rng);
        edges.step(row, -1e3, if sign < 0.0 { 1.0 } else { 0.0 });
        let mut before = 0.0;
        for (place, &ink) in columns.iter().enumerate() {
            if (ink - before).abs() > f32::EPSILON {
                edges.step(row, left + place as f32 * scale, sign * (ink - before));
                before = ink;
            }
        }
    }
    edges.into_ink()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::generator;

    fn page(text: &[u8]) -> Page {
        Page { style: Style::Words, letters: text.len(), lines: vec![(0, text.to_vec())] }
    }

    /// A vertical bar fills its columns at every height, a dash only its own rows, and the gap between lines is white.
    #[test]
    fn a_row_sees_the_share_of_ink_in_its_height() {
        let rng = &mut generator(1, 0);
        let dash = BASIC_LEGACY[usize::from(b'-')];
        let at = dash.iter().position(|&bits| bits != 0).unwrap() as f32;
        let column = dash.iter().find(|&&bits| bits != 0).unwrap().trailing_zeros() as usize;
        let share = |top: f32, bottom: f32, rng: &mut _| page(b"-").columns(top, bottom, rng)[column];
        assert!((share(at, at + 0.5, rng) - 1.0).abs() < 1e-6);
        assert!((share(at - 0.5, at + 0.5, rng) - 0.5).abs() < 1e-6);
        assert!((share(at - 1.0, at + 3.0, rng) - 0.25).abs() < 1e-6);
        assert_eq!(page(b"|").columns(8.0, 10.0, rng), [0.0; 8]);
    }

    #[test]
    fn a_line_is_the_same_whoever_looks_at_it() {
        let rng = &mut generator(1, 0);
        let mut page = Page { style: Style::Words, letters: 40, lines: Vec::new() };
        let first = page.line(3, rng).to_vec();
        assert_ne!(page.line(4, rng), first);
        assert_eq!(page.line(3, rng), first);
        assert_eq!(first.len(), 40);
    }

    /// By eye: `l` has its stroke in the middle, and the font's least significant bit is at the left, as in `L`.
    #[test]
    fn letters_are_not_mirrored() {
        let rng = &mut generator(1, 0);
        let whole = page(b"L").columns(0.0, 8.0, rng);
        let foot = page(b"L").columns(6.0, 7.0, rng);
        let left: f32 = whole[..4].iter().sum();
        let right: f32 = whole[4..].iter().sum();
        assert!(left > 1.5 * right, "{whole:?} {foot:?}");
    }
}
