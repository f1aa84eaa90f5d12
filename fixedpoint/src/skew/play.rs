//! How far odometry may be wrong about where the lower row sees what the upper row saw.

use crate::camera::Camera;
use crate::formats::Steps;
use crate::motion::{Drive, Ways};

/// The play in whole pixels, `ceil(5 f/b √(q (|l| + |r|) + u²/3))` (`SKEW-5`), `steps` being both wheels' in 2^-16, whichever way they
/// went: `|l| + |r|` is `u` times these, and what is under the root `u (3 n + 10^6 u)/(3 · 10^6)` m² of `n` steps.
///
/// Before it is rounded up the error is 2^-30 of it and 2^-20 px. It is below 2^17 px.
//= reference/SPEC.md#skew
//# - **SKEW-5** The *play* of a moving camera MUST be `T = ceil(5 f/b √(q (|l| + |r|) + u²/3))` pixels, with `q = 1e-6
//# m`, `u` of MOTION-1, the axle `b`, and `|l|` and `|r|` the sums of the lengths of the wheels' ways between both
//# times; at rest it is 0.
pub(super) fn play(steps: u64, drive: &Drive, camera: &Camera) -> u32 {
    if steps == 0 {
        return 0;
    }
    let step = drive.step();
    let (bits, mantissa) = (u32::from(step.bits), u128::from(step.mantissa)); // 37 to 53 bits
    // Fraction bits as the step has them: below 2^77 of 2^38 steps in 2^-16.
    let sum = (u128::from(3 * steps.min(1 << 38)) << bits.saturating_sub(16)) + 1_000_000 * mantissa;
    // 2 bits fraction bits, below 2^108, and 80.
    let variance = shifted(mantissa * sum, 80 - 2 * i32::from(step.bits)) / 3_000_000;
    let deviation = variance.isqrt(); // 40 fraction bits, below 2^38
    // 5 f/b per metre: 16 fraction bits over 40, and 48 more make 24; below 2^43.
    let by_metre = (u128::from(5 * u64::from(camera.focal_length().to_bits())) << 48)
        .checked_div(u128::from(drive.axle().unsigned_abs()))
        .unwrap_or(0);
    let whole = (deviation * by_metre).div_ceil(1 << 64);
    u32::try_from(whole).unwrap_or(u32::MAX)
}

/// `value 2^exponent`, rounded down.
fn shifted(value: u128, exponent: i32) -> u128 {
    let bits = exponent.unsigned_abs().min(127);
    if exponent < 0 { value >> bits } else { value << bits }
}

/// How many steps both wheels made in 2^-16, whichever way they went.
pub(super) fn steps_of(ways: &Ways) -> u64 {
    let length = |steps: Steps| u64::from(steps.to_bits().unsigned_abs());
    length(ways.left) + length(ways.right)
}
