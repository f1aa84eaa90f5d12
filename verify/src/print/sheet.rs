//! Lists of landmarks to print: CSV with the columns `x_m`, `y_m` and `theta_deg`, or with the column `id`.

use core::fmt;
use csv::{ByteRecord, ReaderBuilder, Trim};
use std::fs;
use std::io;
use std::path::Path;

/// Columns of a list of poses.
pub const POSE_COLUMNS: [&str; 3] = ["x_m", "y_m", "theta_deg"];

/// Column of a list of identifiers.
pub const ID_COLUMN: &str = "id";

/// What one landmark is to say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wish {
    /// x and y in metres, the heading in degrees; all finite.
    Pose([f64; 3]),
    /// A number that stands for itself.
    Id(u64),
}

/// A line of the list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Its number in the file, from 1.
    pub line: u64,
    /// What it asks for.
    pub wish: Wish,
}

/// What is wrong with a list.
#[derive(Debug)]
pub enum SheetError {
    /// It cannot be read.
    Unreadable(io::Error),
    /// Its first line does not name the columns.
    Header,
    /// Nothing follows its header.
    Empty,
    /// It has a line that is no CSV, or no text.
    Line(u64, &'static str),
    /// A field: the line, the column, and what it must be.
    Field(u64, String, String),
}

impl fmt::Display for SheetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable(error) => write!(f, "cannot be read: {error}"),
            Self::Header => f.write_str("line 1: the first line must name the columns: x_m,y_m,theta_deg or id"),
            Self::Empty => f.write_str("line 2: no landmark follows the header"),
            Self::Line(line, what) => write!(f, "line {line}: {what}"),
            Self::Field(line, column, what) => write!(f, "line {line}, column {column}: {what}"),
        }
    }
}

impl core::error::Error for SheetError {}

/// The entries of a file, at least one.
pub fn load(path: &Path) -> Result<Vec<Entry>, SheetError> {
    entries(&fs::read(path).map_err(SheetError::Unreadable)?)
}

/// The entries of a list, at least one; empty lines are passed over.
pub fn entries(bytes: &[u8]) -> Result<Vec<Entry>, SheetError> {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let mut reader = ReaderBuilder::new().flexible(true).trim(Trim::All).from_reader(bytes);
    let headers = reader.headers().map_err(|_| SheetError::Header)?;
    let columns: Vec<String> = headers.iter().map(str::to_owned).collect();
    let place = |name: &str| columns.iter().position(|column| column == name);
    let wanted: Vec<(&str, usize)> = match POSE_COLUMNS.map(place) {
        [Some(x), Some(y), Some(theta)] if columns.len() == 3 => POSE_COLUMNS.into_iter().zip([x, y, theta]).collect(),
        _ if columns == [ID_COLUMN] => vec![(ID_COLUMN, 0)],
        _ => return Err(SheetError::Header),
    };
    let mut found = Vec::new();
    for record in reader.byte_records() {
        let record = record.map_err(|error| SheetError::Line(line_of(bytes, error.position()), "is no CSV"))?;
        found.push(entry(&record, line_of(bytes, record.position()), &wanted)?);
    }
    if found.is_empty() { Err(SheetError::Empty) } else { Ok(found) }
}

/// The line of a record. The reader's position is where it began to look, before the empty lines that it passed over.
fn line_of(bytes: &[u8], position: Option<&csv::Position>) -> u64 {
    let Some(position) = position else { return 0 };
    let rest = usize::try_from(position.byte()).ok().and_then(|start| bytes.get(start..)).unwrap_or_default();
    let passed = rest.iter().take_while(|byte| matches!(byte, b'\r' | b'\n')).filter(|&&byte| byte == b'\n');
    position.line() + passed.count() as u64
}

fn entry(record: &ByteRecord, line: u64, wanted: &[(&str, usize)]) -> Result<Entry, SheetError> {
    let wrong = |column: &str, what: String| SheetError::Field(line, column.to_owned(), what);
    if record.len() > wanted.len() {
        return Err(wrong(&(wanted.len() + 1).to_string(), "the header names no such column".to_owned()));
    }
    let field = |&(column, place): &(&str, usize)| {
        let bytes = record.get(place).ok_or_else(|| wrong(column, "is missing".to_owned()))?;
        core::str::from_utf8(bytes).map_err(|_| wrong(column, "is no text".to_owned()))
    };
    let wish = if let [only] = wanted {
        let id = parse_id(field(only)?).map_err(|what| wrong(only.0, what))?;
        Wish::Id(id)
    } else {
        let mut pose = [0.0; 3];
        for (value, column) in pose.iter_mut().zip(wanted) {
            *value = parse_number(field(column)?).map_err(|what| wrong(column.0, what))?;
        }
        Wish::Pose(pose)
    };
    Ok(Entry { line, wish })
}

/// A finite number.
pub fn parse_number(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| format!("{text:?} is not a finite number"))
}

/// A whole number, decimal or hexadecimal after 0x.
pub fn parse_id(text: &str) -> Result<u64, String> {
    let trimmed = text.trim();
    let digits = trimmed.strip_prefix("0x").or_else(|| trimmed.strip_prefix("0X"));
    let id = match digits {
        // `from_str_radix` would take a sign.
        Some(digits) if digits.starts_with(['+', '-']) => None,
        Some(digits) => u64::from_str_radix(digits, 16).ok(),
        None => trimmed.parse().ok(),
    };
    id.ok_or_else(|| format!("{text:?} is not a whole number from 0 to 2^64 - 1, decimal or hexadecimal after 0x"))
}

/// x, y and heading with commas between them.
pub fn parse_pose(text: &str) -> Result<[f64; 3], String> {
    let numbers: Vec<f64> = text.split(',').map(parse_number).collect::<Result<_, _>>()?;
    <[f64; 3]>::try_from(numbers).map_err(|numbers| format!("{} numbers instead of three, X,Y,DEG", numbers.len()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn error(text: &str) -> String {
        entries(text.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn poses_and_ids_are_read_with_their_lines() {
        let pose = |line, pose| Entry { line, wish: Wish::Pose(pose) };
        let poses = entries(b"x_m,y_m,theta_deg\n0.15, 0.25,90\n\n1e-1,0,-22.5\n").unwrap();
        assert_eq!(poses, [pose(2, [0.15, 0.25, 90.0]), pose(4, [0.1, 0.0, -22.5])]);
        // In any order, with a byte order mark, with Windows' line ends.
        let poses = entries(b"\xEF\xBB\xBFtheta_deg,x_m,y_m\r\n90,1,2\r\n").unwrap();
        assert_eq!(poses, [pose(2, [1.0, 2.0, 90.0])]);
        let ids: Vec<Wish> = entries(b"id\n7\n0xCC0d\n").unwrap().iter().map(|entry| entry.wish).collect();
        assert_eq!(ids, [Wish::Id(7), Wish::Id(0xcc0d)]);
    }

    #[test]
    fn what_is_wrong_is_named_with_line_and_column() {
        for text in ["", "\n", "0.1,0.2,90\n", "x_m,y_m\n1,2\n", "x_m,y_m,theta_deg,id\n1,2,3,4\n"] {
            assert!(error(text).starts_with("line 1: "), "{text:?}: {}", error(text));
        }
        assert!(error("id\n").starts_with("line 2: no landmark"));
        let header = "x_m,y_m,theta_deg\n0,0,0\n";
        assert!(error(&format!("{header}0,abc,0\n")).starts_with("line 3, column y_m: \"abc\" is not"));
        assert!(error(&format!("{header}0,0,nan\n")).starts_with("line 3, column theta_deg: "));
        assert!(error(&format!("{header}0,0\n")).starts_with("line 3, column theta_deg: is missing"));
        assert!(error(&format!("{header}0,0,0,0\n")).starts_with("line 3, column 4: "));
        assert!(error("id\r\n\r\n1\r\n\r\n\r\nx\r\n").starts_with("line 6, column id: "));
        assert!(error("\n\nid\n1\nx\n").starts_with("line 5, column id: "));
        assert!(error("id\n1\n-1\n").starts_with("line 3, column id: \"-1\""));
        assert!(error("id\n0x+1\n").starts_with("line 2, column id: "));
    }

    proptest! {
        #[test]
        fn no_bytes_make_it_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let list = [b"id\n", &bytes[..]].concat();
            let poses = [b"x_m,y_m,theta_deg\n", &bytes[..]].concat();
            for bytes in [&bytes, &list, &poses] {
                if let Err(error) = entries(bytes) {
                    prop_assert_eq!(error.to_string().lines().count(), 1);
                }
            }
        }
    }
}
