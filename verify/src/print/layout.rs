//! Landmarks on A4 pages: each with its quiet zone, caption and cut marks, on each page a scale bar and how to mount.

use super::outline::{Column, bars, outlines};
use super::page::{Page, Point, Text, short, text_width};
use crate::certificate::format_name;
use core::fmt;
use reference::codeword::{self, EncodeRefusal};
use reference::landmark::{Format, Landmark, LandmarkRefusal, QUIET_ZONE_STRIPES};

/// A4 upright, millimetres (PRINT-12).
pub const PAPER: [f64; 2] = [210.0, 297.0];

/// White along the page's edges, which no printer needs more of.
const MARGIN: f64 = 10.0;
/// Height of the lines at the page's top.
const HEAD: f64 = 20.0;
/// Height of the scale bar and its words at the page's bottom.
const FOOT: f64 = 10.0;
/// Between neighbouring pieces: both pieces' cut marks.
const GAP: f64 = 9.0;
/// Cut marks: how far from the corner they begin, how long and how thick they are.
const MARK: [f64; 3] = [1.0, 3.0, 0.2];
const HEAD_SIZE: f64 = 3.2;
const HEAD_PITCH: f64 = 5.0;
const CAPTION_SIZE: f64 = 2.4;
const CAPTION_PITCH: f64 = 3.2;
/// White around a caption.
const CAPTION_MARGIN: f64 = 1.5;
/// White between barcode and caption, in stripe heights (PRINT-6).
//= reference/SPEC.md#print
//# - **PRINT-6** A piece's caption MUST stand below the barcode, at least a third of the stripe height away from it.
const CAPTION_CLEARANCE: f64 = 1.0 / 3.0;
/// Lowest layer that can be printed, millimetres.
const LOWEST_LAYER: f64 = 1.0;

/// Length of the scale bar, millimetres (PRINT-7).
pub const SCALE: f64 = 100.0;

/// One landmark to print.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// What it carries.
    pub payload: u32,
    /// Lines below the barcode.
    pub caption: Vec<String>,
}

/// Why landmarks cannot be put on pages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LayoutRefusal {
    /// LAND-7
    Landmark(LandmarkRefusal),
    /// A layer's height that is no number from 1 mm on.
    Height,
    /// A payload without code word (CODE-5, CODE-6).
    Payload(EncodeRefusal),
    /// A piece of this width and height, in millimetres, is larger than what a page has room for (PRINT-12).
    Size([f64; 2]),
}

impl fmt::Display for LayoutRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Landmark(refusal) => refusal.fmt(f),
            Self::Height => f.write_str("the height of a layer must be a number from 1 mm on"),
            Self::Payload(refusal) => refusal.fmt(f),
            Self::Size([width, height]) => {
                let [upright, turned] = [room(PAPER), room(turned())];
                write!(
                    f,
                    "the landmark with quiet zone and caption is {width:.1} x {height:.1} mm, a page has room for \
                     {:.0} x {:.0} mm upright and {:.0} x {:.0} mm turned",
                    upright[0], upright[1], turned[0], turned[1]
                )
            }
        }
    }
}

impl core::error::Error for LayoutRefusal {}

/// A4 on its side.
fn turned() -> [f64; 2] {
    [PAPER[1], PAPER[0]]
}

/// What a page of this size has left for pieces.
fn room([width, height]: [f64; 2]) -> [f64; 2] {
    [width - 2.0 * MARGIN, height - 2.0 * MARGIN - HEAD - FOOT]
}

/// The pages that carry the pieces, in their order; none without pieces. `landmark` gives format and dimensions of all.
//= reference/SPEC.md#print
//# - **PRINT-12** Pages MUST be A4, upright, or on their side where a piece is too large for an upright page, and a
//# piece that is too large for both be refused.
pub fn pages(landmark: &Landmark, pieces: &[Piece]) -> Result<Vec<Page>, LayoutRefusal> {
    let landmark = landmark.checked().map_err(LayoutRefusal::Landmark)?;
    let cut = Cut::new(landmark, pieces);
    // Written so that NaN is refused.
    if !(cut.height >= LOWEST_LAYER && cut.height.is_finite()) {
        return Err(LayoutRefusal::Height);
    }
    let paper = [PAPER, turned()].into_iter().find(|&paper| cut.fits(paper));
    let paper = paper.ok_or(LayoutRefusal::Size(cut.size))?;
    let [columns, rows] = cut.places(paper);
    let count = pieces.len().div_ceil(columns * rows);
    let page = |(i, pieces)| cut.page(paper, pieces, &format!("page {} of {count}", i + 1));
    pieces.chunks(columns * rows).enumerate().map(page).collect()
}

/// Dimensions of a piece of paper that carries one landmark, millimetres.
struct Cut {
    format: Format,
    /// Stripe edges from left to right, 0 in the barcode's middle (LAND-2).
    edges: Vec<f64>,
    /// Height of one layer (LAND-4).
    height: f64,
    /// White beside and above the barcode (LAND-5, PRINT-3).
    //= reference/SPEC.md#print
    //# - **PRINT-3** Inside the cut marks the paper MUST be white for at least 2.5 `X_dim` on either side of the
    //# barcode and above it.
    quiet: f64,
    stripe_width: f64,
    size: [f64; 2],
}

impl Cut {
    fn new(landmark: Landmark, pieces: &[Piece]) -> Self {
        let [stripe_width, height] = [landmark.stripe_width, landmark.stripe_height].map(|metres| 1e3 * metres);
        let quiet = QUIET_ZONE_STRIPES * stripe_width;
        let lines = pieces.iter().map(|piece| piece.caption.len()).max().unwrap_or(0);
        let longest = pieces.iter().flat_map(|piece| &piece.caption).map(|line| text_width(line, CAPTION_SIZE));
        let caption = longest.fold(0.0, f64::max) + 2.0 * CAPTION_MARGIN;
        let barcode = 2e3 * landmark.half_width();
        let below = CAPTION_CLEARANCE * height + CAPTION_PITCH * lines as f64 + CAPTION_MARGIN;
        Self {
            format: landmark.format,
            edges: landmark.edges().iter().rev().map(|b| 1e3 * b).collect(),
            height,
            quiet,
            stripe_width,
            size: [caption.max(barcode + 2.0 * quiet), quiet + 2.0 * height + below],
        }
    }

    fn fits(&self, paper: [f64; 2]) -> bool {
        let room = room(paper);
        self.size[0] <= room[0] && self.size[1] <= room[1]
    }

    /// Columns and rows of pieces on a page, at least one each.
    fn places(&self, paper: [f64; 2]) -> [usize; 2] {
        let room = room(paper);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a page has at most 297 mm")]
        [0, 1].map(|axis| (((room[axis] + GAP) / (self.size[axis] + GAP)) as usize).max(1))
    }

    fn page(&self, paper: [f64; 2], pieces: &[Piece], number: &str) -> Result<Page, LayoutRefusal> {
        let mut page = Page { size: paper, shapes: Vec::new(), texts: Vec::new(), centres: Vec::new() };
        self.head(&mut page, number);
        scale_bar(&mut page);
        let columns = self.places(paper)[0].min(pieces.len()).max(1);
        let block = columns as f64 * (self.size[0] + GAP) - GAP;
        let left = (paper[0] - block) / 2.0;
        for (place, piece) in pieces.iter().enumerate() {
            let [column, row] = [place % columns, place / columns].map(|place| place as f64);
            let corner = [left + column * (self.size[0] + GAP), MARGIN + HEAD + row * (self.size[1] + GAP)];
            self.piece(&mut page, corner, piece)?;
        }
        Ok(page)
    }

    /// What it is, how to print it, and how to mount it (PRINT-7).
    //= reference/SPEC.md#print
    //# - **PRINT-7** Every page MUST have a scale bar of 100 mm and say that the barcode's centre is mounted at the
    //# camera's height.
    fn head(&self, page: &mut Page, number: &str) {
        let lines = [
            format!(
                "barloc: {} landmarks, stripes {} mm wide and {} mm high, {number}",
                format_name(self.format),
                short(self.stripe_width, 4),
                short(self.height, 4)
            ),
            "Print at 100 % (actual size, not fitted to the page); the bar below must be 100 mm long.".to_owned(),
            "Mount upright, the barcode's centre (where its two layers meet) at the camera's height.".to_owned(),
        ];
        for (i, words) in lines.into_iter().enumerate() {
            let place = [MARGIN, MARGIN + HEAD_SIZE + i as f64 * HEAD_PITCH];
            page.texts.push(Text { place, size: HEAD_SIZE, words });
        }
    }

    /// Barcode, caption and cut marks of the piece whose upper left corner is at `corner`.
    fn piece(&self, page: &mut Page, corner: Point, piece: &Piece) -> Result<(), LayoutRefusal> {
        let layers = codeword::layers(self.format, piece.payload).map_err(LayoutRefusal::Payload)?;
        let centre = [corner[0] + self.size[0] / 2.0, corner[1] + self.quiet + self.height];
        let edges: Vec<f64> = self.edges.iter().map(|edge| centre[0] + edge).collect();
        page.shapes.push(outlines(&bars(&edges, &layers, centre[1], self.height)));
        page.centres.push(centre);
        let first = centre[1] + self.height * (1.0 + CAPTION_CLEARANCE) + CAPTION_SIZE;
        for (i, words) in piece.caption.iter().enumerate() {
            let place = [corner[0] + CAPTION_MARGIN, first + i as f64 * CAPTION_PITCH];
            page.texts.push(Text { place, size: CAPTION_SIZE, words: words.clone() });
        }
        page.shapes.push(cut_marks(corner, self.size));
        Ok(())
    }
}

/// Two short lines at each corner, outside of the piece (PRINT-5).
//= reference/SPEC.md#print
//# - **PRINT-5** Every piece MUST have cut marks at its corners that lie outside of it.
fn cut_marks([left, top]: Point, [width, height]: [f64; 2]) -> Vec<Vec<Point>> {
    let [gap, length, thickness] = MARK;
    let mut marks = Vec::new();
    for (x, outwards_x) in [(left, -1.0), (left + width, 1.0)] {
        for (y, outwards_y) in [(top, -1.0), (top + height, 1.0)] {
            marks.push(line([x + outwards_x * gap, y], [x + outwards_x * (gap + length), y], thickness));
            marks.push(line([x, y + outwards_y * gap], [x, y + outwards_y * (gap + length)], thickness));
        }
    }
    marks
}

/// A level or upright line as the rectangle that it fills.
fn line(from: Point, to: Point, thickness: f64) -> Vec<Point> {
    let half = thickness / 2.0;
    let (low, high) = ([from[0].min(to[0]), from[1].min(to[1])], [from[0].max(to[0]), from[1].max(to[1])]);
    let level = high[0] > low[0];
    let [dx, dy] = if level { [0.0, half] } else { [half, 0.0] };
    let (left, right, top, bottom) = (low[0] - dx, high[0] + dx, low[1] - dy, high[1] + dy);
    vec![[left, top], [right, top], [right, bottom], [left, bottom]]
}

/// 100 mm from end to end, in fifths of which every other one is filled (PRINT-7).
fn scale_bar(page: &mut Page) {
    let bottom = page.size[1] - MARGIN;
    let fifth = SCALE / 5.0;
    let columns: Vec<Column> = (0..5)
        .map(|i| Column {
            left: MARGIN + f64::from(i) * fifth,
            right: MARGIN + f64::from(i + 1) * fifth,
            top: bottom - if i % 2 == 0 { 3.0 } else { 0.3 },
            bottom,
        })
        .collect();
    page.shapes.push(outlines(&columns));
    let place = [MARGIN + SCALE + 2.0, bottom];
    page.texts.push(Text { place, size: HEAD_SIZE, words: "100 mm from end to end".to_owned() });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pieces(count: usize) -> Vec<Piece> {
        let caption = ["x 3.15 m, y 3.15 m", "heading 337.5°", "payload cc0d, paper"].map(str::to_owned).to_vec();
        vec![Piece { payload: 0xcc0d, caption }; count]
    }

    fn laid_out(stripe_width: f64, stripe_height: f64) -> Result<Vec<Page>, LayoutRefusal> {
        pages(&Landmark { format: Format::Paper, stripe_width, stripe_height }, &pieces(1))
    }

    #[test]
    fn every_piece_has_its_place() {
        let landmark = Landmark::new(Format::Paper);
        for count in 0..40 {
            let pages = pages(&landmark, &pieces(count)).unwrap();
            assert_eq!(pages.iter().map(|page| page.centres.len()).sum::<usize>(), count);
            for page in &pages {
                for (i, a) in page.centres.iter().enumerate() {
                    // 30 mm of barcode and two quiet zones, 50 mm of barcode.
                    let apart = |b: &Point| (a[0] - b[0]).abs() >= 37.5 || (a[1] - b[1]).abs() >= 50.0;
                    assert!(page.centres[..i].iter().all(apart));
                }
            }
        }
    }

    #[test]
    fn everything_lies_on_the_page() {
        for (format, width, height) in
            [(Format::Paper, 0.5, 1.0), (Format::Wide, 1.5, 25.0), (Format::Paper, 10.0, 40.0)]
        {
            let landmark = Landmark { format, stripe_width: width * 1e-3, stripe_height: height * 1e-3 };
            for page in pages(&landmark, &pieces(30)).unwrap() {
                let inside =
                    |&[x, y]: &Point| (5.0..page.size[0] - 5.0).contains(&x) && (5.0..page.size[1] - 5.0).contains(&y);
                assert!(page.shapes.iter().flatten().flatten().all(inside), "{format:?} {width} {height}");
                let ends =
                    page.texts.iter().map(|text| [text.place[0] + text_width(&text.words, text.size), text.place[1]]);
                assert!(ends.collect::<Vec<_>>().iter().all(inside), "{format:?} {width} {height}");
            }
        }
    }

    //= reference/SPEC.md#print
    //= type=test
    //# - **PRINT-12** Pages MUST be A4, upright, or on their side where a piece is too large for an upright page, and a
    //# piece that is too large for both be refused.
    #[test]
    fn a_wide_landmark_turns_the_page_and_a_wider_one_is_refused() {
        // 20 stripes and 5 of quiet zone: 187.5 mm upright, 250 and 275 mm turned, 300 mm.
        assert!((laid_out(7.5e-3, 25e-3).unwrap()[0].size[0] - 210.0).abs() < 1e-9);
        assert!((laid_out(11e-3, 25e-3).unwrap()[0].size[0] - 297.0).abs() < 1e-9);
        assert!(matches!(laid_out(12e-3, 25e-3), Err(LayoutRefusal::Size([width, _])) if (width - 300.0).abs() < 1e-9));
        assert!(matches!(laid_out(1.5e-3, 0.2), Err(LayoutRefusal::Size(_))));
    }

    #[test]
    fn dimensions_that_are_none_are_refused() {
        assert_eq!(laid_out(0.4e-3, 25e-3), Err(LayoutRefusal::Landmark(LandmarkRefusal::StripeWidth)));
        for height in [0.0, -1.0, 0.9e-3, f64::NAN, f64::INFINITY] {
            assert_eq!(laid_out(1.5e-3, height), Err(LayoutRefusal::Height), "{height}");
        }
    }
}
