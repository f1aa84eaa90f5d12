//! Pages as one PDF document, 72/25.4 of its units to a millimetre (PRINT-1), text in the reader's own Helvetica.

use super::page::{Page, Point};
use pdf_writer::{Content, Finish, Name, Pdf, Rect, Ref, Str};

const CATALOG: i32 = 1;
const PAGES: i32 = 2;
const FONT: i32 = 3;
/// A page and its contents from here on.
const FIRST_PAGE: i32 = 4;
const FONT_NAME: Name<'_> = Name(b"F1");

/// Pages of a document at most: the numbers of its objects end there.
pub const MOST_PAGES: usize = 1_000_000;

/// The pages, up to [`MOST_PAGES`] of them, as a PDF document; the same pages give the same bytes (PRINT-14).
//= reference/SPEC.md#print
//# - **PRINT-14** The same request MUST give the same bytes.
#[must_use]
pub fn write(pages: &[Page]) -> Vec<u8> {
    let mut pdf = Pdf::new();
    let numbers: Vec<i32> = (0..).map(|page| FIRST_PAGE + 2 * page).take(pages.len().min(MOST_PAGES)).collect();
    pdf.catalog(Ref::new(CATALOG)).pages(Ref::new(PAGES));
    let count = i32::try_from(numbers.len()).unwrap_or(i32::MAX);
    pdf.pages(Ref::new(PAGES)).kids(numbers.iter().map(|&number| Ref::new(number))).count(count);
    let mut font = pdf.type1_font(Ref::new(FONT));
    font.base_font(Name(b"Helvetica")).encoding_predefined(Name(b"WinAnsiEncoding"));
    font.finish();
    for (page, &number) in pages.iter().zip(&numbers) {
        let [right, top] = [units(page.size[0]), units(page.size[1])];
        let mut object = pdf.page(Ref::new(number));
        object.media_box(Rect::new(0.0, 0.0, right, top)).parent(Ref::new(PAGES)).contents(Ref::new(number + 1));
        object.resources().fonts().pair(FONT_NAME, Ref::new(FONT));
        object.finish();
        pdf.stream(Ref::new(number + 1), contents(page).finish().as_slice());
    }
    pdf.finish()
}

fn contents(page: &Page) -> Content {
    let mut content = Content::new();
    // PDF counts y from below.
    let place = |[x, y]: Point| [units(x), units(page.size[1] - y)];
    for shape in &page.shapes {
        for outline in shape {
            for (i, &point) in outline.iter().enumerate() {
                let [x, y] = place(point);
                if i == 0 {
                    content.move_to(x, y)
                } else {
                    content.line_to(x, y)
                };
            }
            content.close_path();
        }
        content.fill_nonzero();
    }
    for text in &page.texts {
        let [x, y] = place(text.place);
        content.begin_text().set_font(FONT_NAME, units(text.size)).set_text_matrix([1.0, 0.0, 0.0, 1.0, x, y]);
        content.show(Str(&encoded(&text.words))).end_text();
    }
    content
}

/// Millimetres in PDF's units. A page's coordinates in f32 are off by less than 0.01 µm.
//= reference/SPEC.md#print
//# - **PRINT-1** A millimetre of a landmark MUST be a millimetre of paper: 72/25.4 units of a PDF page, one user unit
//# of an SVG page whose width and height are in millimetres.
#[expect(clippy::cast_possible_truncation, reason = "what the format's reals hold")]
fn units(millimetres: f64) -> f32 {
    (millimetres * 72.0 / 25.4) as f32
}

/// Windows-1252, which is Unicode below U+0080 and from U+00A0 to U+00FF; a question mark for anything else.
fn encoded(words: &str) -> Vec<u8> {
    words
        .chars()
        .map(|letter| match u8::try_from(u32::from(letter)) {
            Ok(byte) if !(0x80..0xA0).contains(&byte) => byte,
            _ => b'?',
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_windows_1252() {
        assert_eq!(encoded("90°"), [b'9', b'0', 0xB0]);
        assert_eq!(encoded("\u{85}θ"), *b"??");
    }

    /// A4 is 595.28 x 841.89 units.
    //= reference/SPEC.md#print
    //= type=test
    //# - **PRINT-1** A millimetre of a landmark MUST be a millimetre of paper: 72/25.4 units of a PDF page, one user
    //# unit of an SVG page whose width and height are in millimetres.
    #[test]
    fn a_millimetre_is_a_millimetre() {
        assert!((units(210.0) - 595.275_6).abs() < 1e-3 && (units(297.0) - 841.889_8).abs() < 1e-3);
        assert!((units(25.4) - 72.0).abs() < 1e-6);
    }
}
