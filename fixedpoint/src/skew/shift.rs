//! What a moving camera does to one layer's homography, and to its ends in whole pixels.

use crate::formats::{Column, Obliquity};
use crate::homography::Homography;
use crate::ratio;

/// The shift `Δ = (a' - a, s' - s, k' - k)` of a homography: what the lower layer's has more than the upper one's (`SKEW-2`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shift {
    /// Of the centre, px.
    pub a: Column,
    /// Of the half width, px.
    pub s: Column,
    /// Of the obliquity, within ±3/2.
    pub k: Obliquity,
}

impl Shift {
    /// None, as at rest.
    pub const NONE: Self = Self { a: Column::ZERO, s: Column::ZERO, k: Obliquity::ZERO };

    /// A homography less another one, exactly; `None` outside of the formats.
    #[must_use]
    pub fn between(from: &Homography, to: &Homography) -> Option<Self> {
        Some(Self { a: to.a.checked_sub(from.a)?, s: to.s.checked_sub(from.s)?, k: to.k.checked_sub(from.k)? })
    }

    /// A homography plus this, exactly; `None` outside of the formats.
    #[must_use]
    pub fn added(&self, to: &Homography) -> Option<Homography> {
        Some(Homography { a: to.a.checked_add(self.a)?, s: to.s.checked_add(self.s)?, k: to.k.checked_add(self.k)? })
    }

    /// A homography less this (`SKEW-6`), limited to the formats.
    #[must_use]
    pub fn taken_off(&self, from: &Homography) -> Homography {
        Homography {
            a: from.a.saturating_sub(self.a),
            s: from.s.saturating_sub(self.s),
            k: from.k.saturating_sub(self.k),
        }
    }

    /// The shifts of the ends of the homography that this is the shift of (`SKEW-4`); `None` where they are more than 2^15 px.
    ///
    /// Error of what is rounded to whole pixels: 2^-30 px.
    //= reference/SPEC.md#skew
    //# - **SKEW-4** The *shift of an end* `t`, -1 for the first pixel and 1 for the last one, MUST be `c'(t) - c(t)`
    //# with `c(t) = (a + s t)/(1 + k t)`, rounded to the nearest pixel, halves up.
    #[must_use]
    pub fn of_ends(&self, homography: &Homography) -> Option<EndShifts> {
        let carried = self.added(homography)?;
        let end = |t: i64| {
            let moved = column(&carried, t)?.checked_sub(column(homography, t)?)?;
            i16::try_from(ratio::dropped(moved, COLUMN_BITS)).ok()
        };
        Some(EndShifts { first: end(-1)?, last: end(1)? })
    }
}

/// Fraction bits of an end's column.
const COLUMN_BITS: u8 = 30;

/// `c(t) = (a + s t)/(1 + k t)` at an end, px with [`COLUMN_BITS`]; `None` unless the end is in front of the camera.
fn column(homography: &Homography, t: i64) -> Option<i64> {
    let numerator = i64::from(homography.a.to_bits()) + t * i64::from(homography.s.to_bits()); // 20 fraction bits
    let denominator = (1 << 30) + t * i64::from(homography.k.to_bits()); // 30
    ratio::rounded(numerator, denominator, COLUMN_BITS + 10)
}

/// The shifts of a layer's ends in whole pixels (`SKEW-4`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EndShifts {
    /// Of the first pixel.
    pub first: i16,
    /// Of the last pixel.
    pub last: i16,
}

impl EndShifts {
    /// None, as at rest.
    pub const NONE: Self = Self { first: 0, last: 0 };

    /// Two pixels where the upper row has them, as the lower row should have them.
    #[must_use]
    pub fn added(&self, [first, last]: [i32; 2]) -> [i32; 2] {
        [first.saturating_add(i32::from(self.first)), last.saturating_add(i32::from(self.last))]
    }
}
