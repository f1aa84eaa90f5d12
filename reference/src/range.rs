//! Where a landmark is found: stripe width (5) and scan lines (6) (RANGE).

use crate::camera::Camera;
use crate::frame::{self, Pose};
use crate::landmark::Landmark;

/// Narrowest stripe that is still found, `L_min`, pixels (RANGE-1).
pub const MIN_STRIPE_PIXELS: f64 = 1.5;

/// The farthest distance, in metres, at which the narrowest stripe is `min_stripe_pixels` wide (RANGE-1, ERRATA-2).
///
/// The camera looks at the barcode's centre from the direction `inclination`, in radians. Where no distance will do: 0.
//= reference/SPEC.md#range
//# - **RANGE-1** The stripe-width range along direction θ MUST be the distance at which the narrowest stripe is `L_min`
//# = 1.5 px wide, `(d + |sin θ| N X_dim/2)(d + |sin θ| (N-2) X_dim/2) = f X_dim d cos θ / L_min` (ERRATA-2).
//= reference/SPEC.md#errata
//# - **ERRATA-2** (5) MUST be read with `B_y = X_dim/2 (N - 1) tan² θ`, `C = + X_dim² N (N - 2) tan² θ / 4` and `C_min
//# = L_min`.
#[must_use]
pub fn stripe_width_range(camera: &Camera, landmark: &Landmark, inclination: f64, min_stripe_pixels: f64) -> f64 {
    stripe_width_range_along(camera, landmark, inclination, inclination, min_stripe_pixels)
}

/// The farthest distance, in metres, at which no stripe is narrower than `min_stripe_pixels` (AREA-3); 0 if there is none.
///
/// The camera stands at the distance `d` from the barcode's centre in the direction `φ` and is inclined by `θ`, both in
/// radians from the wall's normal. The centre has the depth `e = d cos(φ - θ)` and the edge `b` the depth `e - b sin θ`;
/// the farthest stripe is the narrowest, and by (2) `f X d cos φ` over its two edges' depths wide. With `s = |sin θ|`,
/// `X = X_dim` and its width set to `L_min` that is the quadratic `e² - p e + s² X² N (N - 2)/4 = 0` with
/// `p = f X cos φ / (L_min cos(φ - θ)) - s X (N - 1)`. Between its roots the stripe is wider than `L_min`; the larger one
/// is the range. The smaller one bounds nothing: it is below `s X N/2`, where the near end is not in front of the camera.
#[must_use]
pub fn stripe_width_range_along(
    camera: &Camera,
    landmark: &Landmark,
    inclination: f64,
    direction: f64,
    min_stripe_pixels: f64,
) -> f64 {
    let (stripes, width) = (landmark.format.stripes() as f64, landmark.stripe_width);
    let (sine, foreshortening) = (inclination.sin().abs(), (direction - inclination).cos());
    let magnified = camera.focal_length * width * direction.cos() / (min_stripe_pixels * foreshortening);
    let sum = magnified - sine * width * (stripes - 1.0);
    let discriminant = sum * sum - (sine * width).powi(2) * stripes * (stripes - 2.0);
    if foreshortening > 0.0 && sum > 0.0 && discriminant >= 0.0 {
        f64::midpoint(sum, discriminant.sqrt()) / foreshortening
    } else {
        0.0
    }
}

/// The greatest depth, in metres, at which both scan lines see nothing but stripes of their layer: `h f_y/(2 q)` for a
/// row that ends `q` rows from the axis, the farther of both, and 0 if a row does not lie on its layer's side of the axis.
///
/// `q` rows are `D q/f_y` high at the depth `D` and leave a layer, `h/2` high, where that is `h/2` (ERRATA-3).
//= reference/SPEC.md#errata
//# - **ERRATA-3** (6) MUST be read with `h` the height of both layers, 50 mm.
#[must_use]
pub fn scan_line_depth(camera: &Camera, landmark: &Landmark) -> f64 {
    let middle = camera.height as f64 / 2.0;
    let (upper_begins, lower_begins) = (middle - camera.upper_row as f64 - 1.0, camera.lower_row as f64 - middle);
    let ends = upper_begins.max(lower_begins) + 1.0;
    let on_their_side = upper_begins >= 0.0 && lower_begins >= 0.0;
    if on_their_side { landmark.stripe_height * camera.focal_length_vertical / ends } else { 0.0 }
}

/// The farthest distance, in metres, at which both scan lines see nothing but stripes of their layer (RANGE-2); not
/// above 0 if there is none.
///
/// Seen from the direction `inclination`, in radians, the barcode's far end is `N X_dim |sin θ|/2` deeper than its centre.
//= reference/SPEC.md#range
//# - **RANGE-2** The scan-line range MUST be `h f_y/(2 q) - N X_dim |sin θ|/2` with `h` the height of both layers and
//# `q` the rows from the axis to the end of the scan line that ends farther from it, `Q_y/2` for the first and the last
//# row of an image (6) (ERRATA-3).
#[must_use]
pub fn scan_line_range(camera: &Camera, landmark: &Landmark, inclination: f64) -> f64 {
    scan_line_depth(camera, landmark) - landmark.half_width() * inclination.sin().abs()
}

/// The distance, in metres, from which one of the scan lines sees nothing of its layer at 0° (RANGE-4).
///
/// A detection needs both. A row whose end nearer to the axis is `q` rows from it leaves a layer of height `h/2` at
/// `h f_y/(2 q)`: never (infinity) where `q` is 0, and at once (0) where the row lies on the other layer's side.
//= reference/SPEC.md#range
//# - **RANGE-4** The detection rate MUST be 0 from the distance on at which one of the rows sees nothing of its layer,
//# frontally `h f_y/(2 q)` for a row that begins `q` rows from the axis.
#[must_use]
pub fn blind_range(camera: &Camera, landmark: &Landmark) -> f64 {
    let middle = camera.height as f64 / 2.0;
    let upper = (middle - camera.upper_row as f64 - 1.0, middle - camera.upper_row as f64);
    let lower = (camera.lower_row as f64 - middle, camera.lower_row as f64 + 1.0 - middle);
    let reach = landmark.stripe_height * camera.focal_length_vertical;
    let blind_from = |(near, far): (f64, f64)| if far > 0.0 { reach / near.max(0.0) } else { 0.0 };
    blind_from(upper).min(blind_from(lower))
}

/// The width, in pixels, of the narrowest stripe that the camera at `pose` sees, whether inside the image or not: the
/// least `L_k` of CAM-4. 0 where the barcode is seen from behind or has an edge that is not in front of the camera.
//= reference/SPEC.md#cam
//# - **CAM-4** The width of stripe k in the image MUST be `L_k = |f X_dim m (B_1 - B_2) / ((B_1 - b_{k-1})(B_1 -
//# b_k))|` where `sin θ` is not 0.
#[must_use]
pub fn narrowest_stripe(camera: &Camera, landmark: &Landmark, pose: &Pose<frame::Landmark, frame::Camera>) -> f64 {
    let edges: Vec<_> = landmark.edges().iter().map(|&b| camera.project_stripe(pose, b)).collect();
    if edges.iter().any(|edge| edge.depth <= 0.0) {
        return 0.0;
    }
    // The right-most edge comes first.
    edges.windows(2).map(|stripe| stripe[0].column - stripe[1].column).fold(f64::INFINITY, f64::min).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::landmark::Format;
    use core::f64::consts::{FRAC_PI_2, PI};
    use proptest::prelude::*;

    fn paper() -> Landmark {
        Landmark::new(Format::Paper)
    }

    /// The camera at `distance` from the barcode's centre, which it looks at.
    fn facing(distance: f64, inclination: f64) -> Pose<frame::Landmark, frame::Camera> {
        Pose::new(distance * inclination.cos(), distance * inclination.sin(), PI + inclination)
    }

    /// The specification's table, in centimetres at 0, 15, 30, 45 and 60°.
    //= reference/SPEC.md#land
    //= type=test
    //# - **LAND-6** Default dimensions MUST be `X_dim` = 1.5 mm and a stripe height of 25 mm (ERRATA-3).
    //= reference/SPEC.md#range
    //= type=test
    //# - **RANGE-1** The stripe-width range along direction θ MUST be the distance at which the narrowest stripe is
    //# `L_min` = 1.5 px wide, `(d + |sin θ| N X_dim/2)(d + |sin θ| (N-2) X_dim/2) = f X_dim d cos θ / L_min`
    //# (ERRATA-2).
    //= reference/SPEC.md#errata
    //= type=test
    //# - **ERRATA-3** (6) MUST be read with `h` the height of both layers, 50 mm.
    #[test]
    fn ranges_are_those_of_the_table() {
        let camera = Camera::epuck();
        let widths = [64.0, 61.1, 54.0, 43.2, 29.5];
        let lines = [50.0, 49.6, 49.2, 48.9, 48.7];
        for (step, (width, line)) in widths.into_iter().zip(lines).enumerate() {
            for inclination in [step as f64 * PI / 12.0, step as f64 * -PI / 12.0] {
                let by_width = 100.0 * stripe_width_range(&camera, &paper(), inclination, MIN_STRIPE_PIXELS);
                assert!((by_width - width).abs() <= 0.05, "stripe width {by_width} against {width}");
                let by_line = 100.0 * scan_line_range(&camera, &paper(), inclination);
                assert!((by_line - line).abs() <= 0.05, "scan line {by_line} against {line}");
            }
        }
    }

    /// Rows 2 and 5 of 8 end 2 rows from the axis, half as far as rows 0 and 7: twice the 50 cm. Row 1 ends 3 rows from it.
    //= reference/SPEC.md#range
    //= type=test
    //# - **RANGE-2** The scan-line range MUST be `h f_y/(2 q) - N X_dim |sin θ|/2` with `h` the height of both layers
    //# and `q` the rows from the axis to the end of the scan line that ends farther from it, `Q_y/2` for the first and
    //# the last row of an image (6) (ERRATA-3).
    #[test]
    fn the_scan_line_that_ends_farther_from_the_axis_counts() {
        let epuck = Camera::epuck();
        let depth = |upper_row, lower_row| scan_line_depth(&Camera { upper_row, lower_row, ..epuck }, &paper());
        assert!((depth(0, 7) - 0.5).abs() < 1e-12 && (depth(2, 5) - 1.0).abs() < 1e-12);
        assert!((depth(1, 5) - 2.0 / 3.0).abs() < 1e-12 && (depth(2, 6) - 2.0 / 3.0).abs() < 1e-12);
        // Rows 0 and 3 both lie above the axis.
        assert!(depth(0, 3).abs() < 1e-15);
        // Row 1 of 3 lies astride it.
        let astride = Camera { height: 3, upper_row: 0, lower_row: 1, ..epuck };
        assert!(scan_line_depth(&astride, &paper()).abs() < 1e-15);
    }

    #[test]
    fn without_a_root_there_is_no_range() {
        let camera = Camera::epuck();
        // 80°: p is 0.111 m - 0.028 m for 1.5 px and negative for 6 px.
        assert!(stripe_width_range(&camera, &paper(), 80_f64.to_radians(), 1.5) > 0.07);
        assert!(stripe_width_range(&camera, &paper(), 80_f64.to_radians(), 6.0).abs() < 1e-15);
        // 3 px at 80°: p = 0.0275 m is positive, but below s X sqrt(N (N - 2)) = 0.0280 m.
        assert!(stripe_width_range(&camera, &paper(), 80_f64.to_radians(), 3.0).abs() < 1e-15);
        // From behind both roots are negative.
        assert!(stripe_width_range(&camera, &paper(), 2.5, 1.5).abs() < 1e-15);
    }

    /// Rows 0 and 7 of 8 begin 3 rows from the axis: 25 mm * 80 / 3.
    //= reference/SPEC.md#range
    //= type=test
    //# - **RANGE-4** The detection rate MUST be 0 from the distance on at which one of the rows sees nothing of its
    //# layer, frontally `h f_y/(2 q)` for a row that begins `q` rows from the axis.
    #[test]
    fn blindness_is_that_of_the_rows() {
        let epuck = Camera::epuck();
        assert!((blind_range(&epuck, &paper()) - 2.0 / 3.0).abs() < 1e-12);
        // The first row to go blind counts: row 1 begins 2 rows from the axis, row 7 still 3.
        assert!((blind_range(&Camera { upper_row: 1, ..epuck }, &paper()) - 2.0 / 3.0).abs() < 1e-12);
        assert!((blind_range(&Camera { upper_row: 1, lower_row: 6, ..epuck }, &paper()) - 1.0).abs() < 1e-12);
        // Rows 3 and 4 touch the axis; rows 0 and 3 both lie above it.
        assert!(blind_range(&Camera { upper_row: 3, lower_row: 4, ..epuck }, &paper()).is_infinite());
        assert!(blind_range(&Camera { lower_row: 3, ..epuck }, &paper()).abs() < 1e-15);
    }

    #[test]
    fn narrowest_stripe_is_the_far_one() {
        let camera = Camera::epuck();
        // 640 * 1.5 mm at 0.3 m.
        assert!((narrowest_stripe(&camera, &paper(), &facing(0.3, 0.0)) - 3.2).abs() < 1e-9);
        // From 30° at 0.3 m the far stripe's edges are 0.3 + 0.0075 and 0.3 + 0.00675 m deep.
        let far = 640.0 * 1.5e-3 * 0.3 * 0.75_f64.sqrt() / (0.3075 * 0.30675);
        assert!((narrowest_stripe(&camera, &paper(), &facing(0.3, PI / 6.0)) - far).abs() < 1e-9);
    }

    #[test]
    fn what_is_not_in_view_has_no_stripes() {
        let camera = Camera::epuck();
        let from_behind = Pose::new(-0.3, 0.0, 0.0);
        let away = Pose::new(0.3, 0.0, 0.0);
        // Along the wall from the barcode's middle: half of it lies behind the camera.
        let beside = Pose::new(0.05, 0.0, FRAC_PI_2);
        for pose in [from_behind, away, beside] {
            assert!(narrowest_stripe(&camera, &paper(), &pose).abs() < 1e-15);
        }
    }

    /// The distance at which the narrowest stripe is `min_stripe_pixels` wide, on the ray that `place` describes.
    fn bisect(place: impl Fn(f64) -> Pose<frame::Landmark, frame::Camera>, min_stripe_pixels: f64) -> f64 {
        let (mut near, mut far) = (0.05, 4.0);
        for _ in 0..100 {
            let middle = f64::midpoint(near, far);
            let width = narrowest_stripe(&Camera::epuck(), &paper(), &place(middle));
            if width > min_stripe_pixels { near = middle } else { far = middle }
        }
        near
    }

    proptest! {
        #[test]
        fn at_the_range_the_narrowest_stripe_is_the_minimum(inclination in -1.3..1.3f64, pixels in 1.0..2.0f64) {
            let camera = Camera::epuck();
            let range = stripe_width_range(&camera, &paper(), inclination, pixels);
            prop_assert!((narrowest_stripe(&camera, &paper(), &facing(range, inclination)) - pixels).abs() < 1e-9);
            // The larger root: farther away it is narrower.
            prop_assert!(narrowest_stripe(&camera, &paper(), &facing(1.01 * range, inclination)) < pixels);
        }

        /// (5) as ERRATA-2 reads it, `A_xx x² + 2 A_xy x y + A_yy y² + 2 B_x x + 2 B_y y + C = 0`.
        //= reference/SPEC.md#errata
        //= type=test
        //# - **ERRATA-2** (5) MUST be read with `B_y = X_dim/2 (N - 1) tan² θ`, `C = + X_dim² N (N - 2) tan² θ / 4` and
        //# `C_min = L_min`.
        #[test]
        fn the_corrected_parabola_is_where_the_narrowest_stripe_is_the_minimum(
            theta in 0.02..1.0f64, mirrored in any::<bool>(), bearing in -0.2..0.2f64, pixels in 1.0..2.0f64,
        ) {
            let side = if mirrored { -1.0 } else { 1.0 };
            let at = |distance: f64| {
                let (x, y) = (distance * (theta + bearing).cos(), distance * (theta + bearing).sin());
                Pose::new(x, side * y, PI + side * theta)
            };
            let place = at(bisect(at, pixels));
            let (x, y) = (place.x(), side * place.y());
            let (stripes, width, tangent) = (20.0, 1.5e-3, theta.tan());
            let (a_xx, a_xy, a_yy) = (1.0, tangent, tangent * tangent);
            let b_x = width / 2.0 * ((stripes - 1.0) * tangent - 640.0 / (pixels * theta.cos().powi(2)));
            let b_y = width / 2.0 * (stripes - 1.0) * tangent * tangent;
            let c = width * width * stripes * (stripes - 2.0) * tangent * tangent / 4.0;
            let terms = [a_xx * x * x, 2.0 * a_xy * x * y, a_yy * y * y, 2.0 * b_x * x, 2.0 * b_y * y, c];
            let largest = terms.iter().fold(0.0, |most: f64, term| most.max(term.abs()));
            // The constant is the least of the terms, and not lost in the tolerance.
            prop_assert!(terms.iter().sum::<f64>().abs() < 1e-10 * largest && c > 1e-9 * largest, "{terms:?}");
        }
    }
}
