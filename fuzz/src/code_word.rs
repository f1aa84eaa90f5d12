//! Target `code_word`: code words of both pipelines against each other and against a third CRC (CODE).
//!
//! Input: a byte whose lowest bit chooses the format, four bytes of a payload, two of each half word, four of an error.

use crate::draw::Draw;
use crate::fault;
use crc::{CRC_8_AUTOSAR, Crc, NoTable};
use fixedpoint::refusal as port;
use reference::codeword::{self, EncodeRefusal};
use reference::landmark::Format;
use reference::refusal::PairRefusal;
use verify::port::port_format;

/// Bit by bit, without the tables that the reference has.
const CHECK: Crc<u8, NoTable> = Crc::<u8, NoTable>::new(&CRC_8_AUTOSAR);

/// Longest burst that an eight-bit check finds for sure.
const BURST: u32 = 8;

/// One input.
///
/// # Panics
/// If a code word of one pipeline is none of the other, does not come back, or an error in it passes that must not.
pub fn run(data: &[u8]) {
    let mut draw = Draw::new(data);
    let format = if draw.byte() & 1 == 0 { Format::Paper } else { Format::Wide };
    let payload = draw.long();
    // As it comes, and cut to what fits.
    encodes_alike(format, payload);
    encodes_alike(format, payload & ((1 << format.payload_bits()) - 1));
    let halves = [draw.word(), draw.word()];
    let _ = decodes_alike(format, halves);
    errors_are_found(format, payload & ((1 << format.payload_bits()) - 1), draw.long());
}

/// The half words of a payload by both pipelines (CODE-1 to CODE-6).
fn encodes_alike(format: Format, payload: u32) {
    let reference = codeword::encode(format, payload);
    let found = fault::half_words(format, payload, fixedpoint::codeword::encode(port_format(format), payload));
    let found = found.map(|(upper, lower)| (u32::from(upper), u32::from(lower))).map_err(|refusal| match refusal {
        port::EncodeRefusal::TooLarge => EncodeRefusal::TooLarge,
        port::EncodeRefusal::EqualHalves => EncodeRefusal::EqualHalves,
    });
    assert_eq!(reference, found, "{format:?} {payload:#x}");
    match reference {
        Ok((upper, lower)) => {
            let word = upper << format.code_stripes() | lower;
            let bytes = payload.to_be_bytes();
            let expected = CHECK.checksum(&bytes[4 - format.payload_bits() / 8..]);
            assert_eq!((word >> 8, word & 0xFF), (payload, u32::from(expected)), "CODE-1, CODE-2");
            assert_eq!(decodes_alike(format, half_words(upper, lower)), Ok(payload), "it comes back");
        }
        Err(EncodeRefusal::TooLarge) => assert!(payload >> format.payload_bits() != 0, "CODE-5"),
        // Of a word with equal halves nothing comes back (CODE-7).
        Err(EncodeRefusal::EqualHalves) => assert!(payload >> format.payload_bits() == 0, "CODE-6"),
    }
}

fn half_words(upper: u32, lower: u32) -> [u16; 2] {
    [upper, lower].map(|half| u16::try_from(half).expect("at most 16 stripes"))
}

/// The payload of two half words by both pipelines; bits that the format has no stripes for count in neither.
fn decodes_alike(format: Format, halves: [u16; 2]) -> Result<u32, PairRefusal> {
    let [upper, lower] = halves;
    let mask = (1_u32 << format.code_stripes()) - 1;
    let [high, low] = halves.map(|half| u32::from(half) & mask);
    let reference = codeword::decode(format, high, low);
    let found = fixedpoint::codeword::decode(port_format(format), upper, lower).map_err(|refusal| match refusal {
        port::PairRefusal::EqualHalves => PairRefusal::EqualHalves,
        port::PairRefusal::Crc => PairRefusal::Crc,
    });
    assert_eq!(reference, found, "{format:?} {upper:#x} {lower:#x}");
    if let Ok(payload) = reference {
        assert_eq!(codeword::encode(format, payload), Ok((high, low)), "what is decoded has this code word");
    }
    reference
}

/// Up to three wrong stripes, and a burst of up to eight, never pass (CODE-8).
fn errors_are_found(format: Format, payload: u32, error: u32) {
    let Ok((upper, lower)) = codeword::encode(format, payload) else { return };
    let stripes = u32::try_from(2 * format.code_stripes()).expect("at most 32");
    let bit = |place: u32| 1_u32 << (place % stripes);
    let few = bit(error & 0xFF) ^ bit(error >> 8 & 0xFF) ^ bit(error >> 16 & 0xFF);
    let burst = (error >> 24 | 1) << (error % (stripes - BURST + 1));
    for error in [few, burst] {
        if error == 0 {
            continue;
        }
        let [high, low] = half_words(error >> format.code_stripes(), error & ((1 << format.code_stripes()) - 1));
        let [upper, lower] = half_words(upper, lower);
        let decoded = decodes_alike(format, [upper ^ high, lower ^ low]);
        assert!(decoded.is_err(), "{format:?} {payload:#x} with the error {error:#x} passes as {decoded:?}");
    }
}
