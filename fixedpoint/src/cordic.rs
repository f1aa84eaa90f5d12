//! The angle of a vector by CORDIC: shifts and additions only.

use crate::formats::Angle;

/// `atan(2^-i)` in units of π/2^47, rounded to nearest.
const ANGLES: [i64; 35] = [
    35_184_372_088_832,
    20_770_547_670_515,
    10_974_586_953_444,
    5_570_871_696_862,
    2_796_246_208_089,
    1_399_486_241_028,
    699_913_886_760,
    349_978_300_884,
    174_991_820_497,
    87_496_244_017,
    43_748_163_730,
    21_874_087_080,
    10_937_044_192,
    5_468_522_177,
    2_734_261_099,
    1_367_130_551,
    683_565_276,
    341_782_638,
    170_891_319,
    85_445_659,
    42_722_830,
    21_361_415,
    10_680_707,
    5_340_354,
    2_670_177,
    1_335_088,
    667_544,
    333_772,
    166_886,
    83_443,
    41_722,
    20_861,
    10_430,
    5_215,
    2_608,
];

/// The angle of the vector `(x, y)`, of any common scale, in (-π, π]; 0 for the vector 0.
///
/// The error is at most 0.55 · 2^-31 π, 8.1e-10 rad: 0.04 from the last rotation, `2^-34` rad; 0.001 from 35 rounded
/// table entries and from the shifts, which lose at most 35 units of 2^-59 of the vector; 0.5 from the last rounding.
#[must_use]
pub fn atan2(y: i64, x: i64) -> Angle {
    if x == 0 && y == 0 {
        return Angle::ZERO;
    }
    let (mut x, mut y) = scaled(x, y);
    let mut angle = 0;
    let turned = x < 0;
    if turned {
        (x, y) = (-x, -y);
    }
    // The vector is within a right angle of the x axis. It grows by less than 1.65 and stays below 2^62.
    for (shift, step) in (0_u32..).zip(ANGLES) {
        if y >= 0 {
            (x, y) = (x + (y >> shift), y - (x >> shift));
            angle += step;
        } else {
            (x, y) = (x - (y >> shift), y + (x >> shift));
            angle -= step;
        }
    }
    // Within ±2^46.001, so 16 bits less leave ±2^30.001.
    let angle = Angle::from_bits(i32::try_from((angle + (1 << 15)) >> 16).unwrap_or_default());
    if turned { angle + Angle::PI } else { angle }
}

/// The vector, scaled so that its larger component is between 2^59 and 2^60.
fn scaled(x: i64, y: i64) -> (i64, i64) {
    let unused = (x.unsigned_abs() | y.unsigned_abs()).leading_zeros();
    match unused.checked_sub(4) {
        Some(shift) => (x << shift, y << shift),
        None => (x >> (4 - unused), y >> (4 - unused)),
    }
}

#[cfg(test)]
mod tests;
