//! Code word and check byte (CODE).

use crate::landmark::{Format, stripes};
use crate::refusal::PairRefusal;
use core::fmt;
use crc::{CRC_8_AUTOSAR, Crc};

const CHECK: Crc<u8> = Crc::<u8>::new(&CRC_8_AUTOSAR);

/// Why a payload has no code word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EncodeRefusal {
    /// The payload has more bits than the format (CODE-5).
    TooLarge,
    /// Both layers would look the same (CODE-6).
    EqualHalves,
}

impl fmt::Display for EncodeRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TooLarge => "the payload has more bits than the format carries",
            Self::EqualHalves => "both layers of this payload would look the same",
        })
    }
}

impl core::error::Error for EncodeRefusal {}

/// The check byte over the payload's bytes, most significant first (CODE-2).
//= reference/SPEC.md#code
//# - **CODE-2** The check byte MUST be CRC-8/AUTOSAR (polynomial 0x2F, initial value 0xFF, no reflection, final
//# exclusive-or 0xFF) over the payload's bytes, most significant byte first.
#[must_use]
pub fn check_byte(format: Format, payload: u32) -> u8 {
    let bytes = payload.to_be_bytes();
    CHECK.checksum(&bytes[4 - format.payload_bits() / 8..])
}

/// The upper and the lower layer's half of the code word, `N_code` bits each, most significant bit left-most
/// (CODE-1, CODE-4).
//= reference/SPEC.md#code
//# - **CODE-1** The code word MUST be the payload followed by its check byte, most significant bit first.
//= reference/SPEC.md#code
//# - **CODE-5** Encoding MUST refuse a payload that does not fit the format.
//= reference/SPEC.md#code
//# - **CODE-6** Encoding MUST refuse a payload whose code word has two equal halves (`EqualHalves`).
//= reference/SPEC.md#errata
//# - **ERRATA-8** The code word MUST be as in CODE.
pub fn encode(format: Format, payload: u32) -> Result<(u32, u32), EncodeRefusal> {
    if payload >> format.payload_bits() != 0 {
        return Err(EncodeRefusal::TooLarge);
    }
    let word = payload << 8 | u32::from(check_byte(format, payload));
    let (upper, lower) = halves(format, word);
    if upper == lower { Err(EncodeRefusal::EqualHalves) } else { Ok((upper, lower)) }
}

/// The stripes of both layers, upper first, of the landmark that carries `payload` (CODE-4).
//= reference/SPEC.md#code
//# - **CODE-4** The first half of the code word MUST stand on the upper layer and the second half on the lower, each
//# from left to right as seen.
pub fn layers(format: Format, payload: u32) -> Result<[Vec<bool>; 2], EncodeRefusal> {
    let (upper, lower) = encode(format, payload)?;
    Ok([stripes(format, upper), stripes(format, lower)])
}

/// The payload of two half words (CODE-7 before CODE-8, MERGE-3).
//= reference/SPEC.md#code
//# - **CODE-7** Decoding MUST refuse a code word with two equal halves (`EqualHalves`).
//= reference/SPEC.md#code
//# - **CODE-8** Decoding MUST refuse a code word whose check byte is wrong (`Crc`).
pub fn decode(format: Format, upper: u32, lower: u32) -> Result<u32, PairRefusal> {
    if upper == lower {
        return Err(PairRefusal::EqualHalves);
    }
    let word = upper << format.code_stripes() | lower;
    let payload = word >> 8;
    if u32::from(check_byte(format, payload)) == word & 0xFF { Ok(payload) } else { Err(PairRefusal::Crc) }
}

fn halves(format: Format, word: u32) -> (u32, u32) {
    let n = format.code_stripes();
    (word >> n, word & ((1 << n) - 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    //= reference/SPEC.md#code
    //= type=test
    //# - **CODE-2** The check byte MUST be CRC-8/AUTOSAR (polynomial 0x2F, initial value 0xFF, no reflection, final
    //# exclusive-or 0xFF) over the payload's bytes, most significant byte first.
    #[test]
    fn the_catalogue_means_the_specified_crc() {
        assert_eq!(CHECK.checksum(b"123456789"), 0xDF);
    }

    /// Code words of images that this project did not draw (tests/data/renders).
    //= reference/SPEC.md#code
    //= type=test
    //# - **CODE-1** The code word MUST be the payload followed by its check byte, most significant bit first.
    //= reference/SPEC.md#code
    //= type=test
    //# - **CODE-4** The first half of the code word MUST stand on the upper layer and the second half on the lower,
    //# each from left to right as seen.
    //= reference/SPEC.md#errata
    //= type=test
    //# - **ERRATA-8** The code word MUST be as in CODE.
    #[test]
    fn known_code_words() {
        assert_eq!(encode(Format::Paper, 0xcc0d), Ok((0b1100_1100_0000, 0b1101_0100_0000)));
        assert_eq!(encode(Format::Paper, 0x020b), Ok((0b0000_0010_0000, 0b1011_1001_1100)));
        assert_eq!(encode(Format::Wide, 0x30_5e2a), Ok((0b0011_0000_0101_1110, 0b0010_1010_1111_1111)));
    }

    //= reference/SPEC.md#code
    //= type=test
    //# - **CODE-6** Encoding MUST refuse a payload whose code word has two equal halves (`EqualHalves`).
    #[test]
    fn every_paper_payload_but_thirty_two_comes_back() {
        let mut equal = 0;
        for payload in 0..=0xFFFF {
            match encode(Format::Paper, payload) {
                Ok((upper, lower)) => assert_eq!(decode(Format::Paper, upper, lower), Ok(payload)),
                Err(refusal) => {
                    assert_eq!(refusal, EncodeRefusal::EqualHalves);
                    equal += 1;
                }
            }
        }
        assert_eq!(equal, 32);
    }

    //= reference/SPEC.md#code
    //= type=test
    //# - **CODE-5** Encoding MUST refuse a payload that does not fit the format.
    //= reference/SPEC.md#code
    //= type=test
    //# - **CODE-7** Decoding MUST refuse a code word with two equal halves (`EqualHalves`).
    //= reference/SPEC.md#code
    //= type=test
    //# - **CODE-8** Decoding MUST refuse a code word whose check byte is wrong (`Crc`).
    //= reference/SPEC.md#merge
    //= type=test
    //# - **MERGE-3** A pair MUST be refused by CODE-7 before CODE-8 is asked.
    #[test]
    fn what_is_no_landmark_is_refused() {
        assert_eq!(encode(Format::Paper, 0x1_0000), Err(EncodeRefusal::TooLarge));
        assert_eq!(encode(Format::Wide, 0x100_0000), Err(EncodeRefusal::TooLarge));
        assert_eq!(decode(Format::Wide, 0x1234, 0x1234), Err(PairRefusal::EqualHalves));
        let (upper, lower) = encode(Format::Wide, 0x30_5e2a).unwrap();
        for bit in 0..16 {
            assert_eq!(decode(Format::Wide, upper ^ 1 << bit, lower), Err(PairRefusal::Crc));
            assert_eq!(decode(Format::Wide, upper, lower ^ 1 << bit), Err(PairRefusal::Crc));
        }
    }
}
