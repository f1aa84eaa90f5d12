//! The robot's wheels.

use crate::binary::{scaled, times};
use crate::formats::{Share, WheelLength};
use crate::ratio::dropped;
use crate::refusal::DriveRefusal;

/// How a pose moves by the ways of the wheels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MotionModel {
    /// Along an arc (`MOTION-3`).
    #[default]
    Arc,
    /// Along the heading before, as in the paper (`MOTION-4`).
    Linear,
}

/// The nominal wheels and axle, and the way of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Drive {
    /// The axle in m with 32 fraction bits.
    axle: WheelLength,
    /// `u = step 2^-exponent` m, `step` from 2^30 to 2^31, `exponent` from 37 to 53.
    step: i32,
    exponent: u8,
}

impl Drive {
    /// Two wheels of a diameter, an axle apart, with so many steps a turn.
    ///
    /// Error: 2^-30 of the step.
    ///
    /// # Errors
    /// Unless the diameter is in 5 to 250 mm, the axle in 20 to 800 mm and a turn has 64 steps or more.
    pub fn new(diameter: WheelLength, axle: WheelLength, steps_per_turn: u16) -> Result<Self, DriveRefusal> {
        const PI: u64 = 3_373_259_426; // 30 fraction bits
        let millimetre = 4_294_967;
        if !(5 * millimetre..=250 * (millimetre + 1)).contains(&diameter.to_bits()) {
            return Err(DriveRefusal::Diameter);
        }
        if !(20 * millimetre..=800 * (millimetre + 1)).contains(&axle.to_bits()) {
            return Err(DriveRefusal::Axle);
        }
        if steps_per_turn < 64 {
            return Err(DriveRefusal::Steps);
        }
        let way = u64::from(diameter.to_bits()) * PI / u64::from(steps_per_turn.max(1)); // 62 fraction bits, 2^40 to 2^56
        let surplus = 33_u32.saturating_sub(way.leading_zeros());
        let step = (way + ((1 << surplus) >> 1)) >> surplus;
        Ok(Self {
            axle,
            step: i32::try_from(step.min(0x7FFF_FFFF)).unwrap_or_default(),
            exponent: u8::try_from(62_u32.saturating_sub(surplus)).unwrap_or_default(),
        })
    }

    /// The e-puck's (`MOTION-8`), rounded to 2^-32 m.
    //= reference/SPEC.md#motion
    //# - **MOTION-8** The e-puck's wheels MUST be 41 mm in diameter, 53 mm apart, with 1000 steps a turn.
    #[must_use]
    pub fn epuck() -> Self {
        // π 0.041/1000 m; the constructor's result, which a test compares.
        Self { axle: WheelLength::from_bits(227_633_267), step: 1_132_983_389, exponent: 43 }
    }

    /// The way of so many steps in 2^-16 (`MOTION-1`), metres with 40 fraction bits; error half a unit and 2^-30 of it.
    //= reference/SPEC.md#motion
    //# - **MOTION-1** The way of a wheel MUST be its steps times `u = π D/S`, with its nominal diameter D and S steps a
    //# turn.
    pub(super) fn way(&self, steps: i32) -> i64 {
        dropped(i64::from(steps) * i64::from(self.step), self.exponent.saturating_sub(24))
    }

    /// The way of a step (`MOTION-1`).
    pub(crate) fn step(&self) -> StepLength {
        StepLength { mantissa: self.step.unsigned_abs(), bits: self.exponent }
    }

    /// The nominal axle in m with 40 fraction bits.
    pub(crate) fn axle(&self) -> i64 {
        i64::from(self.axle.to_bits()) << 8
    }

    /// `u²/12` in m² with 62 fraction bits; error 2^-28 of it.
    pub(super) fn step_variance(&self) -> i64 {
        let step = i64::from(self.step);
        scaled(dropped(step * step, 20) / 12, 62 + 20 - 2 * i32::from(self.exponent))
    }

    /// `1/(b (1 + g))`; relative error 2^-30.5, of the axle 2^-33 and of the quotient's last bit.
    pub(super) fn over_axle(&self, g: Share) -> OverAxle {
        let axle = (self.axle() + times(self.axle(), g.to_bits(), 32)).unsigned_abs(); // 2^34 to 2^40
        let zeros = axle.leading_zeros();
        // 2^32 to 2^33, of which the reciprocal 2^63/normal is in 2^30 to 2^31.
        let normal = (axle << zeros.min(40)) >> 31;
        let quotient = ((1 << 63) + (normal >> 1)).checked_div(normal).unwrap_or(u64::MAX).min(0x7FFF_FFFF);
        // 1/b is quotient 2^-bits with `normal = axle 2^(zeros - 31)`, `axle = b 2^40`.
        OverAxle {
            mantissa: i32::try_from(quotient).unwrap_or(i32::MAX),
            bits: u8::try_from(54_u32.saturating_sub(zeros)).unwrap_or_default(),
        }
    }
}

/// The way of a step, `mantissa 2^-bits` m, the mantissa from 2^30 to 2^31 and `bits` from 37 to 53.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepLength {
    pub(crate) mantissa: u32,
    pub(crate) bits: u8,
}

/// The reciprocal of an axle, `mantissa 2^-bits` per metre, `bits` from 24 to 30.
#[derive(Clone, Copy, Debug)]
pub(super) struct OverAxle {
    mantissa: i32,
    bits: u8,
}

impl OverAxle {
    /// A length over the axle, both with 40 fraction bits.
    pub(super) fn of(&self, length: i64) -> i64 {
        times(length, self.mantissa, self.bits)
    }

    /// The reciprocal itself with 24 fraction bits, below 2^30.
    pub(super) fn inverse(&self) -> i32 {
        self.mantissa >> self.bits.saturating_sub(24).min(31)
    }

    /// The nominal axle's share of this one, `1/(1 + g)`, 30 fraction bits.
    pub(super) fn share(&self, drive: &Drive) -> i32 {
        i32::try_from(dropped(self.of(drive.axle()), 10)).unwrap_or(i32::MAX)
    }
}
