//! A text that comes in pieces.

use std::io::{self, ErrorKind, Read};

/// Gives a few bytes at a time, and is interrupted now and then, as a pipe may be.
pub(super) struct Parts {
    text: Vec<u8>,
    place: usize,
    size: usize,
    calls: usize,
}

impl Parts {
    /// Pieces of up to `size` bytes, at least one.
    pub(super) fn new(text: &[u8], size: usize) -> Self {
        Self { text: text.to_vec(), place: 0, size: size.max(1), calls: 0 }
    }
}

impl Read for Parts {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        self.calls += 1;
        if self.calls.is_multiple_of(3) {
            return Err(ErrorKind::Interrupted.into());
        }
        let left = self.text.get(self.place..).unwrap_or_default();
        let count = left.len().min(self.size).min(into.len());
        into[..count].copy_from_slice(&left[..count]);
        self.place += count;
        Ok(count)
    }
}
