#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_possible_wrap)] // of numbers in range

use super::*;
use proptest::prelude::*;

/// Normal equations of `rows` in four unknowns: products of the columns, the right side last.
fn matrix(rows: &[[f64; 5]], scales: [f64; 5]) -> [[f64; 5]; 5] {
    core::array::from_fn(|i| {
        core::array::from_fn(|j| rows.iter().map(|row| (row[i] * scales[i] * row[j] * scales[j]).round()).sum())
    })
}

/// The solution of the first four columns for the right side `column`, by Gauss and Jordan.
fn solved(matrix: &[[f64; 5]; 5], right: [f64; 4]) -> [f64; 4] {
    let mut rows: [[f64; 5]; 4] =
        core::array::from_fn(|i| core::array::from_fn(|j| if j == 4 { right[i] } else { matrix[i][j] }));
    for pivot in 0..4 {
        let scale = rows[pivot][pivot];
        rows[pivot] = rows[pivot].map(|value| value / scale);
        for i in (0..4).filter(|&i| i != pivot) {
            let factor = rows[i][pivot];
            rows[i] = core::array::from_fn(|j| rows[i][j] - factor * rows[pivot][j]);
        }
    }
    rows.map(|row| row[4])
}

proptest! {
    #[test]
    fn equations_are_solved_and_inverted(
        rows in prop::collection::vec(prop::array::uniform5(-1.0..1.0_f64), 12),
        scales in prop::array::uniform5(6.0..20.0_f64),
    ) {
        let matrix = matrix(&rows, scales.map(f64::exp2));
        let mut equations = Equations::<5>::scaled(|i, j| matrix[i][j] as i64);
        for pivot in 0..4 {
            prop_assert!(equations.eliminate(pivot).is_some());
        }
        let mut solution = [0; 5];
        (0..4).rev().for_each(|pivot| equations.substitute(pivot, &mut solution));
        let exact = solved(&matrix, core::array::from_fn(|i| matrix[i][4]));
        for i in 0..4 {
            // In units of the scaled columns.
            let unit = 2_f64.powi(equations.exponents[4] - equations.exponents[i]);
            let found = solution[i] as f64 / 2_f64.powi(24);
            prop_assert!((found - exact[i] / unit).abs() < 1e-4, "{} {}", found, exact[i] / unit);
            let mut one = [0.0; 4];
            one[i] = 1.0;
            let column = solved(&matrix, one);
            for j in 0..4 {
                let found = equations.inverse(i, j, 4) as f64 * 2_f64.powi(-50 - equations.exponents[i] - equations.exponents[j]);
                let size = (column[i].abs() * solved(&matrix, core::array::from_fn(|n| f64::from(u8::from(n == j))))[j].abs()).sqrt();
                prop_assert!((found - column[j]).abs() < 1e-4 * size, "{} {}", found, column[j]);
            }
        }
    }
}

proptest! {
    /// Half a unit of the entry, half a unit of its factor, `2^-shift`, and 2^-27 of what is subtracted.
    #[test]
    fn an_eliminated_pivot_leaves_what_it_does_not_explain(
        pivot in 1 << 28..1_i64 << 30,
        others in prop::array::uniform2(-(1_i64 << 30)..1 << 30),
        rest in prop::array::uniform3(-(1_i64 << 29)..1 << 29),
    ) {
        let mut equations = Equations::<3>::empty();
        let [by, right] = others.map(|other| other >> 1);
        equations.rows = [[pivot, by, right], [0, rest[0], rest[1]], [0, 0, rest[2]]].map(|row| row.map(|m| m as i32));
        prop_assert!(equations.eliminate(0).is_some());
        for ((i, j), before, subtracted) in
            [((1, 1), rest[0], by * by), ((1, 2), rest[1], by * right), ((2, 2), rest[2], right * right)]
        {
            let factor = [by, right][j - 1].abs() as f64 / 2_f64.powi(i32::from(equations.shifts[0]));
            let subtracted = subtracted as f64 / pivot as f64;
            let exact = (before as f64 - subtracted).clamp(-(2_f64.powi(30)), 2_f64.powi(30));
            let error = f64::from(equations.entry(i, j)) - exact;
            prop_assert!(error.abs() <= 0.5 + 0.5 * factor + subtracted.abs() * 2_f64.powi(-27), "{}", error);
        }
    }
}

#[test]
fn products_with_factors_are_rounded_to_nearest() {
    let mut equations = Equations::<2>::empty();
    (equations.rows[0][1], equations.shifts[0]) = (5, 3);
    assert_eq!([-1, 1, 3].map(|value| equations.times_factor(0, 1, value)), [-1, 1, 2]);
}

#[test]
fn dependent_columns_have_no_solution() {
    let rows: [[i64; 3]; 3] = [[1 << 20, 1 << 20, 5], [1 << 20, 1 << 20, 5], [5, 5, 100]];
    let mut equations = Equations::<3>::scaled(|i, j| rows[i][j]);
    assert_eq!(equations.eliminate(0), Some(()));
    assert_eq!(equations.eliminate(1), None);
    assert_eq!(Equations::<3>::scaled(|_, _| 0).eliminate(0), None);
}

/// The second pivot is what its column has more than the first one; errors are of some units, of which 2^12 are too few.
#[test]
fn nearly_dependent_columns_have_no_solution() {
    let second = |more: i64| {
        let rows = [[1 << 29, 1 << 29, 5], [1 << 29, (1 << 29) + more, 5], [5, 5, 1 << 29]];
        let mut equations = Equations::<3>::scaled(|i, j| rows[i][j]);
        equations.eliminate(0).and_then(|()| equations.eliminate(1))
    };
    assert_eq!((second(1 << 11), second(1 << 13)), (None, Some(())));
}
