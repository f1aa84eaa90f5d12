//! Which errors of a code word are always found.

use fixedpoint::codeword::{crc8, decode, encode};
use fixedpoint::landmark::Format;

/// Changes the bits of any payload's code word that are set in `error`: it is refused.
fn is_detected(format: Format, error: u32) {
    let payload: u32 = kani::any();
    kani::assume(payload >> format.payload_bits() == 0);
    let Ok((upper, lower)) = encode(format, payload) else { return };
    let stripes = format.code_stripes();
    let changed = |half: u16, error: u32| {
        let [.., high, low] = (u32::from(half) ^ error & ((1 << stripes) - 1)).to_be_bytes();
        u16::from_be_bytes([high, low])
    };
    kani::cover!(error & 1 == 1);
    assert!(decode(format, changed(upper, error >> stripes), changed(lower, error)).is_err());
}

/// One, two or three bits of a code word.
fn up_to_three_bits(format: Format) -> u32 {
    let places: [u8; 3] = kani::any();
    // In order, as they are no error of its own otherwise.
    kani::assume(places[0] <= places[1] && places[1] <= places[2] && places[2] < 2 * format.code_stripes());
    places.iter().fold(0, |error, place| error | 1 << place)
}

/// Any bits that are not all 0 of eight next to each other.
fn burst(format: Format) -> u32 {
    let (pattern, place): (u8, u8) = (kani::any(), kani::any());
    kani::assume(pattern != 0 && place <= 2 * format.code_stripes() - 8);
    u32::from(pattern) << place
}

/// A code word of `paper` with one, two or three wrong bits is refused.
///
/// - Domain: all 2^16 payloads, all 2324 errors.
/// - Fault: `codeword.rs`: `crc << 1 ^ 0x2F` → `crc << 1 ^ 0x01`: a polynomial that two errors get past.
#[kani::proof]
#[kani::unwind(9)]
fn three_wrong_bits_of_paper_are_found() {
    is_detected(Format::Paper, up_to_three_bits(Format::Paper));
}

/// The check byte is linear but for a constant: so an error of a `wide` code word is found in every one of them, or
/// in none.
///
/// - Domain: all 2^48 pairs of three bytes.
/// - Fault: `codeword.rs`: `if crc & 0x80 == 0 {` → `if crc >= 0x8F {`: what is fed back does not depend on one bit
///   alone.
#[kani::proof]
#[kani::unwind(9)]
fn check_bytes_are_linear() {
    let (one, other): ([u8; 3], [u8; 3]) = (kani::any(), kani::any());
    let sum = [one[0] ^ other[0], one[1] ^ other[1], one[2] ^ other[2]];
    kani::cover!(crc8(&one) == 0);
    assert_eq!(crc8(&sum), crc8(&one) ^ crc8(&other) ^ crc8(&[0; 3]));
}

/// One, two or three wrong bits of a `wide` code word, the linear part of whose check byte is not their own, are
/// found.
///
/// - Domain: all 5488 errors; a proof that check bytes are linear carries it to all 2^24 payloads.
/// - Fault: `codeword.rs`: `crc << 1 ^ 0x2F` → `crc << 1 ^ 0x03`: a polynomial that is itself such an error.
#[kani::proof]
#[kani::unwind(9)]
fn three_wrong_bits_of_wide_are_found() {
    let [payload @ .., check] = up_to_three_bits(Format::Wide).to_be_bytes();
    kani::cover!(check == 0);
    assert!(crc8(&payload) ^ crc8(&[0; 3]) != check);
}

/// A code word of `paper` with a burst of wrong bits, of a length up to 8, is refused.
///
/// - Domain: all 2^16 payloads, all bursts.
/// - Fault: `codeword.rs`: `crc << 1 ^ 0x2F` → `crc << 1 ^ 0x2E`: a polynomial that is itself such a burst.
#[kani::proof]
#[kani::unwind(9)]
fn bursts_in_paper_are_found() {
    is_detected(Format::Paper, burst(Format::Paper));
}

/// A code word of `wide` with a burst of wrong bits, of a length up to 8, is refused.
///
/// - Domain: all 2^24 payloads, all bursts.
/// - Fault: `codeword.rs`: `for _ in 0..8` → `for _ in 0..7`: a step that leaves a bit.
#[kani::proof]
#[kani::unwind(9)]
fn bursts_in_wide_are_found() {
    is_detected(Format::Wide, burst(Format::Wide));
}
