//! A bounded vector in order, without an allocator or an index.

use heapless::Vec;

/// Adds an item before the first that it is before; if the vector is full, what is last then is not in it any more.
pub(crate) fn insert<T, const N: usize>(items: &mut Vec<T, N, u8>, mut item: T, before: impl Fn(&T, &T) -> bool) {
    for known in items.iter_mut() {
        if before(&item, known) {
            core::mem::swap(&mut item, known); // which is before all that follow
        }
    }
    items.push(item).ok();
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pairs by their first numbers; of equal ones the second number says which came first.
    #[test]
    fn equals_stay_in_the_order_in_which_they_came() {
        let mut items = Vec::<(u8, u8), 8, u8>::new();
        for (came, item) in (0..).zip([3, 1, 2, 3, 1, 1]) {
            insert(&mut items, (item, came), |one, other| one.0 < other.0);
        }
        assert_eq!(items, [(1, 1), (1, 4), (1, 5), (2, 2), (3, 0), (3, 3)]);
    }
}
