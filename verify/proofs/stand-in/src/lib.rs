//! What barloc's proofs use of `kani`, where Kani is not.
//!
//! On wasm32 a symbolic number, an assumption and a failure are imported functions, which a model checker knows. Elsewhere
//! numbers are drawn from a generator, and a proof is run again and again: no proof, but a test of what would be proved.
#![cfg_attr(target_arch = "wasm32", no_std)]

#[cfg(not(target_arch = "wasm32"))]
mod sampled;
#[cfg(target_arch = "wasm32")]
mod symbolic;

pub use kani_macros::{proof, solver, unwind};
#[cfg(not(target_arch = "wasm32"))]
pub use sampled::{assume, cover, sample};
#[cfg(target_arch = "wasm32")]
pub use symbolic::{assume, cover};

#[cfg(not(target_arch = "wasm32"))]
use sampled::bits;
#[cfg(target_arch = "wasm32")]
use symbolic::bits;

/// What can be symbolic.
pub trait Arbitrary {
    /// Any value of the type.
    fn any() -> Self;
}

/// Any value of a type.
#[must_use]
pub fn any<T: Arbitrary>() -> T {
    T::any()
}

/// Any value of a type that fulfils a condition.
pub fn any_where<T: Arbitrary>(condition: impl FnOnce(&T) -> bool) -> T {
    let value = T::any();
    assume(condition(&value));
    value
}

macro_rules! integers {
    ($($integer:ty),*) => {
        $(impl Arbitrary for $integer {
            #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_lossless)]
            fn any() -> Self {
                bits(<$integer>::BITS) as Self
            }
        })*
    };
}
integers!(u8, u16, u32, u64, i8, i16, i32, i64);

impl Arbitrary for bool {
    fn any() -> Self {
        bits(1) == 1
    }
}

impl<T: Arbitrary, const N: usize> Arbitrary for [T; N] {
    fn any() -> Self {
        core::array::from_fn(|_| T::any())
    }
}

/// Asks whether a condition can be fulfilled where it stands; a proof of which it cannot says less than it seems to.
#[macro_export]
macro_rules! cover {
    ($condition:expr $(, $what:literal)?) => {
        $crate::cover(line!(), $condition)
    };
}
