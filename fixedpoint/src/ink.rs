//! How much of a pixel is ink of each stripe, for a homography and a blur.

use crate::camera::Camera;
use crate::edge::{self, Blur};
use crate::homography::Homography;
use crate::landmark::Format;
use crate::ratio;
use crate::reciprocal::Reciprocal;

/// What a pixel has where all of it is ink: 1, in units of 2^-16.
pub const WHOLE: i32 = 1 << 16;

/// The edges of a layer, `j = 0..N` from the left, and their blur.
#[derive(Clone, Copy, Debug)]
pub struct Edges {
    /// Columns in 2^-16 px from the middle of the line's first pixel.
    columns: [i32; 25],
    blur: Blur,
}

impl Edges {
    /// The edges where a homography has them (`HOMOG`): `z = (a + s t)/(1 + k t)` with `t = 2 j/N - 1`, for `|k| <= 3/4`.
    ///
    /// Rounding errors of a column, in px: 2^-17 from `N/2 (a + s t)` before it is divided by at least 3; 2^-16 from the
    /// division, rounded down; 2^-17 from the principal column; and 2^-27 of the column from the denominator.
    #[must_use]
    pub fn new(format: Format, homography: &Homography, blur: Blur, camera: &Camera) -> Self {
        let half = i64::from(format.stripes() / 2);
        let a = i64::from(homography.a.to_bits()); // 20 fraction bits
        let s = i64::from(homography.s.to_bits()); // 20
        let k = i64::from(homography.k.to_bits()); // 30
        let middle = ratio::dropped(i64::from(camera.principal_column().to_bits()), 4);
        let mut columns = [0; 25];
        for (edge, column) in (-half..=half).zip(columns.iter_mut()) {
            let numerator = ratio::dropped(half * a + edge * s, 4); // 16, below 2^31.6
            let denominator = u32::try_from((half << 26) + ((edge * k) >> 4)).unwrap_or(1); // 26, at least 3
            if let Some(inverse) = Reciprocal::of(denominator) {
                let product = numerator * i64::from(inverse.mantissa); // below 2^62.6
                let shift = 36_u8.saturating_sub(inverse.shift);
                *column = i32::try_from((product >> shift) + middle).unwrap_or(i32::MAX);
            }
        }
        Self { columns, blur }
    }

    /// The ink `c` that an edge `j` from white to black brings to a pixel (`EDGE-1`), 0 to 2^16 in units of 2^-16; 0 for an
    /// edge that there is not.
    ///
    /// The error is that of [`edge::ink`], and that of the column.
    #[must_use]
    pub fn ink(&self, edge: u8, pixel: u16) -> i32 {
        let Some(&column) = self.columns.get(usize::from(edge)) else { return 0 };
        let u = (i32::from(pixel) << 16).saturating_sub(column);
        let far = self.blur.reach() + (1 << 15);
        if u >= far {
            return WHOLE;
        }
        if u <= -far {
            return 0;
        }
        edge::ink(u, &self.blur).clamp(0, WHOLE)
    }

    /// The ink of a layer in a pixel (`EDGE-2`), 0 to 2^16 in units of 2^-16; bit `N - 1 - j` of `stripes` is 1 where stripe
    /// `j` is a bar.
    ///
    /// The error is that of [`Self::ink`] for each edge within reach.
    //= reference/SPEC.md#edge
    //# - **EDGE-2** The ink of a pixel MUST be the sum of `c` over all edges of a layer from white to black less that
    //# over all edges from black to white.
    #[must_use]
    pub fn layer(&self, format: Format, stripes: u32, pixel: u16) -> i32 {
        let is_bar = |place: u8| stripes.checked_shr(u32::from(place)).unwrap_or(0) & 1 == 1;
        let bars = (0..format.stripes()).filter(|&stripe| is_bar(format.stripes() - 1 - stripe));
        bars.map(|stripe| self.stripe(stripe, pixel)).sum()
    }

    /// The ink of a stripe in a pixel, if it is a bar (`TRELLIS-4`), 0 to 2^16 in units of 2^-16.
    //= reference/SPEC.md#trellis
    //# - **TRELLIS-4** The ink of stripe j in pixel i MUST be `w_ij = c(u_left) - c(u_right)`, of its two edges.
    #[must_use]
    pub fn stripe(&self, stripe: u8, pixel: u16) -> i32 {
        self.ink(stripe, pixel) - self.ink(stripe.saturating_add(1), pixel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::{View, covered};
    use crate::formats::{Column, Obliquity};

    fn edges(view: &View) -> Edges {
        let homography =
            Homography { a: Column::from_num(view.a), s: Column::from_num(view.s), k: Obliquity::from_num(view.k) };
        Edges::new(view.format, &homography, Blur::new(Column::from_num(view.blur)), &Camera::epuck())
    }

    /// Blurs as the format has them, so that what is compared is the arithmetic: an ink of 7e-5 on either side, and a
    /// column of 2^-17/3 + 2^-16 + 2^-17 + 2^-19 px with the steepest slope of an edge, 1.
    //= reference/SPEC.md#trellis
    //= type=test
    //# - **TRELLIS-4** The ink of stripe j in pixel i MUST be `w_ij = c(u_left) - c(u_right)`, of its two edges.
    #[test]
    fn inks_are_those_of_the_equations() {
        let bound = 1.4e-4 + 2_f64.powi(-17) / 3.0 + 2_f64.powi(-16) + 2_f64.powi(-17) + 2_f64.powi(-19);
        let mut seen = 0;
        for format in [Format::Paper, Format::Wide] {
            for (a, s, k) in [(0.0, 12.5, 0.0), (-100.25, 15.0, 0.75), (130.5, 14.0, -0.7), (3.125, 150.0, 0.25)] {
                for blur in [0.203_125, 0.5, 1.1875] {
                    let view = View { a, s, k, blur, ..View::turned(format, 1.0, 0.0) };
                    let found = edges(&view);
                    for edge in 0..=format.stripes() {
                        let column = view.column(2.0 * f64::from(edge) / f64::from(format.stripes()) - 1.0);
                        for pixel in 0..480 {
                            let exact = covered(f64::from(pixel) - column, blur);
                            let error = f64::from(found.ink(edge, pixel)) / 65536.0 - exact;
                            assert!(error.abs() <= bound, "{view:?} {edge} {pixel} {error}");
                            seen += i32::from(exact > 0.01 && exact < 0.99);
                        }
                    }
                }
            }
        }
        assert!(seen > 1000);
    }
}
