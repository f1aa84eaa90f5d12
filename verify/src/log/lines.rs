//! Lines of a text file of any length, one at a time (LOG-9, LOG-10, LOG-13).

use std::io::{self, BufRead, Read};

/// Longest line that is looked at, bytes (LOG-10).
pub(super) const LONGEST: usize = 8192;

/// A file's lines.
pub(super) struct TextLines<R> {
    source: R,
    /// Number of the last line read, counted from 1.
    number: u64,
    text: Vec<u8>,
}

/// What a line is.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Line<'a> {
    /// Ended, without its end.
    Whole(&'a [u8]),
    /// The file ends in it.
    CutOff(&'a [u8]),
    /// Longer than [`LONGEST`].
    TooLong,
}

impl<R: BufRead> TextLines<R> {
    pub(super) fn new(source: R) -> Self {
        Self { source, number: 0, text: Vec::new() }
    }

    /// The next line that is not blank, and its number.
    //= reference/SPEC.md#log
    //# - **LOG-13** The memory that reading takes MUST NOT grow with the number of rows.
    pub(super) fn next(&mut self) -> io::Result<Option<(u64, Line<'_>)>> {
        loop {
            self.text.clear();
            // Two for the line's end.
            let most = LONGEST as u64 + 2;
            if (&mut self.source).take(most).read_until(b'\n', &mut self.text)? == 0 {
                return Ok(None);
            }
            self.number += 1;
            if self.text.len() as u64 == most && !self.text.ends_with(b"\n") {
                self.source.skip_until(b'\n')?;
                return Ok(Some((self.number, Line::TooLong)));
            }
            if !self.content().0.trim_ascii().is_empty() {
                break;
            }
        }
        let (content, ended) = self.content();
        let line = match ended {
            _ if content.len() > LONGEST => Line::TooLong,
            true => Line::Whole(content),
            false => Line::CutOff(content),
        };
        Ok(Some((self.number, line)))
    }

    /// The line without byte order mark and line end, and whether it has an end.
    fn content(&self) -> (&[u8], bool) {
        let text = if self.number == 1 { strip_mark(&self.text) } else { &self.text };
        match text.strip_suffix(b"\n") {
            Some(line) => (line.strip_suffix(b"\r").unwrap_or(line), true),
            None => (text, false),
        }
    }
}

/// Text without the byte order mark of UTF-8.
fn strip_mark(text: &[u8]) -> &[u8] {
    text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(text: &[u8]) -> Vec<(u64, String)> {
        let mut lines = TextLines::new(text);
        let mut found = Vec::new();
        while let Some((number, line)) = lines.next().unwrap() {
            found.push((number, format!("{line:?}").chars().take(12).collect()));
        }
        found
    }

    #[test]
    fn lines_are_numbered_as_an_editor_numbers_them() {
        let found = all(b"\xEF\xBB\xBFa\r\n\n  \r\nb\n\xEF\xBB\xBFc\nd");
        let numbers: Vec<u64> = found.iter().map(|(number, _)| *number).collect();
        assert_eq!(numbers, [1, 4, 5, 6]);
        assert_eq!(found[0].1, "Whole([97])");
        assert!(found[2].1.starts_with("Whole([239"), "a mark is only at the beginning one");
        assert_eq!(found[3].1, "CutOff([100]");
    }

    #[test]
    fn nothing_is_no_line() {
        assert!(all(b"").is_empty() && all(b"\n \n\t").is_empty() && all(b"\xEF\xBB\xBF").is_empty());
    }

    #[test]
    fn a_long_line_is_one_line_and_takes_no_memory() {
        let exact = [vec![b'x'; LONGEST], b"\r\n".to_vec()].concat();
        let long = [vec![b'x'; LONGEST + 1], b"\n".to_vec()].concat();
        let found = all(&[&exact[..], &long, &long[1..], b"y\n"].concat());
        let kinds: Vec<&str> = found.iter().map(|(_, kind)| &kind[..5]).collect();
        assert_eq!(kinds, ["Whole", "TooLo", "Whole", "Whole"]);
        // A hundred megabytes without an end, and a line after it.
        let source = io::BufReader::new(io::repeat(b'x').take(100 << 20).chain(&b"\nz\n"[..]));
        let mut lines = TextLines::new(source);
        assert_eq!(lines.next().unwrap(), Some((1, Line::TooLong)));
        assert_eq!(lines.next().unwrap(), Some((2, Line::Whole(b"z"))));
        assert!(lines.text.capacity() < 4 * LONGEST);
    }
}
