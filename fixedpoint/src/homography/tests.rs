use super::*;
use crate::hypotheses::Hypothesis;
use proptest::prelude::*;
use std::vec::Vec;

fn sums(points: &[(i8, i16)]) -> Normal {
    let mut normal = Normal::new();
    for &(edge, column) in points {
        normal.add(&Crossing { edge, column }).unwrap();
    }
    normal
}

/// The Gram determinant by Leibniz' rule, and the residuals of the normal equations, in wide arithmetic.
///
/// A solution is right if `Σ row (A + S v - K v z - D z)` vanishes for each of the rows `1`, `v`, `v z`.
fn judged(points: &[(i8, i16)], solution: &Solution) -> (i128, [i128; 3]) {
    let (a, s) = (i128::from(solution.a), i128::from(solution.s));
    let (k, d) = (i128::from(solution.k), i128::from(solution.d));
    let mut gram = [[0_i128; 3]; 3];
    let mut residuals = [0_i128; 3];
    for &(v, z) in points {
        let (v, z) = (i128::from(v), i128::from(z));
        let row = [1, v, -v * z];
        for i in 0..3 {
            residuals[i] += row[i] * (a + s * v - k * v * z - d * z);
            for j in 0..3 {
                gram[i][j] += row[i] * row[j];
            }
        }
    }
    let [[a, b, c], [d, e, f], [g, h, i]] = gram;
    (a * e * i + b * f * g + c * d * h - c * e * g - b * d * i - a * f * h, residuals)
}

fn assert_exact(points: &[(i8, i16)]) -> Solution {
    let solution = sums(points).solve();
    assert_eq!(judged(points, &solution), (i128::from(solution.d), [0; 3]), "{points:?}");
    solution
}

fn assert_in_range(solution: &Solution) {
    let log = |value: i64| (value.unsigned_abs() as f64).log2();
    assert!(solution.d >= 0 && log(solution.d) <= 47.4);
    assert!(log(solution.k) <= 44.5 && log(solution.s) <= 55.5 && log(solution.a) <= 58.4);
    for format in [Format::Paper, Format::Wide] {
        for stripe in 0..format.stripes() {
            let (numerator, denominator) = solution.middle(stripe, format);
            assert!(log(numerator) <= 60.8);
            if solution.is_plausible(format) {
                assert!(denominator >= solution.d && log(denominator) <= 49.0);
            }
        }
    }
}

#[test]
fn columns_of_a_homography_give_it_back() {
    // z = 3 + 8 v.
    let Solution { a, s, k, d } = assert_exact(&[(-10, -77), (-9, -69), (2, 19), (10, 83)]);
    assert!(d > 0 && a == 3 * d && s == 8 * d && k == 0);
    // z (1 + v/36) = 20 v, where that is a whole number.
    let Solution { a, s, k, d } = assert_exact(&[(-12, -360), (-6, -144), (0, 0), (12, 180)]);
    assert!(d > 0 && a == 0 && s == 20 * d && 36 * k == d);
}

//= reference/SPEC.md#homog
//= type=test
//# - **HOMOG-3** A homography MUST be refused (`Implausible`) unless `s > 0` and `|k| <= 1/2`.
//= reference/SPEC.md#homog
//= type=test
//# - **HOMOG-5** A pipeline whose arithmetic is not exact MUST treat a `|k|` within its declared error of 1/2 as on it.
#[test]
fn an_obliquity_of_one_half_is_plausible_and_no_more() {
    // z (1 + v/20) = 3 v: k is 10/20 for 20 stripes and 12/20 for 24.
    let points = [(-10, -60), (-4, -15), (0, 0), (5, 12), (10, 20)];
    let solution = assert_exact(&points);
    assert!(solution.is_plausible(Format::Paper) && !solution.is_plausible(Format::Wide));
    // The same from the other side.
    let mirrored: Vec<_> = points.iter().map(|&(v, z)| (-v, -z)).collect();
    let solution = assert_exact(&mirrored);
    assert!(solution.is_plausible(Format::Paper) && !solution.is_plausible(Format::Wide));
}

#[test]
fn a_mirrored_barcode_is_implausible() {
    assert!(!assert_exact(&[(-10, 80), (-9, 72), (9, -72), (10, -80)]).is_plausible(Format::Paper));
    // Columns that are the same on both sides have no width: S = 0 and D > 0.
    let even = assert_exact(&[(-10, 5), (-9, 3), (9, 3), (10, 5)]);
    assert!(even.d > 0 && even.s == 0 && !even.is_plausible(Format::Paper));
    assert!(!Normal::new().solve().is_plausible(Format::Paper));
}

#[test]
fn transitions_outside_the_domain_are_not_added() {
    let mut normal = Normal::new();
    let mut add = |edge, column| normal.add(&Crossing { edge, column });
    assert_eq!(add(12, 2048), Some(()));
    assert_eq!(add(-12, -2048), Some(()));
    assert_eq!(add(12, 0), None);
    assert_eq!((add(13, 0), add(-13, 0), add(-128, 0), add(127, 0)), (None, None, None, None));
    assert_eq!((add(0, 2049), add(0, -2049), add(0, i16::MIN)), (None, None, None));
    assert_eq!(normal, sums(&[(12, 2048), (-12, -2048)]));
}

#[test]
fn the_corners_of_the_domain_do_not_overflow() {
    let all = |column: &dyn Fn(i8) -> i16| (-12..=12).map(|v| (v, column(v))).collect::<Vec<_>>();
    for split in -13..=12 {
        for (left, right) in [(2048, -2048), (-2048, 2048), (2048, 2048), (0, 2048), (2048, 0)] {
            assert_in_range(&assert_exact(&all(&|v| if v <= split { left } else { right })));
            let inside = |v: i8| if v.abs() <= split.abs() { left } else { right };
            assert_in_range(&assert_exact(&all(&inside)));
        }
    }
}

/// A barcode of 20 stripes from pixel 1 to 638 of a line of 640 px, seen by a camera whose axis is at the line's end.
//= reference/SPEC.md#homog
//= type=test
//# - **HOMOG-4** The homography that a layer reports MUST be relative to the principal column, `a' = a + δ`, `s' = s +
//# δ k` with `δ` the ROI's middle minus `o_x`.
#[test]
fn a_reported_homography_is_relative_to_the_principal_column() {
    let hypothesis = Hypothesis { first_region: 1, last_region: 39, first_pixel: 1, last_pixel: 638 };
    let grid = Grid::new(&hypothesis).unwrap();
    let focal_length = crate::formats::FocalLength::from_num(320);
    let camera = Camera::new(640, Column::from_num(639), focal_length).unwrap();
    // Units of 1/4 px: z (1 + v/36) = 20 v, so s = 50 px, k = 10/36, and the middle is at 319.5 - 639 px.
    let solution = assert_exact(&[(-12, -360), (-6, -144), (0, 0), (12, 180)]);
    let homography = solution.reported(Format::Paper, &grid, &camera).unwrap();
    assert_eq!(homography.a, Column::from_num(-319.5));
    let k = 10.0 / 36.0;
    assert!((homography.k.to_num::<f64>() - k).abs() <= 2_f64.powi(-31));
    let bound = 2_f64.powi(-21) + 2_f64.powi(-31) + 319.5 * 2_f64.powi(-31);
    assert!((homography.s.to_num::<f64>() - (50.0 - 319.5 * k)).abs() <= bound);
}

/// Transitions in an order that an ROI's may have: guards and any of the edges between, columns from left to right.
fn layer() -> impl Strategy<Value = (Format, Vec<(i8, i16)>)> {
    let format = prop_oneof![Just(Format::Paper), Just(Format::Wide)];
    (format, any::<u32>(), prop::collection::vec(-2048_i16..=2048, 25)).prop_map(|(format, chosen, mut columns)| {
        columns.sort_unstable();
        let half = format.stripes().cast_signed() / 2;
        let points =
            (-half..=half).zip(columns).filter(|&(v, _)| v.abs() >= half - 3 || chosen >> (v + 12) & 1 == 1).collect();
        (format, points)
    })
}

proptest! {
    //= reference/SPEC.md#homog
    //= type=test
    //# - **HOMOG-1** The homography MUST be the one that minimises `Σ (a + s t - k t z - z)²` over its transitions.
    #[test]
    fn solutions_are_exact(points in prop::collection::btree_map(-12_i8..=12, -2048_i16..=2048, 0..=25)) {
        let points: Vec<_> = points.into_iter().collect();
        assert_in_range(&assert_exact(&points));
    }

    #[test]
    fn extreme_columns_do_not_overflow(signs in any::<u32>(), present in any::<u32>()) {
        let points: Vec<_> = (-12..=12_i8)
            .filter(|v| present >> (v + 12) & 1 == 1)
            .map(|v| (v, if signs >> (v + 12) & 1 == 1 { 2048 } else { -2048 }))
            .collect();
        assert_in_range(&assert_exact(&points));
    }

    #[test]
    fn a_plausible_homography_can_be_reported((format, points) in layer(), principal in 0_u16..640) {
        let solution = assert_exact(&points);
        prop_assert!(solution.d > 0);
        prop_assume!(solution.is_plausible(format));
        let hypothesis =
            Hypothesis { first_region: 1, last_region: 39, first_pixel: 1, last_pixel: 638 };
        let grid = Grid::new(&hypothesis).unwrap();
        let focal_length = crate::formats::FocalLength::from_num(320);
        let camera = Camera::new(640, Column::from_num(principal), focal_length).unwrap();
        let homography = solution.reported(format, &grid, &camera).unwrap();

        // The same in floating point, where 2^53 leaves 1e-12 of the numbers here.
        let half = f64::from(format.stripes()) / 2.0;
        let ratio = |numerator: i64| numerator as f64 / solution.d as f64;
        let shift = 319.5 - f64::from(principal);
        let k = half * ratio(solution.k);
        let s = half * ratio(solution.s) / 4.0 + shift * k;
        let a = ratio(solution.a) / 4.0 + shift;
        let close = |found: f64, expected: f64, bound: f64| (found - expected).abs() <= bound + 1e-10;
        prop_assert!(close(homography.a.to_num(), a, 2_f64.powi(-21)));
        prop_assert!(close(homography.k.to_num(), k, 2_f64.powi(-31)));
        let bound = 2_f64.powi(-21) + 2_f64.powi(-31) * (1.0 + shift.abs());
        prop_assert!(close(homography.s.to_num(), s, bound));
        prop_assert!(a.abs() < 1800.0 && s.abs() < 1800.0);
    }
}

/// `HOMOG-3`, bounds included; without a determinant there is no homography.
#[test]
fn a_homography_grows_and_is_not_too_oblique() {
    let plausible = |s, k, d| Solution { a: 0, s, k, d }.is_plausible(Format::Paper);
    // N |K| <= D with N = 20.
    assert!(plausible(1, 5, 100) && plausible(1, -5, 100) && plausible(1, 0, 1));
    assert!(!plausible(1, 5, 99) && !plausible(1, -5, 99) && !plausible(0, 0, 1) && !plausible(1, 0, 0));
}
