//! How much a reader may allocate.

use cap::Cap;
use std::alloc::System;

/// The allocator of whatever is built with this crate.
#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

/// What `read` gives, if it never holds more than `most` bytes beyond what was held before; otherwise the process ends.
///
/// Other threads must not allocate meanwhile: their memory would count.
///
/// # Panics
/// Never: a limit can always be lifted.
pub fn at_most<T>(most: usize, read: impl FnOnce() -> T) -> T {
    // Another thread may have asked for more in between: then there is no bound this time.
    let limited = ALLOCATOR.set_limit(ALLOCATOR.allocated().saturating_add(most));
    let result = read();
    if limited.is_ok() {
        let unlimited = ALLOCATOR.set_limit(usize::MAX);
        assert!(unlimited.is_ok(), "a limit can always be lifted");
    }
    result
}
