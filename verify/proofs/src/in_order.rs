//! The bounded list in order, which the timeline's queues are.

use fixedpoint::in_order::insert;
use heapless::Vec;

/// A list of up to `N` items in order, each with a mark that the order does not look at.
fn any_list<const N: usize>() -> Vec<(u8, u8), N, u8> {
    let items: [(u8, u8); N] = core::array::from_fn(|_| (kani::any(), kani::any()));
    let count: u8 = kani::any();
    kani::assume(usize::from(count) <= N);
    let mut list = Vec::new();
    for (i, item) in items.into_iter().enumerate() {
        if i < usize::from(count) {
            kani::assume(list.last().is_none_or(|last: &(u8, u8)| last.0 <= item.0));
            list.push(item).ok();
        }
    }
    list
}

fn add<const N: usize>(list: &mut Vec<(u8, u8), N, u8>, item: (u8, u8)) {
    insert(list, item, |one, other| one.0 < other.0);
}

/// A list in order is in order with one item more, and as long as it can be.
///
/// - Domain: up to 4 items of 4.
/// - Fault: `in_order.rs`: `core::mem::swap(&mut item, known);` → `core::mem::swap(&mut item, known); return;`: what
///   stood there is lost.
#[kani::proof]
#[kani::unwind(6)]
fn a_list_stays_in_order() {
    let mut list = any_list::<4>();
    let before = list.len();
    add(&mut list, (kani::any(), kani::any()));
    kani::cover!(before == 4);
    assert_eq!(list.len(), (before + 1).min(4));
    assert!(list.windows(2).all(|pair| pair[0].0 <= pair[1].0));
}

/// A list keeps what it had and what is added, each item as often as before; of a full one the last item goes.
///
/// - Domain: up to 4 items of 4, any item counted.
/// - Fault: `in_order.rs`: `found = found || before(&item, known);` → `found = before(&item, known);`: of equals the
///   wrong one goes.
#[kani::proof]
#[kani::unwind(6)]
fn a_list_keeps_its_items() {
    let mut list = any_list::<4>();
    let item = (kani::any(), kani::any());
    let before = list.clone();
    add(&mut list, item);
    let any = (kani::any(), kani::any());
    let count = |list: &[(u8, u8)]| list.iter().filter(|&&known| known == any).count();
    let mut expected = count(&before) + usize::from(item == any);
    if before.is_full() {
        let last = before[3];
        let gone = if item.0 < last.0 { last } else { item };
        expected -= usize::from(gone == any);
    }
    kani::cover!(before.is_full() && expected == 4);
    assert_eq!(count(&list), expected);
}

/// Equal items stay in the order in which they came.
///
/// - Domain: up to 3 items of 4, marked by their place.
/// - Fault: `in_order.rs`: `found = found || before(&item, known);` → `found = found || !before(known, &item);`: the
///   later one comes first.
#[kani::proof]
#[kani::unwind(6)]
fn equal_items_stay_in_order() {
    let mut list = Vec::<(u8, u8), 4, u8>::new();
    let count: u8 = kani::any();
    kani::assume(count <= 4);
    for came in 0..4 {
        if came < count {
            add(&mut list, (kani::any(), came));
        }
    }
    kani::cover!(list.len() == 4 && list[0].0 == list[3].0);
    assert!(list.windows(2).all(|pair| pair[0] < pair[1]));
}
