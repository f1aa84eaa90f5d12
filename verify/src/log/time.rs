//! Times of a log: whole microseconds, from decimal digits and back without a rounding on the way (LOG-3).

use core::fmt;
use core::str::FromStr;

/// A time of the robot's clock, whole microseconds from 0 to 2^63 - 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Time(u64);

/// Why a text is no time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeRefusal {
    /// It is not a decimal number.
    NotANumber,
    /// It is NaN or infinite.
    NotFinite,
    /// It is below 0.
    Negative,
    /// It is 2^63 µs or more.
    TooLarge,
}

impl fmt::Display for TimeRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotANumber => "is not a number",
            Self::NotFinite => "is not a finite number",
            Self::Negative => "is a negative time",
            Self::TooLarge => "is a time too large to count in microseconds",
        })
    }
}

impl core::error::Error for TimeRefusal {}

impl Time {
    /// So many microseconds after 0; `None` from 2^63 on.
    #[must_use]
    pub fn from_micros(micros: u64) -> Option<Self> {
        i64::try_from(micros).is_ok().then_some(Self(micros))
    }

    /// Microseconds since 0.
    #[must_use]
    pub fn micros(self) -> u64 {
        self.0
    }
}

/// A decimal number's digits without its point.
struct Decimal<'a> {
    negative: bool,
    whole: &'a str,
    fraction: &'a str,
    exponent: i64,
}

impl<'a> Decimal<'a> {
    fn of(text: &'a str) -> Option<Self> {
        let (negative, unsigned) = match text.strip_prefix('-') {
            Some(rest) => (true, rest),
            None => (false, text.strip_prefix('+').unwrap_or(text)),
        };
        let (mantissa, exponent) = match unsigned.split_once(['e', 'E']) {
            // What does not fit is beyond every time, or below every microsecond, all the same.
            Some((mantissa, power)) => (mantissa, exponent(power)?),
            None => (unsigned, 0),
        };
        let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
        let some = !(whole.is_empty() && fraction.is_empty());
        (some && digits(whole) && digits(fraction)).then_some(Self { negative, whole, fraction, exponent })
    }

    /// The number times 10^6, rounded to the nearest integer, halves up; `None` if it is too large.
    fn micros(&self) -> Option<u64> {
        let digits = self.whole.bytes().chain(self.fraction.bytes()).map(|byte| u64::from(byte - b'0'));
        // How many digits stand before the point once it has moved.
        let before = i64::try_from(self.whole.len()).ok()?.saturating_add(self.exponent).saturating_add(6);
        let mut micros: u64 = 0;
        let mut place = 0;
        for digit in digits {
            if place == before {
                return micros.checked_add(u64::from(digit >= 5));
            }
            if place > before {
                return Some(micros);
            }
            micros = micros.checked_mul(10)?.checked_add(digit)?;
            place += 1;
        }
        for _ in place..before {
            if micros == 0 {
                break;
            }
            micros = micros.checked_mul(10)?;
        }
        Some(micros)
    }

    fn is_zero(&self) -> bool {
        self.whole.bytes().chain(self.fraction.bytes()).all(|byte| byte == b'0')
    }
}

/// The power of ten behind an `e`; a very large one is as good as the largest.
fn exponent(text: &str) -> Option<i64> {
    let (sign, digits) = match text.strip_prefix('-') {
        Some(rest) => (-1, rest),
        None => (1, text.strip_prefix('+').unwrap_or(text)),
    };
    let number = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
    number.then(|| sign * digits.parse::<i64>().unwrap_or(i64::from(i32::MAX)).min(i64::from(i32::MAX)))
}

impl FromStr for Time {
    type Err = TimeRefusal;

    /// Seconds, such as `12.3` or `1.23e1` (LOG-3).
    //= reference/SPEC.md#log
    //# - **LOG-3** A time MUST be read from its decimal digits to the nearest whole microsecond, halves up, and be
    //# refused below 0 or from 2^63 µs on.
    fn from_str(text: &str) -> Result<Self, TimeRefusal> {
        let Some(decimal) = Decimal::of(text) else {
            // "nan", "inf" and their kin are numbers to some who write logs.
            return Err(if text.parse::<f64>().is_ok() { TimeRefusal::NotFinite } else { TimeRefusal::NotANumber });
        };
        if decimal.negative && !decimal.is_zero() {
            return Err(TimeRefusal::Negative);
        }
        decimal.micros().and_then(Self::from_micros).ok_or(TimeRefusal::TooLarge)
    }
}

impl fmt::Display for Time {
    /// Seconds with as many decimals as it takes, one at least.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (seconds, micros) = (self.0 / 1_000_000, self.0 % 1_000_000);
        let mut decimals = format!("{micros:06}");
        decimals.truncate(decimals.trim_end_matches('0').len().max(1));
        write!(f, "{seconds}.{decimals}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn micros(text: &str) -> Result<u64, TimeRefusal> {
        text.parse::<Time>().map(Time::micros)
    }

    //= reference/SPEC.md#log
    //= type=test
    //# - **LOG-3** A time MUST be read from its decimal digits to the nearest whole microsecond, halves up, and be
    //# refused below 0 or from 2^63 µs on.
    #[test]
    fn digits_are_taken_as_they_stand() {
        for (text, expected) in [
            ("0", 0),
            ("-0.0", 0),
            ("0.1", 100_000),
            ("+12.", 12_000_000),
            (".5", 500_000),
            ("0.0000005", 1),
            ("0.00000049999999999999999999999999", 0),
            ("1.0000014999", 1_000_001),
            // 4.35 s as a float64 is 4.3499999...: times 10^6 and cut it would be 4,349,999.
            ("4.35", 4_350_000),
            // Beyond what a float64 holds to the microsecond.
            ("9007199254.740993", 9_007_199_254_740_993),
            ("9223372036854.775807", (1 << 63) - 1),
            ("1.25e2", 125_000_000),
            ("1E-6", 1),
            ("5e-7", 1),
            ("4e-7", 0),
            ("1e-99999999999999999999", 0),
            ("0e99999999999999999999", 0),
            ("0.000000000001e12", 1_000_000),
        ] {
            assert_eq!(micros(text), Ok(expected), "{text}");
        }
    }

    #[test]
    fn what_is_no_time_says_why() {
        use TimeRefusal::{Negative, NotANumber, NotFinite, TooLarge};
        for (text, expected) in [
            ("", NotANumber),
            (".", NotANumber),
            ("1,5", NotANumber),
            ("12 s", NotANumber),
            ("0x10", NotANumber),
            ("1e", NotANumber),
            ("1e+-3", NotANumber),
            ("--1", NotANumber),
            ("NaN", NotFinite),
            ("-inf", NotFinite),
            ("-0.1", Negative),
            ("-1e-9", Negative),
            ("9223372036854.775808", TooLarge),
            ("1e300", TooLarge),
            ("18446744073709551616000000", TooLarge),
        ] {
            assert_eq!(micros(text), Err(expected), "{text}");
        }
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_as_the_same(exact in 0..1_u64 << 63, shift in 0..63_u32) {
            let time = Time::from_micros(exact >> shift).unwrap();
            prop_assert_eq!(time.to_string().parse::<Time>(), Ok(time));
        }

        /// Against whole-number arithmetic on the digits, the point put anywhere.
        #[test]
        fn rounding_is_to_the_nearest_halves_up(digits in 0..9 * 10_u64.pow(12), decimals in 0..15_usize) {
            let padded = format!("{digits:016}");
            let (whole, fraction) = padded.split_at(16 - decimals);
            let scale = 10_u128.pow(u32::try_from(decimals).unwrap());
            let expected = (u128::from(digits) * 2_000_000 + scale) / (2 * scale);
            prop_assert_eq!(micros(&format!("{whole}.{fraction}")).map(u128::from), Ok(expected));
            let scientific = format!("{digits}e-{decimals}");
            prop_assert_eq!(micros(&scientific).map(u128::from), Ok(expected));
        }

        #[test]
        fn any_text_has_an_answer(text in "[-+0-9.eEinfa ]{0,30}") {
            let found = micros(&text);
            // A float64 is no judge of the last microsecond, but of what is a number.
            prop_assert_eq!(found == Err(TimeRefusal::NotANumber), text.parse::<f64>().is_err(), "{}", text);
        }
    }
}
