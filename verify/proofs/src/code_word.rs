//! The code word: what is encoded is read back, and nothing else is.

use fixedpoint::codeword::{crc8, decode, encode};
use fixedpoint::landmark::Format;
use fixedpoint::refusal::EncodeRefusal;

fn is_read_back(format: Format) {
    let payload: u32 = kani::any();
    kani::assume(payload >> format.payload_bits() == 0);
    let halves = encode(format, payload);
    kani::cover!(halves.is_ok());
    kani::cover!(halves.is_err());
    if let Ok((upper, lower)) = halves {
        assert_eq!(decode(format, upper, lower), Ok(payload));
    }
}

/// Whatever `decode` accepts is what `encode` makes of the payload.
fn is_the_only_word(format: Format) {
    let (upper, lower): (u16, u16) = (kani::any(), kani::any());
    let payload = decode(format, upper, lower);
    kani::cover!(payload.is_ok());
    kani::cover!(payload.is_err());
    if let Ok(payload) = payload {
        let stripes = u16::MAX >> (16 - format.code_stripes());
        assert_eq!(encode(format, payload), Ok((upper & stripes, lower & stripes)));
    }
}

/// A payload of `paper` that is encoded is read back.
///
/// - Domain: all 2^16 payloads.
/// - Fault: `codeword.rs`: `low_half(format, word >> format.code_stripes())` →
///   `low_half(format, word >> (format.code_stripes() + 1))`: the upper half is not the code word's first.
#[kani::proof]
#[kani::unwind(9)]
fn payloads_of_paper_are_read_back() {
    is_read_back(Format::Paper);
}

/// A payload of `wide` that is encoded is read back.
///
/// - Domain: all 2^24 payloads.
/// - Fault: `codeword.rs`: `let payload = word >> 8;` → `let payload = word << 1 >> 9;`: the first bit is lost.
#[kani::proof]
#[kani::unwind(9)]
fn payloads_of_wide_are_read_back() {
    is_read_back(Format::Wide);
}

/// Every word of `paper` but the payloads' own is refused; what is not of the format's stripes does not count.
///
/// - Domain: all 2^32 pairs of half words.
/// - Fault: `codeword.rs`: `payload)) != word & 0xFF` → `payload)) & 0x7F != word & 0x7F`: a bit of the check byte is
///   not compared.
#[kani::proof]
#[kani::unwind(9)]
fn other_words_of_paper_are_refused() {
    is_the_only_word(Format::Paper);
}

/// Every word of `wide` but the payloads' own is refused.
///
/// - Domain: all 2^32 pairs of half words.
/// - Fault: `codeword.rs`: `    if upper == lower {\n        return Err(PairRefusal::EqualHalves);` →
///   `    if upper == 1 {\n        return Err(PairRefusal::EqualHalves);`: equal halves are not refused.
#[kani::proof]
#[kani::unwind(9)]
fn other_words_of_wide_are_refused() {
    is_the_only_word(Format::Wide);
}

/// `encode` refuses exactly the payloads that CODE-5 and CODE-6 name.
///
/// - Domain: all 2^32 numbers, both formats.
/// - Fault: `codeword.rs`: `if payload >> format.payload_bits() != 0` → `if payload >> format.payload_bits() > 1`: a
///   payload of one bit too many is encoded.
#[kani::proof]
#[kani::unwind(9)]
fn refused_payloads_are_those_of_the_specification() {
    let (format, stripes) = if kani::any() { (Format::Paper, 12) } else { (Format::Wide, 16) };
    let payload: u32 = kani::any();
    let word = u64::from(payload) << 8 | u64::from(check_byte(format, payload));
    let expected = if word >> (2 * stripes) != 0 {
        Err(EncodeRefusal::TooLarge)
    } else if word >> stripes == word & ((1 << stripes) - 1) {
        Err(EncodeRefusal::EqualHalves)
    } else {
        Ok(())
    };
    kani::cover!(expected == Err(EncodeRefusal::TooLarge));
    kani::cover!(expected == Err(EncodeRefusal::EqualHalves));
    assert_eq!(encode(format, payload).map(|_| ()), expected);
}

fn check_byte(format: Format, payload: u32) -> u8 {
    let [_, high, middle, low] = payload.to_be_bytes();
    if format == Format::Paper { crc8(&[middle, low]) } else { crc8(&[high, middle, low]) }
}
