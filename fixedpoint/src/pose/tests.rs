use super::*;
use crate::formats::{Angle, Column, FocalLength, Obliquity, StripeWidth};
use crate::landmark::Format;
use proptest::prelude::*;
use std::f64::consts::PI;

fn floats<Parent, Child>(pose: &Pose<Parent, Child>) -> [f64; 3] {
    [pose.x.to_num(), pose.y.to_num(), f64::from(pose.theta.to_bits()) * PI / 2_f64.powi(31)]
}

/// The difference of two angles, the short way round.
fn turn(one: f64, other: f64) -> f64 {
    ((one - other + 3.0 * PI).rem_euclid(2.0 * PI) - PI).abs()
}

/// POSE-1 to POSE-3, word for word, for a homography in floating point.
fn specified([a, s, k]: [f64; 3], f: f64, w: f64) -> [f64; 3] {
    let (alpha_0, alpha_1) = ([f, 0.0], [0.0, -1.0]);
    let column =
        |[top, bottom]: [f64; 2]| [alpha_1[0] * top + alpha_0[0] * bottom, alpha_1[1] * top + alpha_0[1] * bottom];
    let (beta_1, beta_0) = (column([s / w, k / w]), column([a, 1.0]));
    let scale = beta_0[0].signum() / beta_1[0].hypot(beta_1[1]);
    let (beta_1, beta_0) = (beta_1.map(|b| b * scale), beta_0.map(|b| b * scale));
    let theta = beta_1[0].atan2(beta_1[1]);
    let (sin, cos) = theta.sin_cos();
    [-(cos * beta_0[0] - sin * beta_0[1]), -(sin * beta_0[0] + cos * beta_0[1]), theta]
}

fn camera(width: u16, f: f64) -> Camera {
    let middle = Column::from_num(f64::from(width - 1) / 2.0);
    Camera::new(width, middle, FocalLength::from_num(f)).unwrap()
}

fn homography(a: f64, s: f64, k: f64) -> Homography {
    Homography { a: Column::from_num(a), s: Column::from_num(s), k: Obliquity::from_num(k) }
}

//= reference/SPEC.md#pose
//= type=test
//# - **POSE-2** The camera's heading MUST be `θ = atan2(β_1x, β_1y)` (ERRATA-5).
#[test]
fn looking_straight_at_a_barcode_is_a_heading_of_pi() {
    // 15 mm to either side are 40 px at 640 px focal length: 0.24 m.
    let straight = pose(&homography(0.0, 40.0, 0.0), &Camera::epuck(), &Landmark::paper());
    assert_eq!((straight.x, straight.y), (Length::from_num(0.24), Length::ZERO));
    assert_eq!(straight.theta, Angle::PI);
    // The barcode at the right half of the image, seen by a camera that looks straight at the wall: the barcode is at
    // a larger y than the camera.
    let aside = pose(&homography(80.0, 40.0, 0.0), &Camera::epuck(), &Landmark::paper());
    assert_eq!((aside.x, aside.y), (Length::from_num(0.24), Length::from_num(-0.03)));
}

#[test]
fn what_does_not_fit_saturates() {
    let landmark = Landmark::new(Format::Wide, StripeWidth::from_num(0.02)).unwrap();
    let far = pose(&homography(100.0, 0.01, 0.0), &camera(640, 2048.0), &landmark);
    assert_eq!((far.x, far.y), (Length::MAX, Length::MIN));
    let nowhere = pose(&homography(0.0, 0.0, 0.0), &camera(640, 2048.0), &landmark);
    assert_eq!((nowhere.x, nowhere.theta), (Length::MAX, Angle::ZERO));
}

/// A ratio that does not fit is far away, on the side that its sign says.
#[test]
fn what_is_out_of_reach_is_as_far_as_the_format_holds() {
    let far = |sign| in_metres(None, sign, &Landmark::paper());
    assert_eq!([-1, 1].map(far), [Length::MIN, Length::MAX]);
}

proptest! {
    /// A camera anywhere in front of a barcode, projected by the equations of ERRATA: with `D` and `r` of the centre,
    /// `k = -W sin θ/D`, `s = f W cos θ/D`, `a = f r/D`.
    //= reference/SPEC.md#pose
    //= type=test
    //# - **POSE-1** With `α_0 = (f, 0)`, `α_1 = (0, -1)`, `A = [α_1 α_0]` and `H = [[s/W, a], [k/W, 1]]`, `B = [β_1
    //# β_0]` MUST be `A H` scaled so that `β_1` is a unit vector and `β_0`'s first component is positive (ERRATA-4).
    #[test]
    fn a_projected_barcode_gives_the_pose_back(
        x in 0.05..1.0_f64,
        y in -0.5..0.5_f64,
        inclination in -1.0..1.0_f64,
        f in 320.0..2048.0_f64,
    ) {
        let w = 0.015;
        let (sin, cos) = inclination.sin_cos();
        let (depth, right) = (x * cos + y * sin, x * sin - y * cos);
        let (a, s, k) = (f * right / depth, f * w * cos / depth, -w * sin / depth);
        prop_assume!(depth > 0.05 && a.abs() < 640.0 && k.abs() <= 0.5);
        let found = floats(&pose(&homography(a, s, k), &camera(640, f), &Landmark::paper()));
        // a, s and k are rounded by 2^-21 px and 2^-31; m and g again; f k and a k carry less than 2^11 2^-31.
        let rho = s.hypot(f * k);
        let distance = x.hypot(y);
        let relative = 2_f64.powi(-20) * 4.0 / rho;
        // f is rounded, too, and W.
        let bound = distance * (relative + 2_f64.powi(-17) / f + 1e-8) + 2_f64.powi(-24);
        prop_assert!((found[0] - x).hypot(found[1] - y) <= bound);
        prop_assert!(turn(found[2], PI + inclination) <= relative + 2_f64.powi(-17) / f + 1e-9);
    }

    /// The stated rounding errors and no others, against POSE-1 to POSE-3 for the same homography.
    //= reference/SPEC.md#pose
    //= type=test
    //# - **POSE-3** The camera's position MUST be `-R(θ) β_0`, the rigid transform (9).
    #[test]
    fn rounding_errors_are_those_stated(
        a in -1280.0..1280.0_f64,
        s in 4.0..960.0_f64,
        k in -0.5..=0.5_f64,
        f in 320_u16..=2048,
        wide in any::<bool>(),
        stripe_width in 0.0005..0.02_f64,
    ) {
        let homography = homography(a, s, k);
        let [a, s, k] =
            [homography.a.to_num(), homography.s.to_num(), homography.k.to_num::<f64>()];
        let (f, format) = (f64::from(f), if wide { Format::Wide } else { Format::Paper });
        let landmark = Landmark::new(format, StripeWidth::from_num(stripe_width)).unwrap();
        let w = landmark.stripe_width().to_num::<f64>() * f64::from(format.stripes()) / 2.0;
        let expected = specified([a, s, k], f, w);
        let found = floats(&pose(&homography, &camera(640, f), &landmark));

        let (m, rho_squared) = (f * k, s * s + f * k * f * k);
        let (unit, last) = (2_f64.powi(-21), 2_f64.powi(-25));
        // What the rounding of m does to the denominator, relatively.
        let shrink = (2.0 * m.abs() * unit + unit * unit) / rho_squared;
        let bound = |value: f64| (w * f * unit / rho_squared + value.abs() * shrink) * 1.000_01 + (w + 1.0) * last;
        prop_assert!((found[0] - expected[0]).abs() <= bound(expected[0]) + 1e-12);
        prop_assert!((found[1] - expected[1]).abs() <= bound(expected[1]) + 1e-12);
        prop_assert!(turn(found[2], expected[2]) <= 0.55 * PI / 2_f64.powi(31) + 1e-14);
    }

    /// Whatever the bits, nothing overflows, and a camera that sees the barcode the right way round (s > 0) looks at the
    /// wall: `cos θ = -s/ρ` (POSE-1, POSE-2), so θ is at least a quarter turn, and otherwise at most that.
    #[test]
    fn any_homography_has_a_heading_on_its_side(a in any::<i32>(), s in any::<i32>(), k in any::<i32>()) {
        let homography = Homography {
            a: Column::from_bits(a),
            s: Column::from_bits(s),
            k: Obliquity::from_bits(k),
        };
        let found = pose(&homography, &camera(640, 2048.0), &Landmark::wide());
        let (turned, quarter) = (found.theta.to_bits().unsigned_abs(), 1 << 30);
        if s > 0 {
            prop_assert!(turned >= quarter - 1, "{turned}");
        } else if s < 0 {
            prop_assert!(turned <= quarter + 1, "{turned}");
        }
    }
}
