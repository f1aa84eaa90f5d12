//! Foreign bar codes with random data: correctly encoded, check digits and quiet zones included.

use barcoders::sym::code128::Code128;
use barcoders::sym::ean13::EAN13;
use barcoders::sym::tf::TF;
use rand::{Rng, RngExt};

/// A bar code: white quiet zones and bars, in modules.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Symbol {
    /// Widths from left to right, bar, space, ..., bar.
    pub(super) widths: Vec<u8>,
    /// White to the left and to the right.
    pub(super) quiet: [u8; 2],
}

impl Symbol {
    /// From modules, 1 for black, of which the first and the last are black.
    fn new(modules: &[u8], quiet: [u8; 2]) -> Self {
        let widths = modules.chunk_by(|one, next| one == next).map(|run| u8::try_from(run.len()).unwrap_or(u8::MAX));
        Self { widths: widths.collect(), quiet }
    }
}

fn digits<R: Rng>(count: usize, rng: &mut R) -> String {
    (0..count).map(|_| char::from(rng.random_range(b'0'..=b'9'))).collect()
}

/// EAN-13 of twelve random digits.
pub(super) fn ean13<R: Rng>(rng: &mut R) -> Symbol {
    let symbol = EAN13::new(digits(12, rng)).expect("twelve digits are an EAN-13");
    Symbol::new(&symbol.encode(), [11, 7])
}

/// Code 128 of 1 to 12 random characters of set B or pairs of digits of set C.
pub(super) fn code128<R: Rng>(rng: &mut R) -> Symbol {
    let count = rng.random_range(1..=12);
    // The library's marks of the character sets.
    let data = if rng.random() {
        format!("Ć{}", digits(2 * count, rng))
    } else {
        "Ɓ".chars().chain((0..count).map(|_| char::from(rng.random_range(b'!'..=b'Z')))).collect()
    };
    Symbol::new(&Code128::new(data).expect("characters of the set").encode(), [10, 10])
}

/// Interleaved 2 of 5 of 1 to 13 random digits and their check digit, which make pairs.
pub(super) fn itf<R: Rng>(rng: &mut R) -> Symbol {
    let count = 2 * rng.random_range(0..7) + 1;
    itf_of(&digits(count, rng))
}

/// Wide elements are three modules, the stop's bar too, which the library makes two.
fn itf_of(digits: &str) -> Symbol {
    let mut symbol = Symbol::new(&TF::interleaved(digits).expect("digits are an ITF").encode(), [10, 10]);
    let stop = symbol.widths.len() - 3;
    symbol.widths[stop] = 3;
    symbol
}

/// Two symbols of the same symbology.
pub(super) fn pair<R: Rng>(rng: &mut R) -> [Symbol; 2] {
    match rng.random_range(0..3) {
        0 => [ean13(rng), ean13(rng)],
        1 => [code128(rng), code128(rng)],
        _ => [itf(rng), itf(rng)],
    }
}

/// Bars and spaces of 1 to 4 modules, half of them of one, 14 to 40 modules together; a symbology that nobody uses.
pub(super) fn modules<R: Rng>(rng: &mut R) -> Symbol {
    let total = rng.random_range(14..=40_u8);
    let mut widths = Vec::new();
    let mut left = total;
    while left > 0 {
        let width = if rng.random() { 1 } else { rng.random_range(1..=4) };
        widths.push(left.min(width));
        left -= left.min(width);
    }
    if widths.len() % 2 == 0 {
        widths.pop();
    }
    Symbol { widths, quiet: [rng.random_range(2..=10), rng.random_range(2..=10)] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::generator;

    fn text(widths: &[u8]) -> String {
        widths.iter().map(|&width| char::from(b'0' + width)).collect()
    }

    /// 5901234123457, the example of the symbology's descriptions: the widths of GS1's tables, set A as `3211` for 0.
    /// The leading 5 stands for the sets A B B A A B.
    #[test]
    fn ean_13_of_a_published_number() {
        // Sets A and C by digit; set B is A from right to left. In A the first element is a space, in C a bar.
        let a = ["3211", "2221", "2122", "1411", "1132", "1231", "1114", "1312", "1213", "3112"];
        let set_b = |digit: usize| a[digit].chars().rev().collect::<String>();
        let left = [a[9].to_owned(), set_b(0), set_b(1), a[2].to_owned(), a[3].to_owned(), set_b(4)].concat();
        let right = [1, 2, 3, 4, 5, 7].map(|digit| a[digit]).concat();
        let symbol = Symbol::new(&EAN13::new("590123412345").unwrap().encode(), [11, 7]);
        assert_eq!(text(&symbol.widths), format!("111{left}11111{right}111"));
        assert_eq!(symbol.widths.iter().map(|&width| u32::from(width)).sum::<u32>(), 95);
    }

    /// `PJJ123C` in set A, whose check symbol is 54: 103 + 48 + 2*42 + 3*42 + 4*17 + 5*18 + 6*19 + 7*35 = 878 = 8*103 + 54.
    #[test]
    fn code_128_of_a_published_text() {
        let expected =
            ["211412", "313121", "112133", "112133", "123221", "223211", "221132", "131321", "311123", "2331112"];
        let symbol = Symbol::new(&Code128::new("ÀPJJ123C").unwrap().encode(), [10, 10]);
        assert_eq!(text(&symbol.widths), expected.concat());
    }

    /// 15400141288763, an ITF-14 of the symbology's descriptions: 13 digits and their check digit 3.
    #[test]
    fn itf_of_a_published_number() {
        let wide = ["00110", "10001", "01001", "11000", "00101", "10100", "01100", "00011", "10010", "01010"];
        let widths =
            |digit: char| wide[digit.to_digit(10).unwrap() as usize].chars().map(|w| if w == '1' { '3' } else { '1' });
        let digits: Vec<char> = "15400141288763".chars().collect();
        let pairs = digits.chunks(2).flat_map(|pair| widths(pair[0]).zip(widths(pair[1])).flat_map(|(b, s)| [b, s]));
        let expected: String = "1111".chars().chain(pairs).chain("311".chars()).collect();
        assert_eq!(text(&itf_of("1540014128876").widths), expected);
    }

    /// A bar first and last; as wide as the symbologies say.
    #[test]
    fn random_symbols_have_their_symbologys_form() {
        for index in 0..500 {
            let rng = &mut generator(1, index);
            let total = |symbol: &Symbol| {
                assert_eq!(symbol.widths.len() % 2, 1);
                symbol.widths.iter().map(|&width| usize::from(width)).sum::<usize>()
            };
            assert_eq!(total(&ean13(rng)), 95);
            assert_eq!(total(&code128(rng)) % 11, 2);
            // Start 4, stop 5, a pair of digits 2 (2 * 3 + 3) = 18.
            assert_eq!(total(&itf(rng)) % 18, 9);
            assert!((10..=40).contains(&total(&modules(rng))));
        }
    }
}
