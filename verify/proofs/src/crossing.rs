//! An ROI's own columns.

use fixedpoint::crossing::Grid;
use fixedpoint::hypotheses::Hypothesis;

fn any_hypothesis() -> Hypothesis {
    let (first_pixel, last_pixel): (u16, u16) = (kani::any(), kani::any());
    kani::assume(first_pixel <= last_pixel);
    Hypothesis { first_region: 1, last_region: 1, first_pixel, last_pixel }
}

/// A grid is as fine as CROSS-1 says, and no ROI of a camera is too wide for one.
///
/// - Domain: all ROIs of lines of up to 65,536 pixels.
/// - Fault: `crossing.rs`: `(hypothesis.extent() + 1) << bits <= 4096` → `hypothesis.extent() << bits <= 4096`: the
///   pixels beside the ROI are forgotten.
#[kani::proof]
#[kani::unwind(10)]
fn grids_are_as_fine_as_they_can_be() {
    let hypothesis = any_hypothesis();
    let wide = hypothesis.extent() + 1;
    let found = Grid::new(&hypothesis);
    kani::cover!(found.is_none());
    if let Some(grid) = found {
        let bits = grid.subpixel_bits();
        assert!((1..=8).contains(&bits) && wide << bits <= 4096);
        assert!(bits == 8 || wide << (bits + 1) > 4096);
    } else {
        assert!(hypothesis.extent() > 2047);
    }
}

/// The boundaries of an ROI's pixels, and of the one beyond either end, lie on the grid, exactly where they are.
///
/// - Domain: all ROIs of up to 2047 pixels, any pixel.
/// - Fault: `crossing.rs`: `self.on_grid(2 * i32::from(pixel) - 1, 0)` → `self.on_grid(2 * i32::from(pixel) + 1, 0)`:
///   the right boundary.
#[kani::proof]
#[kani::unwind(10)]
fn boundaries_are_exact() {
    let hypothesis = any_hypothesis();
    let pixel: u16 = kani::any();
    let Some(grid) = Grid::new(&hypothesis) else { return };
    let [first, last, place] = [hypothesis.first_pixel, hypothesis.last_pixel, pixel].map(i32::from);
    let twice = (2 * place - 1 - (first + last)) << grid.subpixel_bits();
    let boundary = grid.left_boundary(pixel);
    kani::cover!(boundary == Some(-2048));
    assert_eq!(boundary.map(|boundary| 2 * i32::from(boundary)), (twice.abs() <= 4096).then_some(twice));
    assert!(boundary.is_some() || place < first || place > last + 1);
}
