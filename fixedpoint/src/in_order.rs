//! A bounded vector in order, without an allocator or an index.

use heapless::Vec;

/// Adds an item before the first that it is before; if the vector is full, what is last then is not in it any more.
pub fn insert<T, const N: usize>(items: &mut Vec<T, N, u8>, mut item: T, before: impl Fn(&T, &T) -> bool) {
    let mut found = false;
    for known in items.iter_mut() {
        // What is put out of its place is before all that follow, also those that equal it.
        found = found || before(&item, known);
        if found {
            core::mem::swap(&mut item, known);
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

    /// Found by a proof: an odd number of items before two equal ones once made these change places.
    #[test]
    fn equals_stay_in_order_when_one_comes_before_them() {
        let mut items = Vec::<(u8, u8), 3, u8>::new();
        for (came, item) in (0..).zip([2, 2, 1]) {
            insert(&mut items, (item, came), |one, other| one.0 < other.0);
        }
        assert_eq!(items, [(1, 2), (2, 0), (2, 1)]);
        // Of a full list the last one goes, not one that equals it.
        insert(&mut items, (0, 3), |one, other| one.0 < other.0);
        assert_eq!(items, [(0, 3), (1, 2), (2, 0)]);
    }
}
