#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_possible_wrap)] // of numbers in range

use super::*;
use crate::formats::Obliquity;
use proptest::prelude::*;

proptest! {
    #[test]
    fn edges_lie_where_the_homography_says(
        a in -20.0..20.0_f64,
        s in 12.0..280.0_f64,
        k in -0.6..0.6_f64,
        wide in any::<bool>(),
    ) {
        let format = if wide { Format::Wide } else { Format::Paper };
        let homography = Homography { a: Column::from_num(a), s: Column::from_num(s), k: Obliquity::from_num(k) };
        let column = |t: f64| (a + s * t) / (1.0 + k * t);
        let n = f64::from(format.stripes());
        prop_assume!(s - a * k > 1.0 && column(1.0) < 640.0 && column(-1.0) > -640.0);
        let projection = Projection::new(&homography, format).unwrap();
        prop_assert_eq!(projection.edges().len(), usize::from(format.stripes()) + 1);
        let reach = 2_f64.powi(i32::from(projection.reach_bits));
        for (j, edge) in projection.edges().iter().enumerate() {
            let t = 2.0 * j as f64 / n - 1.0;
            let growth = 1.0 / (1.0 + k * t);
            prop_assert!((f64::from(edge.column) / 65_536.0 - column(t)).abs() < 2_f64.powi(-15), "{:?}", edge);
            let exact = [growth, t * growth, -column(t) * t * growth / reach];
            for (found, exact) in edge.motion.into_iter().zip(exact) {
                // Products of two rounded numbers for the last.
                prop_assert!((f64::from(found) / 4096.0 - exact).abs() < 6.0 / 4096.0, "{} {}", found, exact);
            }
            prop_assert!(growth <= 1.07 * f64::from(1 << projection.growth_bits));
        }
    }

    #[test]
    fn another_origin_is_the_same_homography(
        a in -200.0..200.0_f64, s in 12.0..280.0_f64, k in -0.6..0.6_f64, origin in -320.0..320.0_f64, t in -1.0..1.0_f64,
    ) {
        let homography = Homography { a: Column::from_num(a), s: Column::from_num(s), k: Obliquity::from_num(k) };
        let moved = shifted(&homography, Column::from_num(origin)).unwrap();
        let column = |homography: &Homography| {
            let [a, s, k] = [homography.a.to_num::<f64>(), homography.s.to_num(), homography.k.to_num()];
            (a + s * t) / (1.0 + k * t)
        };
        let origin = Column::from_num(origin).to_num::<f64>();
        prop_assert!((column(&homography) - column(&moved) - origin).abs() < 2e-6);
    }
}

#[test]
fn mirrored_and_too_oblique_homographies_have_no_edges() {
    let edges = |s: f64, k: f64| {
        let homography = Homography { a: Column::ZERO, s: Column::from_num(s), k: Obliquity::from_num(k) };
        Projection::new(&homography, Format::Paper)
    };
    assert!(edges(40.0, 0.7).is_some());
    assert_eq!(edges(-40.0, 0.0), None);
    assert_eq!(edges(40.0, 1.5), None);
}

/// Five units of 2^-20 px times an eighth are five eighths of one.
#[test]
fn a_shifted_scale_is_rounded_to_nearest() {
    let homography = Homography { a: Column::ZERO, s: Column::from_num(100), k: Obliquity::from_num(0.125) };
    let found = shifted(&homography, Column::from_bits(5)).map(|homography| homography.s.to_bits());
    assert_eq!(found, Some((100 << 20) - 1));
}
