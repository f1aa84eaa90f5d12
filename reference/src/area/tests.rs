use super::*;
use crate::camera::Camera;
use crate::frame::{self, Pose};
use crate::landmark::{Format, Landmark};
use crate::range::{MIN_STRIPE_PIXELS, narrowest_stripe};
use core::cell::Cell;
use core::f64::consts::PI;
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};

/// A camera, a landmark, an inclination and an `L_min`.
#[derive(Clone, Copy, Debug)]
struct View {
    camera: Camera,
    landmark: Landmark,
    inclination: f64,
    min_stripe_pixels: f64,
}

impl View {
    fn epuck(degrees: f64) -> Self {
        Self {
            camera: Camera::epuck(),
            landmark: Landmark::new(Format::Paper),
            inclination: degrees.to_radians(),
            min_stripe_pixels: MIN_STRIPE_PIXELS,
        }
    }

    fn area(&self) -> Area {
        Area::new(&self.camera, &self.landmark, self.inclination, self.min_stripe_pixels).unwrap()
    }

    fn pose(&self, x: f64, y: f64) -> Pose<frame::Landmark, frame::Camera> {
        Pose::new(x, y, PI + self.inclination)
    }

    /// How far outer and inner ends of the two rows are from the axis, rows, each on its own side.
    fn row_ends(&self) -> [f64; 4] {
        let middle = self.camera.height as f64 / 2.0;
        let (upper, lower) = (self.camera.upper_row as f64, self.camera.lower_row as f64);
        [middle - upper, middle - upper - 1.0, lower + 1.0 - middle, lower - middle]
    }

    /// Whether every condition holds by projecting the stripes' edges, and by how much the closest one does, as a share.
    fn judge(&self, x: f64, y: f64) -> (bool, f64) {
        let pose = self.pose(x, y);
        let edges: Vec<_> = self.landmark.edges().iter().map(|&b| self.camera.project_stripe(&pose, b)).collect();
        let size = x.hypot(y) + self.landmark.half_width();
        let mut slacks = vec![x / size];
        slacks.extend(edges.iter().map(|edge| edge.depth / size));
        if slacks.iter().all(|&slack| slack > 0.0) {
            let columns = self.camera.width as f64;
            slacks.extend(edges.iter().flat_map(|edge| [edge.column + 0.5, columns - 0.5 - edge.column]));
            slacks.push(narrowest_stripe(&self.camera, &self.landmark, &pose) / self.min_stripe_pixels - 1.0);
            let deepest = edges.iter().fold(0.0, |most: f64, edge| most.max(edge.depth));
            // A row's ends must lie within its layer's height, at the barcode's deepest edge.
            let rows = self.landmark.stripe_height * self.camera.focal_length_vertical / deepest;
            let [upper_outer, upper_inner, lower_outer, lower_inner] = self.row_ends();
            slacks.extend([upper_outer, lower_outer].map(|outer| rows / outer - 1.0));
            slacks.extend([upper_inner, lower_inner].map(|inner| if inner >= 0.0 { 1.0 } else { -1.0 }));
        }
        (slacks.iter().all(|&slack| slack >= 0.0), slacks.iter().fold(f64::INFINITY, |least, s| least.min(s.abs())))
    }

    /// A place at a share of the depths that (5) and (6) could allow, and of the field of view.
    fn place(&self, along: f64, across: f64) -> (f64, f64) {
        let by_width = self.camera.focal_length * self.landmark.stripe_width / self.min_stripe_pixels;
        let by_row = self.landmark.stripe_height * self.camera.focal_length_vertical / self.row_ends()[0].max(0.5);
        let u = along * by_width.min(by_row);
        let v = u * (across * self.camera.width as f64 - self.camera.principal_column) / self.camera.focal_length;
        let (sine, cosine) = self.inclination.sin_cos();
        (u * cosine + v * sine, u * sine - v * cosine)
    }
}

prop_compose! {
    fn camera()(
        width in 32..=640_usize, zoom in 0.5..3.0f64, principal in 0.0..=1.0f64, height in 2..40_usize,
        vertical in 10.0..200.0f64, from_above in 0..40_usize, from_below in 0..40_usize,
    ) -> Camera {
        // Mostly on their sides of the axis.
        let upper_row = (from_above % (height / 2 + 1)).min(height - 2);
        let lower_row = (height - 1 - from_below % (height / 2 + 1)).max(upper_row + 1);
        Camera {
            width,
            height,
            focal_length: (zoom * width as f64).min(2048.0),
            focal_length_vertical: vertical,
            principal_column: principal * (width as f64 - 1.0),
            upper_row,
            lower_row,
        }
    }
}

prop_compose! {
    fn view()(
        camera in camera(), wide in any::<bool>(), stripe_width in 0.5e-3..10e-3f64, stripe_height in 5e-3..0.3f64,
        inclination in -1.5..1.5f64, min_stripe_pixels in 0.5..4.0f64,
    ) -> View {
        let format = if wide { Format::Wide } else { Format::Paper };
        let camera = camera.checked().unwrap();
        View { camera, landmark: Landmark { format, stripe_width, stripe_height }, inclination, min_stripe_pixels }
    }
}

/// Twice the area of a triangle, positive if counter-clockwise.
fn turn(a: (f64, f64), b: (f64, f64), c: (f64, f64)) -> f64 {
    (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0)
}

fn shoelace(outline: &[(f64, f64)]) -> f64 {
    outline.windows(2).map(|side| turn(outline[0], side[0], side[1]) / 2.0).sum()
}

/// The specification's table, in centimetres: stripe width 64.0, 61.1, 54.0, 43.2, 29.5 and scan line 50.0, 49.6, 49.2,
/// 48.9, 48.7; whichever is smaller bounds the range.
//= reference/SPEC.md#area
//= type=test
//# - **AREA-5** The range along a direction MUST be the largest distance from the barcode's centre within the area, and
//# name the equation that bounds it.
#[test]
fn ranges_are_those_of_the_table() {
    use Limit::{ScanLineInclination, StripeWidth};
    let table = [
        (0.0, 64.0, 50.0, ScanLineInclination),
        (15.0, 61.1, 49.6, ScanLineInclination),
        (30.0, 54.0, 49.2, ScanLineInclination),
        (45.0, 43.2, 48.9, StripeWidth),
        (60.0, 29.5, 48.7, StripeWidth),
    ];
    for (degrees, by_width, by_line, limit) in table {
        for inclination in [degrees, -degrees] {
            let area = View::epuck(inclination).area();
            let bounds = area.bounds(area.inclination());
            let found = [bounds.stripe_width, bounds.scan_line, area.range(area.inclination()).distance];
            for (found, expected) in found.into_iter().zip([by_width, by_line, f64::min(by_width, by_line)]) {
                assert!((100.0 * found - expected).abs() <= 0.05, "{inclination}°: {found} against {expected}");
            }
            assert_eq!(area.range(area.inclination()).limit, limit);
        }
    }
}

/// Half the field of view has the tangent 240/640 = 3/8: the barcode's 15 mm to either side fit from 4 cm on, and the
/// area is the triangle from there to 50 cm, 46 cm high and as wide as 2 · 3/8 · 46 cm.
#[test]
fn the_frontal_area_is_a_triangle() {
    let area = View::epuck(0.0).area();
    assert!((area.bounds(0.0).field_of_view - 0.04).abs() < 1e-12);
    let mut outline = area.outline();
    outline.sort_by(|a, b| a.partial_cmp(b).unwrap());
    let expected = [(0.04, 0.0), (0.5, -0.1725), (0.5, 0.1725)];
    assert_eq!(outline.len(), 3);
    assert!(outline.iter().zip(expected).all(|(a, b)| (a.0 - b.0).abs() < 1e-12 && (a.1 - b.1).abs() < 1e-12));
    assert!((area.area() - 0.46 * 0.1725).abs() < 1e-12);
}

/// For 3 px the stripes end the area at 32 cm: the parabola is a line there.
#[test]
fn the_parabola_of_a_frontal_view_is_a_line() {
    let view = View { min_stripe_pixels: 3.0, ..View::epuck(0.0) };
    assert!((view.area().area() - 0.375 * 0.28 * 0.28).abs() < 1e-12);
    assert_eq!(view.area().range(0.0).limit, Limit::StripeWidth);
    // It is the limit of the parabolas.
    for inclination in [1e-4, 1e-8, 1e-12, 1e-15, -1e-15, -1e-8] {
        let near = View { inclination, ..view }.area();
        // Its 21 cm come closer by about (N - 1) X |θ|, 28.5 mm |θ|; the outline departs by 1 µm at most.
        assert!((near.area() - 0.0294).abs() < 0.01 * inclination.abs() + 1e-12, "{}", near.area());
        assert!((shoelace(&near.outline()) - near.area()).abs() < 1e-6);
    }
}

/// A principal column at 39.5 of 480 leaves 40 px to the left and 440 px to the right: frontally the left end is in view
/// from 15 mm · 640/40 = 24 cm on; farther to the left the whole barcode is from closer.
//= reference/SPEC.md#area
//= type=test
//# - **AREA-2** Every edge MUST be in the horizontal field of view, `-1/2 <= o_x + f r(b_k)/D(b_k) <= Q_x - 1/2` for k
//# = 0 and k = N (3), (4).
#[test]
fn the_principal_column_need_not_be_central() {
    let camera = Camera { principal_column: 39.5, ..Camera::epuck() };
    let area = View { camera, ..View::epuck(0.0) }.area();
    assert!((area.bounds(0.0).field_of_view - 0.24).abs() < 1e-12);
    // The lines y = 15 mm - 440/640 x and y = -15 mm + 40/640 x meet where 480/640 x = 30 mm.
    assert!(!area.contains(0.0399, -0.0125) && area.contains(0.0401, -0.0125));
    // In a direction beyond the field of view there is nothing, however far away.
    let beside = 5_f64.to_radians();
    assert_eq!(area.range(beside), Range { distance: 0.0, limit: Limit::FieldOfView });
    assert!(area.bounds(beside).field_of_view.is_infinite() && area.range(-beside).distance > 0.5);
}

//= reference/SPEC.md#area
//= type=test
//# - **AREA-4** The deepest edge MUST NOT be deeper than both scan lines see nothing but stripes, `u + N X_dim |sin
//# θ|/2 <= h f_y/(2 q)` with RANGE-2's `h` and `q` (6), and the area be empty if a scan line does not lie on its own
//# layer's side of the axis.
#[test]
fn nothing_is_left_of_an_area_by_name() {
    // Stripes of 20 mm are 40 cm wide, and whole in view from 53 cm on; (6) ends at 50 cm.
    let landmark = Landmark { stripe_width: 20e-3, ..Landmark::new(Format::Paper) };
    let large = View { landmark, ..View::epuck(0.0) }.area();
    assert_eq!(large.range(0.0), Range { distance: 0.0, limit: Limit::FieldOfView });
    // 6 px at 80° are never seen.
    let oblique = View { min_stripe_pixels: 6.0, ..View::epuck(80.0) }.area();
    assert_eq!(oblique.range(oblique.inclination()), Range { distance: 0.0, limit: Limit::StripeWidth });
    // Both rows above the axis.
    let camera = Camera { lower_row: 3, ..Camera::epuck() };
    let blind = View { camera, ..View::epuck(0.0) }.area();
    assert_eq!(blind.range(0.0), Range { distance: 0.0, limit: Limit::ScanLineInclination });
    for area in [large, oblique, blind] {
        assert!(area.outline().is_empty() && area.area().to_bits() == 0);
    }
}

//= reference/SPEC.md#area
//= type=test
//# - **AREA-8** An inclination outside ±90°, an `L_min` outside 0.1 to 100 px and a range that is not a positive number
//# MUST be refused.
#[test]
fn questions_without_meaning_are_refused() {
    let new = |inclination, pixels| Area::new(&Camera::epuck(), &Landmark::new(Format::Paper), inclination, pixels);
    for inclination in [1.571, -1.571, f64::NAN, f64::INFINITY] {
        assert_eq!(new(inclination, 1.5), Err(AreaRefusal::Inclination));
    }
    for pixels in [0.0, -1.0, 0.09, 101.0, f64::NAN] {
        assert_eq!(new(0.0, pixels), Err(AreaRefusal::MinStripe));
    }
    assert!(new(PI / 2.0, 0.1).is_ok() && new(-PI / 2.0, 100.0).is_ok());
    for reach in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refusal = required(&Camera::epuck(), Format::Paper, reach, 0.0, 1.5);
        assert_eq!(refusal, Err(NotWithThisCamera::Asked(AreaRefusal::Reach)));
    }
}

/// Inside is where every condition holds when the stripes are projected, except closer than 1e-9 (as a share; pixels for
/// columns) to one of the boundaries.
//= reference/SPEC.md#area
//= type=test
//# - **AREA-1** The detection area of a camera, a landmark, an inclination θ and an `L_min` MUST be the places `(x, y)`
//# with `x > 0` and `D(b_k) > 0`, k = 0..N, that meet AREA-2 to AREA-4, their boundaries included.
#[test]
fn inside_is_where_the_projected_stripes_say_so() {
    let (inside, outside) = (Cell::new(0), Cell::new(0));
    let places = prop::collection::vec((0.0..1.1f64, -0.1..1.1f64), 40);
    let mut runner = TestRunner::new(Config { failure_persistence: None, ..Config::with_cases(2000) });
    let outcome = runner.run(&(view(), places), |(view, places)| {
        let area = view.area();
        for (along, across) in places {
            let (x, y) = view.place(along, across);
            let (expected, slack) = view.judge(x, y);
            if slack > 1e-9 {
                prop_assert_eq!(area.contains(x, y), expected, "at ({}, {}), slack {}", x, y, slack);
                let count = if expected { &inside } else { &outside };
                count.set(count.get() + 1);
            }
        }
        Ok(())
    });
    outcome.unwrap();
    // Neither answer is rare, and the sliver is next to nothing of the 80,000.
    let (inside, outside) = (inside.get(), outside.get());
    assert!(inside > 8_000 && outside > 8_000 && inside + outside > 79_000, "{inside} inside, {outside} outside");
}

/// The area by counting the cells of a grid whose middles are inside by projection.
#[test]
fn the_content_is_that_of_a_grid() {
    let wide = Landmark { stripe_width: 4e-3, stripe_height: 0.1, ..Landmark::new(Format::Wide) };
    let off_centre = Camera { principal_column: 300.0, ..Camera::epuck() };
    let views = [
        View::epuck(30.0),
        View::epuck(-45.0),
        View::epuck(60.0),
        View { landmark: wide, ..View::epuck(50.0) },
        View { camera: off_centre, min_stripe_pixels: 2.0, ..View::epuck(-20.0) },
        View { camera: Camera { focal_length: 240.0, ..off_centre }, min_stripe_pixels: 0.2, ..View::epuck(70.0) },
    ];
    for view in views {
        let area = view.area();
        let outline = area.outline();
        let span = |of: fn(&(f64, f64)) -> f64| {
            outline.iter().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), c| (a.min(c), b.max(c)))
        };
        let ((left, right), (bottom, top)) = (span(|p| p.0), span(|p| p.1));
        // One cell around it, so that an outline that is too small would be seen.
        let cells = 400;
        let (step_x, step_y) = ((right - left) * 1.02 / f64::from(cells), (top - bottom) * 1.02 / f64::from(cells));
        let at = |low: f64, step: f64, i: i32| low - 0.01 * step * f64::from(cells) + (f64::from(i) + 0.5) * step;
        let count = (0..cells)
            .flat_map(|i| (0..cells).map(move |j| (i, j)))
            .filter(|&(i, j)| view.judge(at(left, step_x, i), at(bottom, step_y, j)).0)
            .count();
        let counted = count as f64 * step_x * step_y;
        assert!((counted / area.area() - 1.0).abs() < 3e-3, "{counted} against {} for {view:?}", area.area());
    }
}

/// Corners, points of the parabola, and the pieces between: on the boundary, in order, and convex.
fn check_outline(view: &View) -> Result<(), TestCaseError> {
    let area = view.area();
    let outline = area.outline();
    let content = area.area();
    // The outline departs from the boundary by at most 1 µm.
    let sides = (0..outline.len()).map(|i| (outline[i], outline[(i + 1) % outline.len()]));
    let length: f64 = sides.map(|(a, b)| (b.0 - a.0).hypot(b.1 - a.1)).sum();
    prop_assert!((shoelace(&outline) - content).abs() <= 1e-6 * length + 1e-15, "{content}");
    let size = outline.iter().fold(0.0, |most: f64, p| most.max(p.0.hypot(p.1)));
    for i in 0..outline.len() {
        let [a, b, c] = [0, 1, 2].map(|step| outline[(i + step) % outline.len()]);
        prop_assert!(turn(a, b, c) > -1e-12 * size * size, "not convex at {b:?}");
        // Some condition is just met, and with a millionth of the way to the middle all of them are.
        let (_, slack) = view.judge(b.0, b.1);
        prop_assert!(slack < 1e-7, "{slack} at {b:?}");
    }
    if content > 1e-6 {
        let n = outline.len() as f64;
        let middle = outline.iter().fold((0.0, 0.0), |m, p| (m.0 + p.0 / n, m.1 + p.1 / n));
        // The sides lie on the boundary as well, but for the micrometre between a parabola and its chord, which is a
        // share of 1/x of a stripe's width.
        for i in 0..outline.len() {
            let [a, b] = [0, 1].map(|step| outline[(i + step) % outline.len()]);
            let (x, y) = (f64::midpoint(a.0, b.0), f64::midpoint(a.1, b.1));
            let (_, slack) = view.judge(x, y);
            prop_assert!(slack < 1e-7 + 1e-5 / x.abs(), "{slack} between {a:?} and {b:?}");
        }
        for p in &outline {
            let between = |share: f64| (p.0 + share * (middle.0 - p.0), p.1 + share * (middle.1 - p.1));
            let (inner, outer) = (between(1e-6), between(-1e-6));
            prop_assert!(view.judge(inner.0, inner.1).0, "{inner:?} is not inside");
            prop_assert!(!view.judge(outer.0, outer.1).0, "{outer:?} is not outside");
        }
    }
    Ok(())
}

/// Where the view along the wall ends in it: the lines (3) and (4) then meet behind the camera or the wall.
#[test]
fn oblique_areas_end_at_the_wall() {
    for principal_column in [0.0, 120.0, 479.0] {
        for tenth in -900..=900 {
            // As wide a field of view as CAM-7 allows, stripes as narrow as AREA-8 does, and as wide.
            let narrow = View {
                camera: Camera { principal_column, focal_length: 240.0, ..Camera::epuck() },
                min_stripe_pixels: 0.1,
                ..View::epuck(f64::from(tenth) / 10.0)
            };
            let camera = Camera {
                width: 32,
                principal_column: principal_column * 31.0 / 479.0,
                focal_length: 16.0,
                ..Camera::epuck()
            };
            let landmark = Landmark { stripe_width: 20e-3, ..narrow.landmark };
            let wide = View { camera, landmark, min_stripe_pixels: 100.0, ..narrow };
            for view in [narrow, wide] {
                check_outline(&view).unwrap();
                let outline = view.area().outline();
                assert!(outline.iter().all(|&(x, _)| x > -1e-12), "{view:?}: {outline:?}");
            }
        }
    }
}

proptest! {
    /// The paper's (2) as CAM-4 reads it, with `B_1` and `B_2` of a camera at the boundary (5) in any direction.
    //= reference/SPEC.md#area
    //= type=test
    //# - **AREA-3** The narrowest stripe MUST be at least `L_min` wide, `(u + N X_dim |sin θ|/2)(u + (N - 2) X_dim |sin
    //# θ|/2) <= f X_dim x/L_min` (5) (ERRATA-2).
    #[test]
    fn at_the_boundary_the_narrowest_stripe_has_the_least_width(view in view(), turned in -1.0..1.0f64) {
        let area = view.area();
        let theta = view.inclination;
        let direction = theta + turned;
        if direction.cos() < 0.01 || theta.sin().abs() < 0.01 {
            return Ok(());
        }
        let distance = area.bounds(direction).stripe_width;
        let (x, y) = (distance * direction.cos(), distance * direction.sin());
        let (m, b1, b2) = (-1.0 / theta.tan(), y + x / theta.tan(), y - x * theta.tan());
        let width = |edges: &[f64]| {
            view.camera.focal_length * view.landmark.stripe_width * m * (b1 - b2) / ((b1 - edges[0]) * (b1 - edges[1]))
        };
        let edges = view.landmark.edges();
        // Only there is (2) about a barcode that is whole in front of the camera.
        if edges.iter().all(|b| (b1 - b) * theta.sin() > 0.0) {
            let narrowest = edges.windows(2).map(|pair| width(pair).abs()).fold(f64::INFINITY, f64::min);
            prop_assert!((narrowest / view.min_stripe_pixels - 1.0).abs() < 1e-9, "{narrowest}");
        }
    }

    #[test]
    fn the_outline_is_the_boundary(view in view()) {
        check_outline(&view)?;
    }

    /// Along a ray the area begins and ends where the bounds say.
    #[test]
    fn ranges_end_where_the_area_does(view in view(), turned in -0.7..0.7f64) {
        let area = view.area();
        let direction = (view.inclination + turned).clamp(-1.5, 1.5);
        let inside = |distance: f64| view.judge(distance * direction.cos(), distance * direction.sin()).0;
        let range = area.range(direction).distance;
        if range > 0.0 {
            let nearest = area.bounds(direction).field_of_view;
            prop_assert!(!inside(range * (1.0 + 1e-7)) && !inside(nearest * (1.0 - 1e-7)));
            if range > nearest * (1.0 + 1e-5) {
                prop_assert!(inside(range * (1.0 - 1e-7)) && inside(nearest * (1.0 + 1e-7)));
            }
        } else {
            let farthest = area.bounds(direction).farthest().distance.max(0.1);
            for share in 1..100 {
                prop_assert!(!inside(f64::from(share) * 0.01 * farthest));
            }
        }
    }

    /// With the dimensions that are required the camera stands at the border of the area, and with slightly smaller ones
    /// outside; whatever is refused no dimensions on a grid of LAND-7's will do.
    //= reference/SPEC.md#area
    //= type=test
    //# - **AREA-6** The dimensions required for a range at an inclination MUST be the smallest `X_dim` of LAND-7 and
    //# the smallest stripe height for which a camera that looks at the barcode's centre from there stands in the
    //# detection area.
    #[test]
    fn required_dimensions_are_the_smallest_that_will_do(view in view(), reach in 0.02..4.0f64) {
        let View { camera, inclination, min_stripe_pixels, .. } = view;
        let format = view.landmark.format;
        let reads = |stripe_width: f64, stripe_height: f64| {
            let view = View { landmark: Landmark { format, stripe_width, stripe_height }, ..view };
            view.judge(reach * inclination.cos(), reach * inclination.sin()).0
        };
        match required(&camera, format, reach, inclination, min_stripe_pixels) {
            Ok(Dimensions { stripe_width, stripe_height }) => {
                let larger = 1.0 + 1e-9;
                let fits = view_field(&view, format, stripe_width, reach);
                prop_assert!(fits < 1e-6 || reads(stripe_width * larger, stripe_height * larger));
                prop_assert!(!reads(stripe_width * larger, stripe_height * (1.0 - 1e-6)));
                let smaller = stripe_width * (1.0 - 1e-6);
                prop_assert!(stripe_width <= 0.5e-3 || !reads(smaller, 2.0 * stripe_height));
                prop_assert!((0.5e-3..=20e-3).contains(&stripe_width));
            }
            Err(_) => {
                for i in 0..=400 {
                    let stripe_width = 0.5e-3 * 40_f64.powf(f64::from(i) / 400.0);
                    prop_assert!(!reads(stripe_width, 1000.0), "stripes of {stripe_width} m would do");
                }
            }
        }
    }
}

/// By how many pixels the barcode's ends are in view at a distance on the inclination's axis.
fn view_field(view: &View, format: Format, stripe_width: f64, reach: f64) -> f64 {
    let landmark = Landmark { format, stripe_width, stripe_height: 1.0 };
    let pose = view.pose(reach * view.inclination.cos(), reach * view.inclination.sin());
    let column = |b: f64| view.camera.project_stripe(&pose, b).column;
    (column(-landmark.half_width()) + 0.5).min(view.camera.width as f64 - 0.5 - column(landmark.half_width()))
}

/// Each refusal by its name, and one landmark by hand: 1 m at 0° takes 1 m · 1.5/640 = 2.34 mm and half of 1 m · 8/80.
//= reference/SPEC.md#area
//= type=test
//# - **AREA-7** A range for which there are no such dimensions MUST be refused by the name of what stands against it:
//# (3) and (4), (5), (6) or LAND-7.
#[test]
fn requirements_by_hand() {
    let epuck = Camera::epuck();
    let paper = |reach, degrees: f64| required(&epuck, Format::Paper, reach, degrees.to_radians(), 1.5);
    let metre = paper(1.0, 0.0).unwrap();
    assert!((metre.stripe_width - 1.5 / 640.0).abs() < 1e-12 && (metre.stripe_height - 0.05).abs() < 1e-12);
    // The table the other way round: 43.2 cm at 45° is what 1.5 mm reach.
    let table = paper(0.432, 45.0).unwrap();
    assert!((table.stripe_width - 1.5e-3).abs() < 3e-6, "{table:?}");
    // 0.5 mm reach 21 cm; nearer they are still the smallest allowed, 10 mm wide and whole in view from 13.3 mm on.
    assert!((paper(0.1, 0.0).unwrap().stripe_width - 0.5e-3).abs() < 1e-15);
    let NotWithThisCamera::FieldOfView { nearest } = paper(0.01, 0.0).unwrap_err() else { panic!("in view") };
    assert!((nearest - 0.005 / 0.375).abs() < 1e-12);
    // 9 m take 21.1 mm.
    let NotWithThisCamera::Format { stripe_width } = paper(9.0, 0.0).unwrap_err() else { panic!("narrow") };
    assert!((stripe_width - 9.0 * 1.5 / 640.0).abs() < 1e-12);
    assert_eq!(required(&epuck, Format::Paper, 0.3, 80_f64.to_radians(), 6.0), Err(NotWithThisCamera::StripeWidth));
    let blind = Camera { lower_row: 3, ..epuck };
    assert_eq!(required(&blind, Format::Paper, 0.3, 0.0, 1.5), Err(NotWithThisCamera::ScanLineInclination));
    for refusal in [paper(0.01, 0.0), paper(9.0, 0.0)] {
        assert!(!refusal.unwrap_err().to_string().contains('\n'));
    }
}
