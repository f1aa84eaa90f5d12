//! The check byte, against division of polynomials.

use fixedpoint::codeword::crc8;

/// `x^8 + x^5 + x^3 + x^2 + x + 1` (`CODE-2`).
const POLYNOMIAL: u32 = 0x12F;

/// The remainder of `message(x) x^8` divided by the polynomial, the message having so many bits.
fn remainder(message: u32, bits: u32) -> u32 {
    let mut rest = 0;
    for place in (0..bits + 8).rev() {
        let coefficient = if place < 8 { 0 } else { message >> (place - 8) & 1 };
        rest = rest << 1 | coefficient;
        if rest & 0x100 != 0 {
            rest ^= POLYNOMIAL;
        }
    }
    rest
}

/// What a step of the CRC makes of a register and a byte: `(register + byte) x^8`, divided.
fn step(register: u8, byte: u8) -> u8 {
    let [.., rest] = remainder(u32::from(register ^ byte), 8).to_be_bytes();
    rest
}

/// From any register, the step by a byte is the division of polynomials.
///
/// - Domain: all 2^16 registers and bytes; the CRC of one byte takes every value, as a proof of its own says.
/// - Fault: `codeword.rs`: `crc << 1 ^ 0x2F` → `crc << 1 ^ 0x1D`: another polynomial.
#[kani::proof]
#[kani::unwind(18)]
fn a_step_is_a_division() {
    let (before, byte): (u8, u8) = (kani::any(), kani::any());
    kani::cover!(crc8(&[before]) == 0x2F);
    // The register is the CRC without the last exclusive-or.
    assert_eq!(crc8(&[before, byte]) ^ 0xFF, step(crc8(&[before]) ^ 0xFF, byte));
}

/// No two bytes have the same CRC, so that the CRC of one byte takes every value.
///
/// - Domain: all 2^16 pairs.
/// - Fault: `codeword.rs`: `crc << 1 ^ 0x2F` → `crc << 1`: nothing is fed back.
#[kani::proof]
#[kani::unwind(9)]
fn different_bytes_have_different_crcs() {
    let (one, other): (u8, u8) = (kani::any(), kani::any());
    kani::cover!(one != other);
    assert!(one == other || crc8(&[one]) != crc8(&[other]));
}

/// The check byte of a `paper` payload is the remainder of its code word's polynomial, with what CODE-2 begins and
/// ends with.
///
/// - Domain: all 2^16 payloads.
/// - Fault: `codeword.rs`: `let mut crc = 0xFF_u8;` → `let mut crc = 0_u8;`: another beginning.
#[kani::proof]
#[kani::unwind(26)]
fn two_bytes_have_the_remainder_as_crc() {
    let bytes: [u8; 2] = kani::any();
    let message = u32::from(u16::from_be_bytes(bytes)) ^ 0xFF00;
    kani::cover!(message == 0);
    assert_eq!(u32::from(crc8(&bytes)), remainder(message, 16) ^ 0xFF);
}

/// The same of a `wide` payload.
///
/// - Domain: all 2^24 payloads.
/// - Fault: `codeword.rs`: `crc ^ 0xFF` → `crc`: another end.
#[kani::proof]
#[kani::unwind(34)]
fn three_bytes_have_the_remainder_as_crc() {
    let [high, middle, low]: [u8; 3] = kani::any();
    let message = u32::from_be_bytes([0, high, middle, low]) ^ 0xFF_0000;
    kani::cover!(message == 0);
    assert_eq!(u32::from(crc8(&[high, middle, low])), remainder(message, 24) ^ 0xFF);
}
