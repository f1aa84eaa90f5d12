//! The number formats: types for what the port reports, and one table of every quantity.
//!
//! Whatever is rounded is rounded to the nearest multiple of its resolution, halves up.

use core::ops::{Add, Neg, Sub};
use fixed::types::{I0F32, I2F30, I8F24, I12F20, I16F16, I24F40, U0F32, U2F30, U16F16};

/// Columns and half widths in px: `a` and `s` of a reported homography, the principal column.
pub type Column = I12F20;

/// The obliquity `k` of a homography, in [-1/2, 1/2] (`HOMOG-3`); no unit.
pub type Obliquity = I2F30;

/// A camera's focal length in px.
pub type FocalLength = U16F16;

/// A stripe's width in metres, 0.5 to 20 mm.
pub type StripeWidth = U0F32;

/// A coordinate of a pose in metres.
pub type Length = I8F24;

/// A step of a site's grid in metres, above 0: 1023 of them err by less than half a micrometre.
pub type GridStep = U2F30;

/// The wheels' diameter and the axle in metres.
pub type WheelLength = U0F32;

/// The slip `q` in metres: m² of variance per metre of way.
pub type Slip = U0F32;

/// The shares `e` and `g` by which the wheels and the axle differ from nominal, and their standard deviations.
pub type Share = I0F32;

/// Steps of a wheel, with parts of one where an interval is divided.
pub type Steps = I16F16;

/// How far a camera moves between two rows, in metres.
pub type Displacement = I24F40;

/// An angle in units of π/2^31, from -π inclusive to π exclusive, where the smallest value stands for π (`FRAME-5`).
///
/// Angles wrap, as the integers do.
//= reference/SPEC.md#frame
//# - **FRAME-5** An angle that a pose reports MUST lie in (-π, π].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Angle(i32);

impl Angle {
    /// No rotation.
    pub const ZERO: Self = Self(0);
    /// Half a turn.
    pub const PI: Self = Self(i32::MIN);

    /// The angle `bits` π/2^31; `i32::MIN` is π.
    #[must_use]
    pub const fn from_bits(bits: i32) -> Self {
        Self(bits)
    }

    /// The angle in units of π/2^31; π is `i32::MIN`.
    #[must_use]
    pub const fn to_bits(self) -> i32 {
        self.0
    }
}

impl Add for Angle {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(self.0.wrapping_add(other.0))
    }
}

impl Sub for Angle {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(self.0.wrapping_sub(other.0))
    }
}

impl Neg for Angle {
    type Output = Self;
    fn neg(self) -> Self {
        Self(self.0.wrapping_neg())
    }
}

/// One quantity and its number format. A value is its integer over `2^fraction_bits`, in `unit`.
#[derive(Clone, Copy, Debug)]
pub struct FormatRow {
    /// The type or the field.
    pub name: &'static str,
    /// Unit of the value; `2^-Q px` is the ROI's own (`CROSS-1`).
    pub unit: &'static str,
    /// What it holds.
    pub holds: &'static str,
    /// Bits of the integer that carries it.
    pub bits: u8,
    /// How many of them are fraction bits.
    pub fraction_bits: u8,
    /// The smallest value that occurs, or the smallest of the format where all of it may.
    pub smallest: &'static str,
    /// The largest, likewise.
    pub largest: &'static str,
    /// The distance of neighbouring values.
    pub resolution: &'static str,
}

/// Every quantity and its number format, in the order in which a scan line meets them.
#[rustfmt::skip] // one row to a line
pub const FORMATS: [FormatRow; 78] = [
    row("pixel", "grey level", "one value of a scan line", 8, 0, "0", "255", "1"),
    row("pixel index", "px", "first pixel of a region, ends of an ROI", 16, 0, "0", "639", "1"),
    row("Threshold::twice", "grey level", "twice a threshold, T2 or T2(i)", 16, 0, "0", "510", "1"),
    row("Crossing::column", "2^-Q px", "z, from the ROI's middle", 16, 0, "-2^11", "2^11", "1"),
    row("Crossing::edge", "stripe", "v = j - N/2", 8, 0, "-12", "12", "1"),
    row("Normal", "powers of 2^-Q px", "sums of products of v and z", 64, 0, "-2^29.4", "2^32.4", "1"),
    row("Solution d", "(2^-Q px)^2", "determinant of the normal equations", 64, 0, "0", "2^47.4", "1"),
    row("Solution a", "(2^-Q px)^3", "centre times d", 64, 0, "-2^58.4", "2^58.4", "1"),
    row("Solution s", "(2^-Q px)^3", "width per stripe times d", 64, 0, "-2^55.5", "2^55.5", "1"),
    row("Solution k", "(2^-Q px)^2", "obliquity per stripe times d", 64, 0, "-2^44.5", "2^44.5", "1"),
    row("Sample::numerator", "(2^-Q px)^3", "middle of a stripe times its denominator", 64, 0, "-2^60.8", "2^60.8", "1"),
    row("Sample::denominator", "(2^-Q px)^2", "2 d (1 + k t)", 64, 0, "1", "2^49", "1"),
    row("Residual::numerator", "(2^-Q px)^3", "difference of two residuals times d", 64, 0, "0", "2^61.8", "1"),
    row("Residual::denominator", "(2^-Q px)^2", "d of a plausible homography", 64, 0, "1", "2^47.4", "1"),
    row("Column", "px", "a and s of a homography, principal column", 32, 20, "-2048", "2048 - 2^-20", "2^-20"),
    row("Obliquity", "1", "k of a homography", 32, 30, "-1/2", "1/2", "2^-30"),
    row("FocalLength", "px", "focal length of a camera", 32, 16, "16", "2048", "2^-16"),
    row("StripeWidth", "m", "X_dim of a landmark", 32, 32, "0.0005", "0.02", "2^-32"),
    row("Displacement", "m", "t of a skew", 64, 40, "-2^23", "2^23 - 2^-40", "2^-40"),
    row("Plane", "px", "f/ρ times a barcode's centre and its half", 64, 30, "-2^23", "2^23", "2^-30"),
    row("carried ratio", "1", "a/f and s/f of a carried homography", 64, 40, "-2^23", "2^23", "2^-40"),
    row("Shift a, s", "px", "shift of a homography", 32, 20, "-2048", "2048 - 2^-20", "2^-20"),
    row("Shift k", "1", "likewise", 32, 30, "-3/2", "3/2", "2^-30"),
    row("EndShifts", "px", "shift of an end", 16, 0, "-2^15", "2^15 - 1", "1"),
    row("Skew::play", "px", "play of a moving camera", 32, 0, "0", "2^17", "1"),
    row("pose ratio", "1", "x and y of a pose in half widths", 64, 24, "-2^39", "2^39", "2^-24"),
    row("Length", "m", "x and y of a pose", 32, 24, "-128", "128 - 2^-24", "2^-24"),
    row("GridStep", "m", "step of a site's grid", 32, 30, "2^-30", "4 - 2^-30", "2^-30"),
    row("Projection column", "px", "an edge, from the fit's origin", 32, 16, "-2^11", "2^11", "2^-16"),
    row("Boundary::ink", "px", "ink to the left of a pixel's boundary", 32, 16, "0", "2^11", "2^-16"),
    row("Boundary::distribution", "1", "normal distribution at a boundary", 32, 16, "0", "1", "2^-16"),
    row("Boundary::density", "1", "normal density at a boundary", 32, 16, "0", "0.4", "2^-16"),
    row("Blur", "px", "blur of a fit", 32, 20, "0.2", "1.2", "2^-20"),
    row("LayerModel::levels", "grey level", "the same while they are fitted", 32, 12, "-511", "511", "2^-12"),
    row("LayerLight", "grey level", "offset and gain of a fit, and their slopes", 32, 8, "-511", "511", "2^-8"),
    row("λ", "1", "place in a window", 32, 12, "-1", "1", "2^-12"),
    row("fit residual", "grey level", "a pixel less its model", 32, 8, "-256 + 2^-8", "256 - 2^-8", "2^-8"),
    row("fit derivative", "2^-E", "a pixel's derivatives, one E in a layer", 16, 14, "-1", "1", "2^-14"),
    row("Sums", "2^-E", "products of derivatives, of 10 bits each", 32, 20, "-640", "640", "2^-20"),
    row("Sums right", "2^-E grey level", "products of derivatives and residuals", 64, 22, "-2^17.4", "2^17.4", "2^-22"),
    row("Equations", "2^(e_i + e_j)", "scaled normal equations", 32, 30, "-1", "1", "2^-30"),
    row("Solution of Equations", "2^(e_N - e_i)", "a step", 64, 24, "-256", "256", "2^-24"),
    row("Fitted::variance", "squared grey level", "s² of a fit", 32, 16, "1/4", "2^16 - 2^-16", "2^-16"),
    row("Edges column", "px", "an edge, from the line's first pixel", 32, 16, "-2^14.6", "2^14.6", "2^-16"),
    row("Edges::ink", "1", "ink of an edge or a stripe in a pixel", 32, 16, "0", "1", "2^-16"),
    row("Seen", "grey level", "a pixel less white, and what ink does to it", 32, 8, "-1277", "1277", "2^-8"),
    row("Viterbi residual", "grey level", "a pixel less its model, before it is squared", 32, 4, "-1788", "1788", "2^-4"),
    row("Viterbi sum", "squared grey level", "squares on the way to a state", 32, 4, "0", "2^28 - 2^-4", "2^-4"),
    row("change", "grey level", "change of a pixel's model, and its residual", 32, 6, "-2^9 + 2^-6", "2^9 - 2^-6", "2^-6"),
    row("Squares", "squared grey level", "a decision margin", 32, 8, "-2^23", "2^23 - 2^-8", "2^-8"),
    row("Correlations", "squared grey level", "sums of products of two residuals", 64, 16, "-2^31.9", "2^31.9", "2^-16"),
    row("Covariance", "px², px, 1", "covariance of a, s and k", 64, 50, "-2^12", "2^12", "2^-50"),
    row("Node", "m", "x and y of a pose at a node", 64, 36, "-2^27", "2^27", "2^-36"),
    row("Derivatives", "m/px, 1/px", "of x, y and θ by a and s", 64, 40, "-2^23", "2^23", "2^-40"),
    row("PoseCovariance", "m², m, 1", "covariance of x, y and θ", 64, 48, "-2^15", "2^15", "2^-48"),
    row("Angle", "π", "heading of a pose; -1 stands for π", 32, 31, "-1", "1 - 2^-31", "2^-31"),
    row("sine", "1", "sines, cosines, chords and their derivatives", 32, 30, "-1", "1", "2^-30"),
    row("WheelLength", "m", "wheels' diameter, axle", 32, 32, "0.005", "0.8", "2^-32"),
    row("Drive step", "2^-exponent m", "way of a step", 32, 0, "2^30", "2^31 - 1", "1"),
    row("Steps", "1", "steps of a wheel", 32, 16, "-2^15", "2^15 - 2^-16", "2^-16"),
    row("Slip", "m", "variance of a way per metre", 32, 32, "0", "2^-12", "2^-32"),
    row("Share", "1", "e and g of a state, and their deviations", 32, 32, "-1/8", "1/8", "2^-32"),
    row("State x, y", "m", "position of a state, ways", 64, 40, "-2^23", "2^23", "2^-40"),
    row("State heading", "π", "heading of a state", 64, 63, "-1", "1 - 2^-63", "2^-63"),
    row("Step turn", "1", "turn of a step", 64, 40, "-2.5", "2.5", "2^-40"),
    row("OverAxle", "2^-bits/m", "reciprocal of an axle, bits from 24 to 30", 32, 0, "2^30", "2^31 - 1", "1"),
    row("Step derivatives", "m, 1, 1/64", "F less ones", 32, 30, "-1.2", "1.2", "2^-30"),
    row("WheelNoise::by", "1, 1/m", "G", 32, 24, "-64", "64", "2^-24"),
    row("WheelNoise::variance", "m²", "variance of a way", 64, 62, "0", "2^-12", "2^-62"),
    row("StateCovariance", "m², m, 1; e and g in 1/64", "covariance of a state", 64, 56, "-2^6.5", "2^6.5", "2^-56"),
    row("Linearised::residual", "16 px, 1/16; m, 1", "what was seen less what was expected", 64, 36, "-2^27", "2^27", "2^-36"),
    row("Linearised::by_pose", "16 px, 1/16; m, 1", "per metre and radian", 64, 32, "-2^31", "2^31", "2^-32"),
    row("View a, s", "px", "a landmark as it should be seen", 64, 32, "-2^31", "2^31", "2^-32"),
    row("View k", "1", "likewise, and W cos θ/d", 64, 40, "-2^6", "2^6", "2^-40"),
    row("Root", "m, 1; e and g in 1/64", "square root of a covariance", 64, 48, "-4", "4", "2^-48"),
    row("Normal sighting", "1", "a sighting in its standard deviations, per m and 1", 64, 28, "-2^35", "2^35", "2^-28"),
    row("Correction::moved", "m, 1; e and g in 1/64", "what an observation changes", 64, 40, "-2^23", "2^23", "2^-40"),
    row("Correction::nis", "1", "NIS of an observation", 64, 20, "0", "2^43", "2^-20"),
];

#[expect(clippy::too_many_arguments, reason = "one argument for each column of the table")]
const fn row(
    name: &'static str,
    unit: &'static str,
    holds: &'static str,
    bits: u8,
    fraction_bits: u8,
    smallest: &'static str,
    largest: &'static str,
    resolution: &'static str,
) -> FormatRow {
    FormatRow { name, unit, holds, bits, fraction_bits, smallest, largest, resolution }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{env, fmt::Write, fs, path::Path, string::String};

    const HEADER: &str = "# Number formats\n\n\
        Every quantity of the port and its format. A value is its integer divided by 2^fraction; what is rounded is\n\
        rounded to nearest, halves up. Written from `FORMATS` in `src/formats.rs` by\n\
        `BARLOC_REGENERATE=1 cargo test -p barloc-fixedpoint formats`.\n\n\
        | name | holds | unit | bits | fraction | smallest | largest | resolution |\n\
        |---|---|---|---|---|---|---|---|\n";

    fn markdown() -> String {
        let mut text = String::from(HEADER);
        for row in FORMATS {
            writeln!(
                text,
                "| `{}` | {} | {} | {} | {} | {} | {} | {} |",
                row.name, row.holds, row.unit, row.bits, row.fraction_bits, row.smallest, row.largest, row.resolution
            )
            .unwrap();
        }
        text
    }

    #[test]
    fn formats_md_is_up_to_date() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("FORMATS.md");
        if env::var_os("BARLOC_REGENERATE").is_some() {
            fs::write(&path, markdown()).unwrap();
        }
        assert_eq!(fs::read_to_string(&path).unwrap(), markdown(), "FORMATS.md is stale");
    }

    #[test]
    fn formats_table_describes_the_types() {
        let described = [
            ("Column", Column::INT_NBITS + Column::FRAC_NBITS, Column::FRAC_NBITS),
            ("Obliquity", Obliquity::INT_NBITS + Obliquity::FRAC_NBITS, Obliquity::FRAC_NBITS),
            ("FocalLength", FocalLength::INT_NBITS + FocalLength::FRAC_NBITS, FocalLength::FRAC_NBITS),
            ("StripeWidth", StripeWidth::INT_NBITS + StripeWidth::FRAC_NBITS, StripeWidth::FRAC_NBITS),
            ("Length", Length::INT_NBITS + Length::FRAC_NBITS, Length::FRAC_NBITS),
            ("GridStep", GridStep::INT_NBITS + GridStep::FRAC_NBITS, GridStep::FRAC_NBITS),
            ("Blur", Column::INT_NBITS + Column::FRAC_NBITS, Column::FRAC_NBITS),
            ("Displacement", Displacement::INT_NBITS + Displacement::FRAC_NBITS, Displacement::FRAC_NBITS),
            ("Angle", i32::BITS, 31),
            ("WheelLength", WheelLength::INT_NBITS + WheelLength::FRAC_NBITS, WheelLength::FRAC_NBITS),
            ("Slip", Slip::INT_NBITS + Slip::FRAC_NBITS, Slip::FRAC_NBITS),
            ("Share", Share::INT_NBITS + Share::FRAC_NBITS, Share::FRAC_NBITS),
            ("Steps", Steps::INT_NBITS + Steps::FRAC_NBITS, Steps::FRAC_NBITS),
        ];
        for (name, bits, fraction_bits) in described {
            let row = FORMATS.iter().find(|row| row.name == name).unwrap();
            assert_eq!((u32::from(row.bits), u32::from(row.fraction_bits)), (bits, fraction_bits), "{name}");
        }
    }

    //= reference/SPEC.md#frame
    //= type=test
    //# - **FRAME-5** An angle that a pose reports MUST lie in (-π, π].
    #[test]
    fn angles_wrap() {
        let quarter = Angle::from_bits(1 << 30);
        assert_eq!(quarter + quarter, Angle::PI);
        assert_eq!(-Angle::PI, Angle::PI);
        assert_eq!(Angle::PI + quarter, -quarter);
        assert_eq!(-quarter - quarter, Angle::PI);
    }
}
