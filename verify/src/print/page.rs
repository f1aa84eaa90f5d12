//! A page as plain data: what is black on it and what is written, in millimetres from the upper left corner, x to the
//! right and y down (PRINT-1).

/// A point of a page: x and y in millimetres.
pub type Point = [f64; 2];

/// A closed polygon, its first point not repeated.
pub type Outline = Vec<Point>;

/// A line of text.
#[derive(Clone, Debug, PartialEq)]
pub struct Text {
    /// Left end of its baseline.
    pub place: Point,
    /// Font size, millimetres.
    pub size: f64,
    /// Characters of Windows-1252.
    pub words: String,
}

/// One sheet of paper.
#[derive(Clone, Debug, PartialEq)]
pub struct Page {
    /// Width and height, millimetres.
    pub size: [f64; 2],
    /// Black areas; the outlines of one shape are filled together and touch each other at most in points (PRINT-4).
    pub shapes: Vec<Vec<Outline>>,
    /// Everything that is written.
    pub texts: Vec<Text>,
    /// Where the landmarks are: the middle of each barcode, in the order in which they were asked for.
    pub centres: Vec<Point>,
}

/// A width, in millimetres, that a line of text does not exceed in any usual sans serif font: 0.65 of its size for each
/// character (digits have 0.556 in Helvetica and 0.636 in `DejaVu Sans`).
#[must_use]
pub fn text_width(words: &str, size: f64) -> f64 {
    0.65 * size * words.chars().count() as f64
}

/// A number with up to `digits` decimals, without zeros that say nothing.
#[must_use]
pub fn short(number: f64, digits: usize) -> String {
    let written = format!("{number:.digits$}");
    let trimmed = if digits > 0 { written.trim_end_matches('0').trim_end_matches('.') } else { &written };
    if trimmed == "-0" { "0".to_owned() } else { trimmed.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_plain() {
        let written = [0.0, -0.000_01, 100.0, 1.5, 0.123_44, 210.0, -3.25].map(|number| short(number, 4));
        assert_eq!(written, ["0", "0", "100", "1.5", "0.1234", "210", "-3.25"]);
        assert_eq!((short(100.0, 0), short(-0.2, 0)), ("100".to_owned(), "0".to_owned()));
    }
}
