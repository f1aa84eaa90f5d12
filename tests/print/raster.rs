//! Rasters of printed pages, by pdftoppm (poppler) and resvg, and measurements on them.

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree};
use std::ffi::OsStr;
use std::fs;
use std::path::Path;
use std::process::Command;

/// A part of a page: how black it is, pixel by pixel.
pub(crate) struct Raster {
    /// From 0 for white to 1 for black, row by row.
    ink: Vec<f32>,
    width: usize,
    height: usize,
    per_mm: f64,
    /// The first pixel's column and row on the page.
    origin: [f64; 2],
}

/// A raster of a file with so many dots per inch, of the part of the page from x, y (mm) with the given width and height.
pub(crate) type Rasterise = fn(&Path, f64, [f64; 4]) -> Raster;

/// Runs one of poppler's programs and returns what it prints.
fn poppler(program: &str, arguments: &[&OsStr]) -> Vec<u8> {
    let output = Command::new(program).args(arguments).output().unwrap_or_else(|error| {
        panic!("this test needs {program} of poppler ({error}): install it with `apt-get install poppler-utils`")
    });
    assert!(output.status.success(), "{program}: {}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

/// Columns and rows of a window: the first and how many.
fn window(per_mm: f64, [x, y, width, height]: [f64; 4]) -> [u32; 4] {
    [x * per_mm, y * per_mm, width * per_mm, height * per_mm].map(|pixels| pixels.round() as u32)
}

pub(crate) fn pdf(path: &Path, dpi: f64, area: [f64; 4]) -> Raster {
    let per_mm = dpi / 25.4;
    let [x, y, width, height] = window(per_mm, area);
    let numbers = [dpi.to_string(), x.to_string(), y.to_string(), width.to_string(), height.to_string()];
    let options = ["-r", "-x", "-y", "-W", "-H"];
    let mut arguments: Vec<&OsStr> = vec![OsStr::new("-gray"), OsStr::new("-singlefile")];
    for (option, number) in options.iter().zip(&numbers) {
        arguments.extend([OsStr::new(option), OsStr::new(number)]);
    }
    arguments.push(path.as_os_str());
    let grey = image::load_from_memory(&poppler("pdftoppm", &arguments)).unwrap().into_luma8();
    Raster {
        width: grey.width() as usize,
        height: grey.height() as usize,
        ink: grey.into_raw().iter().map(|&level| 1.0 - f32::from(level) / 255.0).collect(),
        per_mm,
        origin: [f64::from(x), f64::from(y)],
    }
}

pub(crate) fn svg(path: &Path, dpi: f64, area: [f64; 4]) -> Raster {
    let per_mm = dpi / 25.4;
    let [x, y, width, height] = window(per_mm, area);
    let options = Options { dpi: 96.0, ..Options::default() };
    let tree = Tree::from_data(&fs::read(path).unwrap(), &options).unwrap();
    let mut pixels = Pixmap::new(width, height).unwrap();
    let scale = (dpi / 96.0) as f32;
    resvg::render(&tree, Transform::from_row(scale, 0.0, 0.0, scale, -(x as f32), -(y as f32)), &mut pixels.as_mut());
    Raster {
        ink: pixels.pixels().iter().map(|pixel| 1.0 - f32::from(pixel.green()) / 255.0).collect(),
        width: width as usize,
        height: height as usize,
        per_mm,
        origin: [f64::from(x), f64::from(y)],
    }
}

/// The words of a PDF and their boxes by pdftotext: left, top, right, bottom in millimetres.
pub(crate) fn words(path: &Path) -> Vec<(String, [f64; 4])> {
    let text = poppler("pdftotext", &[OsStr::new("-bbox"), path.as_os_str(), OsStr::new("-")]);
    let text = String::from_utf8(text).unwrap();
    let word = |line: &str| {
        let (attributes, rest) = line.trim().strip_prefix("<word ")?.split_once('>')?;
        let numbers: Vec<f64> =
            attributes.split('"').skip(1).step_by(2).map(|number| number.parse().unwrap()).collect();
        let word = rest.strip_suffix("</word>")?.replace("&apos;", "'").replace("&#39;", "'");
        Some((word, [0, 1, 2, 3].map(|i| numbers[i] * 25.4 / 72.0)))
    };
    text.lines().filter_map(word).collect()
}

/// A rectangle on a page, millimetres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Area {
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
}

impl Area {
    pub(crate) fn centre(&self) -> [f64; 2] {
        [f64::midpoint(self.left, self.right), f64::midpoint(self.top, self.bottom)]
    }

    /// Left and right, top and bottom.
    pub(crate) fn sides(&self) -> [[f64; 2]; 2] {
        [[self.left, self.right], [self.top, self.bottom]]
    }

    /// x, y, width and height with so many millimetres more on each side.
    pub(crate) fn grown(&self, by: f64) -> [f64; 4] {
        [self.left - by, self.top - by, self.right - self.left + 2.0 * by, self.bottom - self.top + 2.0 * by]
    }
}

/// Where the one barcode of a page is: nothing else is black over more than 40 mm from top to bottom. Each side is that
/// of a guard bar, within a share of a pixel.
pub(crate) fn barcode_box(raster: &Raster) -> Area {
    let long = (40.0 * raster.per_mm) as usize;
    let bars: Vec<_> =
        (0..raster.width).map(|x| (x, raster.longest_run(x))).filter(|(_, run)| run.len() > long).collect();
    let ((first, rows), (last, _)) = (bars[0].clone(), bars[bars.len() - 1].clone());
    let mm = |pixels: usize, axis: usize| (pixels as f64 + raster.origin[axis]) / raster.per_mm;
    let coarse = Area { left: mm(first, 0), top: mm(rows.start, 1), right: mm(last + 1, 0), bottom: mm(rows.end, 1) };
    let inside = [coarse.top + 1.0, coarse.bottom - 1.0];
    let edges = [coarse.left, coarse.right];
    let half = 0.5;
    let [left, right] = [(edges[0], false), (edges[1], true)]
        .map(|(place, black_left)| raster.upright_edge(inside, [place - half, place + half], black_left));
    Area { left, right, ..coarse }
}

impl Raster {
    fn pixel(&self, x: usize, y: usize) -> f64 {
        f64::from(self.ink[y * self.width + x])
    }

    /// The longest run of black rows in a column.
    fn longest_run(&self, x: usize) -> core::ops::Range<usize> {
        let mut longest = 0..0;
        let mut start = 0;
        for y in 0..self.height {
            if self.pixel(x, y) <= 0.5 {
                start = y + 1;
            } else if y + 1 - start > longest.len() {
                longest = start..y + 1;
            }
        }
        longest
    }

    /// Pixels whose middles lie in a span of millimetres along an axis.
    fn span(&self, [from, to]: [f64; 2], axis: usize) -> core::ops::Range<usize> {
        let pixel = |mm: f64| (mm * self.per_mm - self.origin[axis]).round().max(0.0) as usize;
        let end = [self.width, self.height][axis];
        pixel(from).min(end)..pixel(to).min(end)
    }

    /// Ink at a point of the page in millimetres, bilinear between the middles of pixels; white outside.
    pub(crate) fn at(&self, [x, y]: [f64; 2]) -> f64 {
        let [u, v] = [x * self.per_mm - self.origin[0] - 0.5, y * self.per_mm - self.origin[1] - 0.5];
        if u < 0.0 || v < 0.0 || u >= self.width as f64 - 1.0 || v >= self.height as f64 - 1.0 {
            return 0.0;
        }
        let (i, j) = (u as usize, v as usize);
        let (s, t) = (u.fract(), v.fract());
        let row = |j: usize| (1.0 - s) * self.pixel(i, j) + s * self.pixel(i + 1, j);
        (1.0 - t) * row(j) + t * row(j + 1)
    }

    /// x of the edge in a span that is black on one side: by the area of the black, averaged over a band of rows.
    pub(crate) fn upright_edge(&self, band: [f64; 2], span: [f64; 2], black_left: bool) -> f64 {
        let (rows, columns) = (self.span(band, 1), self.span(span, 0));
        let sum: f64 = rows.clone().flat_map(|y| columns.clone().map(move |x| self.pixel(x, y))).sum();
        let black = sum / rows.len() as f64;
        let pixels = if black_left { columns.start as f64 + black } else { columns.end as f64 - black };
        (pixels + self.origin[0]) / self.per_mm
    }

    /// Height of the black in a band of columns, millimetres.
    pub(crate) fn black_height(&self, band: [f64; 2]) -> f64 {
        let columns = self.span(band, 0);
        let sum: f64 = (0..self.height).flat_map(|y| columns.clone().map(move |x| self.pixel(x, y))).sum();
        sum / columns.len() as f64 / self.per_mm
    }

    /// Length of the black in the row that has most of it, millimetres.
    pub(crate) fn longest_row(&self) -> f64 {
        let rows = self.ink.chunks(self.width).map(|row| row.iter().map(|&ink| f64::from(ink)).sum::<f64>());
        rows.fold(0.0, f64::max) / self.per_mm
    }

    /// The least ink of a rectangle.
    pub(crate) fn lightest(&self, x: [f64; 2], y: [f64; 2]) -> f64 {
        self.inks(x, y).fold(1.0, f64::min)
    }

    /// The most ink of a rectangle.
    pub(crate) fn blackest(&self, x: [f64; 2], y: [f64; 2]) -> f64 {
        self.inks(x, y).fold(0.0, f64::max)
    }

    fn inks(&self, x: [f64; 2], y: [f64; 2]) -> impl Iterator<Item = f64> {
        let (columns, rows) = (self.span(x, 0), self.span(y, 1));
        assert!(!columns.is_empty() && !rows.is_empty());
        rows.flat_map(move |y| columns.clone().map(move |x| self.pixel(x, y)))
    }
}
