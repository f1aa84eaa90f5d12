//! A page as SVG, its user unit a millimetre (PRINT-1).

use super::page::{Outline, Page, Text, short};
use core::fmt::Write;

/// The page as an SVG document; the same page gives the same bytes (PRINT-14).
#[must_use]
pub fn write(page: &Page) -> String {
    let [width, height] = page.size.map(number);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}mm\" height=\"{height}mm\" \
         viewBox=\"0 0 {width} {height}\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n"
    );
    for shape in &page.shapes {
        let outlines: Vec<String> = shape.iter().map(path).collect();
        let _ = writeln!(svg, "<path d=\"{}\"/>", outlines.join(" "));
    }
    for text in &page.texts {
        svg.push_str(&line(text));
    }
    svg.push_str("</svg>\n");
    svg
}

/// One outline as path data.
fn path(outline: &Outline) -> String {
    let points: Vec<String> = outline.iter().map(|&[x, y]| format!("{},{}", number(x), number(y))).collect();
    format!("M{}Z", points.join(" "))
}

fn line(text: &Text) -> String {
    let [x, y] = text.place.map(number);
    let words = text.words.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    format!(
        "<text x=\"{x}\" y=\"{y}\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"{}\">{words}</text>\n",
        number(text.size)
    )
}

/// Millimetres to a tenth of a micrometre (PRINT-2), without what would not say anything.
//= reference/SPEC.md#print
//# - **PRINT-2** The edges of stripes and layers and the ends of the scale bar MUST lie within 0.02 mm of their place.
fn number(millimetres: f64) -> String {
    short(millimetres, 4)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_become_markup() {
        let text = Text { place: [1.0, 2.0], size: 3.0, words: "a < b & c".to_owned() };
        assert!(line(&text).ends_with(">a &lt; b &amp; c</text>\n"));
    }
}
