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

#[test]
fn dependent_columns_have_no_solution() {
    let rows: [[i64; 3]; 3] = [[1 << 20, 1 << 20, 5], [1 << 20, 1 << 20, 5], [5, 5, 100]];
    let mut equations = Equations::<3>::scaled(|i, j| rows[i][j]);
    assert_eq!(equations.eliminate(0), Some(()));
    assert_eq!(equations.eliminate(1), None);
    assert_eq!(Equations::<3>::scaled(|_, _| 0).eliminate(0), None);
}
