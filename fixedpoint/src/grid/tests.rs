use super::*;
use proptest::prelude::*;
use std::f64::consts::PI;

fn length(metres: f64) -> Length {
    Length::from_num(metres)
}

/// GRID-1, most significant first.
fn payload(format: Format, [x, y, heading]: [u32; 3]) -> u32 {
    match format {
        Format::Paper => (x << 10) | (y << 4) | heading,
        Format::Wide => (x << 14) | (y << 4) | heading,
    }
}

/// 3, 5 and 6 steps of the default grid: 0.15 m, 0.25 m and 6/16 of a turn.
//= reference/SPEC.md#grid
//= type=test
//# - **GRID-1** A pose's payload MUST be the codes of x, y and heading, in this order, most significant first, of 6, 6
//# and 4 bits in `paper` and 10, 10 and 4 bits in `wide`.
#[test]
fn codes_stand_in_the_order_of_the_specification() {
    for (format, word) in [(Format::Paper, 0b0000_1100_0101_0110), (Format::Wide, 0b0000_0000_1100_0000_0101_0110)] {
        let pose = Grid::default().landmark_in_world(format, word).unwrap();
        assert_eq!((pose.x, pose.y), (length(0.15), length(0.25)));
        assert_eq!(pose.theta, Angle::from_bits(3 << 29));
    }
}

#[test]
fn half_a_turn_is_pi_and_more_than_that_is_negative() {
    let heading = |code| Grid::default().landmark_in_world(Format::Paper, code).unwrap().theta;
    assert_eq!(heading(8), Angle::PI);
    assert_eq!(heading(12), Angle::from_bits(-(1 << 30)));
}

/// 12 headings of 30° each: a third of a turn is no binary fraction.
//= reference/SPEC.md#grid
//= type=test
//# - **GRID-3** The code `c` of the heading MUST stand for `c` equal parts of a turn, of which the grid has at most and
//# by default `2^bits`.
//= reference/SPEC.md#grid
//= type=test
//# - **GRID-6** A payload whose code of the heading is not below the number of headings MUST be refused (`Heading`).
#[test]
fn a_grid_has_as_many_headings_as_it_says() {
    let grid = Grid::new([Length::ZERO; 2], [GridStep::ONE; 2], 12).unwrap();
    let third = grid.landmark_in_world(Format::Paper, 4).unwrap().theta;
    assert_eq!(third, Angle::from_bits(1_431_655_765));
    assert!(grid.landmark_in_world(Format::Wide, 11).is_ok());
    assert_eq!(grid.landmark_in_world(Format::Wide, 12), Err(GridRefusal::Heading));
}

#[test]
fn grids_have_a_domain() {
    let grid = |step: [f64; 2], headings| Grid::new([Length::ZERO; 2], step.map(GridStep::from_num), headings);
    assert_eq!(grid([0.05, 0.05], 16), Ok(Grid::default()));
    assert_eq!(grid([0.05, 0.0], 16), Err(SpacingRefusal::Step));
    assert_eq!(grid([0.0, 0.05], 16), Err(SpacingRefusal::Step));
    assert_eq!(grid([0.05, 0.05], 0), Err(SpacingRefusal::Headings));
    assert_eq!(grid([0.05, 0.05], 17), Err(SpacingRefusal::Headings));
    assert!(grid([3.9, 1e-9], 1).is_ok());
}

#[test]
fn what_is_no_payload_or_too_far_away_is_refused() {
    let grid = Grid::new([length(100.0), length(-100.0)], [GridStep::ONE; 2], 16).unwrap();
    let at = |x, y| grid.landmark_in_world(Format::Wide, payload(Format::Wide, [x, y, 0]));
    assert_eq!(at(27, 227).map(|pose| (pose.x, pose.y)), Ok((length(127.0), length(127.0))));
    assert_eq!(at(28, 0), Err(GridRefusal::Beyond));
    assert_eq!(at(0, 228), Err(GridRefusal::Beyond));
    assert_eq!(grid.landmark_in_world(Format::Paper, 1 << 16), Err(GridRefusal::TooLarge));
    assert_eq!(grid.landmark_in_world(Format::Wide, 1 << 24), Err(GridRefusal::TooLarge));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    /// GRID-2 and GRID-3 in floating point, of grids as they are meant.
    //= reference/SPEC.md#grid
    //= type=test
    //# - **GRID-2** The code `c` of a coordinate MUST stand for the origin plus `c` steps, by default 50 mm from 0.
    #[test]
    fn a_thousand_steps_err_by_less_than_a_micrometre(
        origin in prop::array::uniform2(-20.0..20.0_f64),
        step in prop::array::uniform2(0.001..0.1_f64),
        headings in 1_u8..=16,
        codes in prop::array::uniform3(0_u32..1024),
        wide in any::<bool>(),
    ) {
        let (format, largest) = if wide { (Format::Wide, 1023) } else { (Format::Paper, 63) };
        let [x, y, heading] = codes;
        let codes = [x & largest, y & largest, heading % u32::from(headings)];
        let grid = Grid::new(origin.map(Length::from_num), step.map(GridStep::from_num), headings).unwrap();
        let pose = grid.landmark_in_world(format, payload(format, codes)).unwrap();
        for ((found, code), (origin, step)) in [pose.x, pose.y].into_iter().zip(codes).zip(origin.into_iter().zip(step)) {
            let exact = origin + f64::from(code) * step;
            prop_assert!((found.to_num::<f64>() - exact).abs() < 1e-6, "{found} {exact}");
        }
        let exact = 2.0 * PI * f64::from(codes[2]) / f64::from(headings);
        let found = f64::from(pose.theta.to_bits()) * PI / 2_f64.powi(31);
        let apart = (found - exact + PI).rem_euclid(2.0 * PI) - PI;
        prop_assert!(apart.abs() <= PI * 2_f64.powi(-32) * 1.001, "{found} {exact}");
    }
}
