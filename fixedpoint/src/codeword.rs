//! The code word: payload and check byte, in two halves.

use crate::landmark::Format;
use crate::refusal::{EncodeRefusal, PairRefusal};

/// The halves of a payload's code word, upper and lower layer, the left-most stripe as the most significant of
/// `code_stripes` bits (`CODE-1`, `CODE-3`, `CODE-4`).
///
/// # Errors
/// `TooLarge` if the payload does not fit the format (`CODE-5`), `EqualHalves` if both halves would be equal (`CODE-6`).
//= reference/SPEC.md#code
//# - **CODE-1** The code word MUST be the payload followed by its check byte, most significant bit first.
//= reference/SPEC.md#code
//# - **CODE-3** Bits MUST become stripes by NRZ: 1 is a bar (black), 0 a space (white).
//= reference/SPEC.md#code
//# - **CODE-4** The first half of the code word MUST stand on the upper layer and the second half on the lower, each
//# from left to right as seen.
//= reference/SPEC.md#code
//# - **CODE-5** Encoding MUST refuse a payload that does not fit the format.
//= reference/SPEC.md#code
//# - **CODE-6** Encoding MUST refuse a payload whose code word has two equal halves (`EqualHalves`).
pub fn encode(format: Format, payload: u32) -> Result<(u16, u16), EncodeRefusal> {
    // At most 24 bits, so the code word fits 32.
    if payload >> format.payload_bits() != 0 {
        return Err(EncodeRefusal::TooLarge);
    }
    let word = payload << 8 | u32::from(check_byte(format, payload));
    let upper = low_half(format, word >> format.code_stripes());
    let lower = low_half(format, word);
    if upper == lower {
        return Err(EncodeRefusal::EqualHalves);
    }
    Ok((upper, lower))
}

/// The payload of two halves; bits above the format's `code_stripes` do not count (`CODE-1`, `CODE-4`).
///
/// # Errors
/// `EqualHalves` (`CODE-7`), and then `Crc` (`CODE-8`): the order of `MERGE-3`.
//= reference/SPEC.md#code
//# - **CODE-7** Decoding MUST refuse a code word with two equal halves (`EqualHalves`).
//= reference/SPEC.md#code
//# - **CODE-8** Decoding MUST refuse a code word whose check byte is wrong (`Crc`).
pub fn decode(format: Format, upper: u16, lower: u16) -> Result<u32, PairRefusal> {
    let upper = low_half(format, u32::from(upper));
    let lower = low_half(format, u32::from(lower));
    if upper == lower {
        return Err(PairRefusal::EqualHalves);
    }
    let word = u32::from(upper) << format.code_stripes() | u32::from(lower);
    let payload = word >> 8;
    if u32::from(check_byte(format, payload)) != word & 0xFF {
        return Err(PairRefusal::Crc);
    }
    Ok(payload)
}

/// The `code_stripes` low bits of a word.
fn low_half(format: Format, word: u32) -> u16 {
    let [_, _, high, low] = word.to_be_bytes();
    let unused = 16 - format.code_stripes();
    u16::from_be_bytes([high, low]) << unused >> unused
}

/// The check byte of a payload: its bytes most significant first, two of `paper` and three of `wide` (`CODE-2`).
//= reference/SPEC.md#code
//# - **CODE-2** The check byte MUST be CRC-8/AUTOSAR (polynomial 0x2F, initial value 0xFF, no reflection, final
//# exclusive-or 0xFF) over the payload's bytes, most significant byte first.
fn check_byte(format: Format, payload: u32) -> u8 {
    let [_, high, middle, low] = payload.to_be_bytes();
    match format {
        Format::Paper => crc8(&[middle, low]),
        Format::Wide => crc8(&[high, middle, low]),
    }
}

/// CRC-8/AUTOSAR, bit by bit (`CODE-2`).
#[must_use]
pub fn crc8(bytes: &[u8]) -> u8 {
    let mut crc = 0xFF_u8;
    for byte in bytes {
        crc ^= byte;
        for _ in 0..8 {
            crc = if crc & 0x80 == 0 { crc << 1 } else { crc << 1 ^ 0x2F };
        }
    }
    crc ^ 0xFF
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    //= reference/SPEC.md#code
    //= type=test
    //# - **CODE-2** The check byte MUST be CRC-8/AUTOSAR (polynomial 0x2F, initial value 0xFF, no reflection, final
    //# exclusive-or 0xFF) over the payload's bytes, most significant byte first.
    #[test]
    fn the_check_byte_is_crc_8_autosar() {
        // The catalogue's check value, and test vectors of AUTOSAR's specification of CRC routines.
        assert_eq!(crc8(b"123456789"), 0xDF);
        assert_eq!(crc8(&[0, 0, 0, 0]), 0x12);
        assert_eq!(crc8(&[0xF2, 0x01, 0x83]), 0xC2);
        assert_eq!(crc8(&[0x0F, 0xAA, 0x00, 0x55]), 0xC6);
        assert_eq!(crc8(&[0x92, 0x6B, 0x55]), 0x33);
    }

    //= reference/SPEC.md#code
    //= type=test
    //# - **CODE-6** Encoding MUST refuse a payload whose code word has two equal halves (`EqualHalves`).
    #[test]
    fn every_payload_of_paper_survives_or_has_equal_halves() {
        let mut equal_halves = 0;
        for payload in 0..1 << 16 {
            match encode(Format::Paper, payload) {
                Ok((upper, lower)) => {
                    assert!(upper < 1 << 12 && lower < 1 << 12);
                    assert_eq!(decode(Format::Paper, upper, lower), Ok(payload));
                }
                Err(refusal) => {
                    assert_eq!(refusal, EncodeRefusal::EqualHalves);
                    equal_halves += 1;
                }
            }
        }
        assert_eq!(equal_halves, 32);
    }

    //= reference/SPEC.md#code
    //= type=test
    //# - **CODE-1** The code word MUST be the payload followed by its check byte, most significant bit first.
    #[test]
    fn a_code_word_is_payload_then_check_byte() {
        // Bytes F2 01 83 and their check byte C2, from the vectors above.
        assert_eq!(encode(Format::Wide, 0x00F2_0183), Ok((0xF201, 0x83C2)));
        assert_eq!(decode(Format::Wide, 0xF201, 0x83C2), Ok(0x00F2_0183));
        let check = u16::from(crc8(&[0x12, 0x34]));
        assert_eq!(encode(Format::Paper, 0x1234), Ok((0x123, 0x400 | check)));
    }

    //= reference/SPEC.md#code
    //= type=test
    //# - **CODE-5** Encoding MUST refuse a payload that does not fit the format.
    #[test]
    fn payloads_that_do_not_fit_are_refused() {
        assert_eq!(encode(Format::Paper, 1 << 16), Err(EncodeRefusal::TooLarge));
        assert_eq!(encode(Format::Wide, 1 << 24), Err(EncodeRefusal::TooLarge));
        assert_eq!(encode(Format::Wide, u32::MAX), Err(EncodeRefusal::TooLarge));
    }

    //= reference/SPEC.md#code
    //= type=test
    //# - **CODE-7** Decoding MUST refuse a code word with two equal halves (`EqualHalves`).
    #[test]
    fn equal_halves_are_refused_before_the_check_byte() {
        // All white and all black have wrong check bytes, too.
        for half in [0, 0xFFF, 0x123] {
            assert_eq!(decode(Format::Paper, half, half), Err(PairRefusal::EqualHalves));
        }
    }

    proptest! {
        #[test]
        fn payloads_of_wide_survive(payload in 0_u32..1 << 24) {
            if let Ok((upper, lower)) = encode(Format::Wide, payload) {
                prop_assert_eq!(decode(Format::Wide, upper, lower), Ok(payload));
            }
        }

        //= reference/SPEC.md#code
        //= type=test
        //# - **CODE-8** Decoding MUST refuse a code word whose check byte is wrong (`Crc`).
        #[test]
        fn one_wrong_stripe_is_noticed(payload in 0_u32..1 << 24, bit in 0_u32..32) {
            if let Ok((upper, lower)) = encode(Format::Wide, payload) {
                let flip = 1_u32 << bit;
                let (high, low) = ((flip >> 16) as u16, (flip & 0xFFFF) as u16);
                prop_assert!(decode(Format::Wide, upper ^ high, lower ^ low).is_err());
            }
        }
    }
}
