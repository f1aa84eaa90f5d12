//! Numbers that a model checker chooses.

mod checker {
    #[link(wasm_import_module = "checker")]
    unsafe extern "C" {
        /// Any number.
        #[link_name = "any"]
        pub(super) safe fn any() -> u64;
        /// Goes on only if the number is not 0.
        #[link_name = "assume"]
        pub(super) safe fn assume(condition: u32);
        /// Asks whether the condition of a line can be other than 0.
        #[link_name = "cover"]
        pub(super) safe fn cover(line: u32, condition: u32);
        /// What must not happen.
        #[link_name = "fail"]
        pub(super) safe fn fail() -> !;
    }
}

/// Any number of so many bits, in the lowest ones.
pub(crate) fn bits(count: u32) -> u64 {
    checker::any() & (u64::MAX >> (64 - count))
}

/// Goes on only where a condition holds.
pub fn assume(condition: bool) {
    checker::assume(u32::from(condition));
}

/// As the macro of this name.
pub fn cover(line: u32, condition: bool) {
    checker::cover(line, u32::from(condition));
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    checker::fail()
}
