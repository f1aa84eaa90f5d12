//! The covariance of a state, and what keeps it one.

use crate::binary::times;
use crate::covariance::PoseCovariance;

/// How many numbers a state has: x, y, heading, `e`, `g`.
pub const STATES: usize = 5;

/// How many of them move: x, y, heading.
pub const MOVING: usize = 3;

/// Fraction bits of the entries.
pub const COVARIANCE_BITS: u8 = 56;

/// `e` and `g` count in units of `2^-SHARE_UNIT_BITS`, so that all variances are of similar sizes.
pub const SHARE_UNIT_BITS: u8 = 6;

/// The largest variance, 16 m², 16 rad² or 2^-8.
pub const LARGEST: i64 = 1 << 60;

/// The covariance of x, y, the heading, `e` and `g`: metres, radians and 1/64, with [`COVARIANCE_BITS`].
///
/// Positive semidefinite: an operation rounds every entry, which adds a symmetric matrix of rounding errors to what it
/// should be; it then adds to the diagonal at least the sum of the errors' bounds in that row, so that errors and addition
/// together are diagonally dominant and make nothing negative (Gershgorin). What is added is below 2^-51 in an
/// operation, and nothing to a number that is known, whose row is 0 without rounding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StateCovariance {
    /// The upper triangle, row by row.
    entries: [i64; STATES * (STATES + 1) / 2],
}

/// Where the triangle holds an entry.
const fn place(i: usize, j: usize) -> usize {
    let (i, j) = if i < j { (i, j) } else { (j, i) };
    i * (2 * STATES - 1).saturating_sub(i) / 2 + j
}

impl StateCovariance {
    /// Of nothing but a pose: `e` and `g` are known.
    ///
    /// Errors: 3 units of 2^-48 are added to the variances, by which the given covariance may be rounded.
    #[must_use]
    pub fn of_pose(pose: &PoseCovariance) -> Self {
        const FINER: u8 = COVARIANCE_BITS - 48;
        let PoseCovariance { xx, xy, xt, yy, yt, tt } = *pose;
        let variance = |value: i64| value.max(0).saturating_add(3);
        let mut rows = [[variance(xx), xy, xt], [xy, variance(yy), yt], [xt, yt, variance(tt)]];
        for o in 0..MOVING {
            // Not representable before it is limited.
            while at(&rows, o, o) > LARGEST >> FINER {
                for i in 0..MOVING {
                    for (i, j) in [(o, i), (i, o)] {
                        if let Some(entry) = rows.get_mut(i).and_then(|row| row.get_mut(j)) {
                            *entry = entry.saturating_add(1) >> 1; // a covariance may be as large as its format
                        }
                    }
                }
                if let Some(entry) = rows.get_mut(o).and_then(|row| row.get_mut(o)) {
                    *entry += 3;
                }
            }
        }
        let mut covariance = Self::default();
        for i in 0..MOVING {
            for j in i..MOVING {
                covariance.set(i, j, at(&rows, i, j).clamp(-(LARGEST >> FINER), LARGEST >> FINER) << FINER);
            }
        }
        covariance
    }

    /// An entry.
    #[must_use]
    pub fn entry(&self, i: usize, j: usize) -> i64 {
        self.entries.get(place(i, j)).copied().unwrap_or_default()
    }

    /// Sets an entry and its mirror image.
    pub fn set(&mut self, i: usize, j: usize, value: i64) {
        if let Some(entry) = self.entries.get_mut(place(i, j)) {
            *entry = value;
        }
    }

    /// How many of the numbers, from the first, are not known: 3 or 5.
    #[must_use]
    pub fn uncertain(&self) -> usize {
        if self.entry(3, 3) == 0 && self.entry(4, 4) == 0 { MOVING } else { STATES }
    }

    /// That of the pose alone; error 2^-49.
    #[must_use]
    pub fn pose(&self) -> PoseCovariance {
        let coarse = |i: usize, j: usize| crate::ratio::dropped(self.entry(i, j), COVARIANCE_BITS - 48);
        PoseCovariance {
            xx: coarse(0, 0),
            xy: coarse(0, 1),
            xt: coarse(0, 2),
            yy: coarse(1, 1),
            yt: coarse(1, 2),
            tt: coarse(2, 2),
        }
    }

    /// `F P Fᵀ + G diag(w) Gᵀ` (`MOTION-5`), `transition` being what `F` has more than ones, by the heading, `e` and `g`.
    ///
    /// Errors: of an entry among x, y and the heading 7 units: 1.5 of `F P`, times at most 2.3 through `Fᵀ`, and 1.5 of its own,
    /// 0.9 of each wheel. Of one with `e` or `g` 1.5.
    //= reference/SPEC.md#motion
    //# - **MOTION-5** The covariance MUST become `F P Fᵀ + G diag(q |l|, q |r|) Gᵀ`, with the derivatives F by the
    //# state and G by `l` and `r` of what was moved.
    pub fn moved(&mut self, transition: &[[i32; 3]; MOVING], by_wheels: &[WheelNoise; 2]) {
        let uncertain = self.uncertain();
        // The heading itself, `e` and `g`; without the latter two nothing comes from them.
        let sources = uncertain - MOVING + 1;
        let mut product = [[0_i64; STATES]; MOVING]; // F P
        for ((i, row), by) in (0..).zip(&mut product).zip(transition) {
            for (j, entry) in row.iter_mut().enumerate().take(uncertain) {
                let more = by.iter().take(sources).enumerate().skip(usize::from(i == 2));
                *entry = more.fold(self.entry(i, j), |sum, (from, &factor)| {
                    sum.saturating_add(times(self.entry(from + 2, j), factor, 30))
                });
            }
        }
        for (i, row) in product.iter().enumerate() {
            for (j, by) in transition.iter().enumerate().skip(i) {
                let moved = by.iter().zip(row.iter().skip(2)).take(sources).skip(usize::from(j == 2));
                let sum = moved.fold(row.get(j).copied().unwrap_or_default(), |sum, (&factor, &entry)| {
                    sum.saturating_add(times(entry, factor, 30))
                });
                self.set(i, j, by_wheels.iter().fold(sum, |sum, wheel| sum.saturating_add(wheel.entry(i, j))));
            }
            for (j, &entry) in row.iter().enumerate().skip(MOVING) {
                self.set(i, j, entry);
            }
        }
        self.settle([24, 24, 24, 5, 5]);
    }

    /// Adds the rounding errors' bounds to the variances of what is uncertain, and limits them: a number of which the
    /// variance exceeds 16 m², 16 rad² or 2^-8 is taken to be half as uncertain.
    pub fn settle(&mut self, bounds: [i64; STATES]) {
        for (i, bound) in bounds.into_iter().enumerate().take(self.uncertain()) {
            let variance = self.entry(i, i);
            if i < MOVING || variance != 0 {
                self.set(i, i, variance.saturating_add(bound));
            }
        }
        for i in 0..STATES {
            while self.entry(i, i) > LARGEST {
                self.halve(i);
            }
        }
    }

    /// Row and column `o` by half, which keeps a covariance one; 3 units for the rounding.
    fn halve(&mut self, o: usize) {
        for i in 0..STATES {
            let entry = self.entry(i, o);
            let half = if i == o { (entry >> 2) + 3 } else { entry.saturating_add(1) >> 1 };
            self.set(i, o, half);
        }
    }
}

fn at(rows: &[[i64; MOVING]; MOVING], i: usize, j: usize) -> i64 {
    rows.get(i).and_then(|row| row.get(j)).copied().unwrap_or_default()
}

/// What the way of a wheel does to x, y and the heading, and its variance.
#[derive(Clone, Copy, Debug)]
pub struct WheelNoise {
    /// A column of `G`: 1, 1 and 1/m, 24 fraction bits.
    pub by: [i32; MOVING],
    /// m² with 62 fraction bits.
    pub variance: i64,
}

impl WheelNoise {
    /// The entry of `G w Gᵀ` with [`COVARIANCE_BITS`]; error half a unit, and `|G| <= 64` times 2^-7 units.
    #[must_use]
    pub fn entry(&self, i: usize, j: usize) -> i64 {
        let by = |i: usize| self.by.get(i).copied().unwrap_or_default();
        times(times(self.variance, by(i), 24), by(j), 30)
    }
}
