//! A fuzzer's bytes as numbers in ranges, from the front; where they end they are zeros.

use arbitrary::Unstructured;
use core::ops::Range;

/// Bytes that are used up one after the other.
#[derive(Debug)]
pub struct Draw<'a>(Unstructured<'a>);

impl<'a> Draw<'a> {
    /// All of an input.
    #[must_use]
    pub fn new(data: &'a [u8]) -> Self {
        Self(Unstructured::new(data))
    }

    /// A byte.
    pub fn byte(&mut self) -> u8 {
        self.0.arbitrary().unwrap_or_default()
    }

    /// A byte with its sign.
    pub fn signed(&mut self) -> i8 {
        self.byte().cast_signed()
    }

    /// Two bytes, the lower one first.
    pub fn word(&mut self) -> u16 {
        self.0.arbitrary().unwrap_or_default()
    }

    /// Four bytes, the lowest one first.
    pub fn long(&mut self) -> u32 {
        self.0.arbitrary().unwrap_or_default()
    }

    /// A number of a range, both ends included, by two bytes.
    pub fn within(&mut self, range: Range<f64>) -> f64 {
        range.start + (range.end - range.start) * f64::from(self.word()) / f64::from(u16::MAX)
    }

    /// A whole number below `count` by one byte; 0 where `count` is 0.
    pub fn below(&mut self, count: usize) -> usize {
        usize::from(self.byte()).checked_rem(count).unwrap_or_default()
    }

    /// Whether nothing is left.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// What is left.
    #[must_use]
    pub fn rest(self) -> &'a [u8] {
        self.0.take_rest()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_taken_from_the_front_and_zeros_follow() {
        let mut draw = Draw::new(&[0x80, 0x34, 0x12, 0xFF, 0xFF, 7, 9]);
        assert_eq!((draw.signed(), draw.word()), (-128, 0x1234));
        assert!((draw.within(1.0..3.0) - 3.0).abs() < 1e-12);
        assert_eq!(draw.below(5), 2);
        assert_eq!(draw.rest(), [9]);
        let mut none = Draw::new(&[]);
        assert!(none.is_empty());
        assert_eq!((none.byte(), none.long(), none.below(0)), (0, 0, 0));
        assert!((none.within(-2.0..5.0) + 2.0).abs() < 1e-12);
    }
}
