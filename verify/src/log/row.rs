//! A row's fields, and numbers from them (LOG-3, LOG-4, LOG-7, LOG-9, LOG-10).

use super::fault::{Reason, Refusal};
use super::lines::LONGEST;
use super::time::{Time, TimeRefusal};
use csv_core::{ReadRecordResult, Reader, ReaderBuilder, Terminator};

/// Most fields of a row that are told apart: three times those of the widest table.
const MOST_FIELDS: usize = 39;

/// How much of a field a message shows, characters.
const SHOWN: usize = 40;

/// Takes lines apart; its memory is used again for every line.
pub(super) struct Splitter {
    reader: Reader,
    /// One more than a line, so that a full one is not taken for too much.
    text: Box<[u8; LONGEST + 1]>,
    ends: [usize; MOST_FIELDS],
    starts: usize,
}

impl Splitter {
    pub(super) fn new() -> Self {
        let reader = ReaderBuilder::new().terminator(Terminator::Any(b'\n')).build();
        Self { reader, text: Box::new([0; LONGEST + 1]), ends: [0; MOST_FIELDS], starts: 0 }
    }

    /// The fields of a line without its end.
    pub(super) fn split(&mut self, line: &[u8]) -> Result<Fields<'_>, Refusal> {
        // The parser takes a mark at its input's begin away, which only a file's first line may have.
        self.reader.reset();
        let (result, _, written, count) = self.reader.read_record(line, &mut self.text[..], &mut self.ends);
        self.starts = written;
        let (result, more) = match result {
            ReadRecordResult::InputEmpty => {
                let (result, _, _, more) =
                    self.reader.read_record(b"\n", &mut self.text[written..], &mut self.ends[count..]);
                (result, more)
            }
            other => (other, 0),
        };
        match result {
            ReadRecordResult::Record => {}
            ReadRecordResult::InputEmpty => return Err(Refusal::new(Reason::Line, "a quote is not closed")),
            _ => return Err(Refusal::new(Reason::Fields, format!("has more than {MOST_FIELDS} fields"))),
        }
        let text = core::str::from_utf8(&self.text[..self.starts])
            .map_err(|_| Refusal::new(Reason::Line, "is not UTF-8 text"))?;
        Ok(Fields { text, ends: &self.ends[..count + more] })
    }
}

/// A line's fields, quotes and surrounding blanks taken away.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fields<'a> {
    text: &'a str,
    ends: &'a [usize],
}

impl<'a> Fields<'a> {
    pub(super) fn len(&self) -> usize {
        self.ends.len()
    }

    /// The fields in order.
    pub(super) fn iter(self) -> impl Iterator<Item = &'a str> {
        let begins = core::iter::once(0).chain(self.ends.iter().copied());
        begins.zip(self.ends).map(move |(begin, &end)| self.text.get(begin..end).unwrap_or_default().trim())
    }

    fn get(self, column: usize) -> &'a str {
        self.iter().nth(column).unwrap_or_default()
    }
}

/// The fields of a table's row under their names.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row<'a> {
    columns: &'static [&'static str],
    fields: Fields<'a>,
}

impl<'a> Row<'a> {
    /// As many fields as the table has columns (LOG-10).
    pub(super) fn new(columns: &'static [&'static str], fields: Fields<'a>) -> Result<Self, Refusal> {
        let (found, expected) = (fields.len(), columns.len());
        if found == expected {
            return Ok(Self { columns, fields });
        }
        let which = if found < expected { "too few" } else { "too many" };
        Err(Refusal::new(Reason::Fields, format!("{which} fields: {found} where {expected} are expected")))
    }

    /// A field as it stands.
    pub(super) fn text(&self, column: usize) -> &'a str {
        self.fields.get(column)
    }

    /// What is wrong with a field.
    pub(super) fn refusal(&self, column: usize, reason: Reason, why: &str) -> Refusal {
        let field = self.text(column);
        let shown: String = field.chars().take(SHOWN).collect();
        let more = if shown.len() < field.len() { "..." } else { "" };
        Refusal::new(reason, format!("{}: {shown:?}{more} {why}", self.columns[column]))
    }

    /// A time (LOG-3).
    pub(super) fn time(&self, column: usize) -> Result<Time, Refusal> {
        self.text(column).parse().map_err(|refusal: TimeRefusal| {
            let reason = match refusal {
                TimeRefusal::NotANumber => Reason::NotANumber,
                TimeRefusal::NotFinite => Reason::NotFinite,
                TimeRefusal::Negative | TimeRefusal::TooLarge => Reason::Time,
            };
            self.refusal(column, reason, &refusal.to_string())
        })
    }

    /// A finite number (LOG-7).
    fn finite(&self, column: usize) -> Result<f64, Refusal> {
        match self.text(column).parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            Ok(_) => Err(self.refusal(column, Reason::NotFinite, "is not a finite number")),
            Err(_) => Err(self.refusal(column, Reason::NotANumber, "is not a number")),
        }
    }

    /// A number of at most `most` in absolute value (LOG-4, LOG-6, LOG-7).
    //= reference/SPEC.md#log
    //# - **LOG-7** Coordinates beyond ±100 m, angles beyond ±10^6 rad and numbers that are not finite MUST be refused.
    pub(super) fn number(&self, column: usize, most: f64) -> Result<f64, Refusal> {
        let value = self.finite(column)?;
        if value.abs() <= most {
            return Ok(value);
        }
        Err(self.refusal(column, Reason::OutOfRange, &format!("is beyond ±{most}")))
    }

    /// Steps of a wheel (LOG-4).
    //= reference/SPEC.md#log
    //# - **LOG-4** Steps MUST be whole numbers from -32768 to 32767, and velocities at most 10 m/s and 100 rad/s.
    pub(super) fn steps(&self, column: usize) -> Result<i16, Refusal> {
        if let Ok(steps) = self.text(column).parse() {
            return Ok(steps);
        }
        // `12.0` is a whole number as well.
        let value = self.finite(column)?;
        #[expect(clippy::float_cmp, reason = "whole numbers are their own truncation")]
        let whole = value.trunc() == value;
        if !whole {
            return Err(self.refusal(column, Reason::Steps, "is not a whole number of steps"));
        }
        let range = f64::from(i16::MIN)..=f64::from(i16::MAX);
        if !range.contains(&value) {
            return Err(self.refusal(column, Reason::Steps, "is more steps than a reading holds, -32768 to 32767"));
        }
        #[expect(clippy::cast_possible_truncation, reason = "in range and whole")]
        Ok(value as i16)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COLUMNS: &[&str] = &["t_s", "steps", "name"];

    fn split(line: &str) -> Result<Vec<String>, Reason> {
        let mut splitter = Splitter::new();
        let fields = splitter.split(line.as_bytes()).map_err(|refusal| refusal.reason)?;
        Ok(fields.iter().map(str::to_owned).collect())
    }

    #[test]
    fn fields_are_told_apart() {
        assert_eq!(split("1,2,a").unwrap(), ["1", "2", "a"]);
        assert_eq!(split(" 1 ,\t2,").unwrap(), ["1", "2", ""]);
        assert_eq!(split("\"1\",\"a, b\",\"say \"\"c\"\"\"").unwrap(), ["1", "a, b", "say \"c\""]);
        assert_eq!(split(",,").unwrap(), ["", "", ""]);
        assert_eq!(split("1\r2,3").unwrap(), ["1\r2", "3"]);
    }

    #[test]
    fn broken_lines_are_refused_and_the_next_is_read() {
        let mut splitter = Splitter::new();
        for (line, reason) in
            [(&b"1,\"2,3"[..], Reason::Line), (b"1,\xFF,3", Reason::Line), (&[b','; 5000][..], Reason::Fields)]
        {
            assert_eq!(splitter.split(line).unwrap_err().reason, reason);
            let fields: Vec<&str> = splitter.split(b"1,2,3").unwrap().iter().collect();
            assert_eq!(fields, ["1", "2", "3"]);
        }
        // Exactly as many as are told apart, and one more; and a line as long as can be.
        assert_eq!(splitter.split(&[b','; MOST_FIELDS - 1]).unwrap().len(), MOST_FIELDS);
        assert!(splitter.split(&[b','; MOST_FIELDS]).is_err());
        assert_eq!(splitter.split(&[b'x'; LONGEST]).unwrap().get(0).len(), LONGEST);
    }

    fn steps(text: &str) -> Result<i16, Reason> {
        let mut splitter = Splitter::new();
        let line = format!("0.1,{text},c");
        let row = Row::new(COLUMNS, splitter.split(line.as_bytes()).unwrap()).unwrap();
        row.steps(1).map_err(|refusal| {
            assert!(refusal.what.starts_with(&format!("steps: {text:?} is ")), "{}", refusal.what);
            refusal.reason
        })
    }

    #[test]
    fn steps_are_whole_and_fit() {
        for (text, expected) in [("0", 0), ("-7", -7), ("+7", 7), ("12.0", 12), ("1e2", 100), ("-0.0", 0)] {
            assert_eq!(steps(text), Ok(expected), "{text}");
        }
        assert_eq!((steps("32767"), steps("-32768")), (Ok(i16::MAX), Ok(i16::MIN)));
        for (text, expected) in [
            ("32768", Reason::Steps),
            ("-32769", Reason::Steps),
            ("1e300", Reason::Steps),
            ("0.5", Reason::Steps),
            ("inf", Reason::NotFinite),
            ("NaN", Reason::NotFinite),
            ("1e999", Reason::NotFinite),
            ("ten", Reason::NotANumber),
            ("", Reason::NotANumber),
        ] {
            assert_eq!(steps(text), Err(expected), "{text}");
        }
    }

    #[test]
    fn a_message_shows_no_more_than_the_begin_of_a_field() {
        let mut splitter = Splitter::new();
        let line = format!("0.1,{},c", "é".repeat(500));
        let row = Row::new(COLUMNS, splitter.split(line.as_bytes()).unwrap()).unwrap();
        let what = row.steps(1).unwrap_err().what;
        assert!(what.chars().count() < 80 && what.contains("\"... is not a number"), "{what}");
    }
}
