//! A list of landmarks to print.

use super::{MARK, with_carriage_returns};
use crate::memory;
use crate::replay::is_a_sentence;
use verify::print::sheet::{Entry, SheetError, Wish, entries};

/// What reading a list may take beside 64 bytes for each of its own, the csv reader's buffers.
const MOST: usize = 1 << 20;

pub(super) fn run(text: &[u8]) {
    let Ok(list) = read(text) else { return };
    assert!(!list.is_empty(), "a list without entries is refused");
    assert!(list.windows(2).all(|pair| pair[0].line < pair[1].line), "lines in their order");
    if !text.starts_with(MARK) {
        assert_eq!(read(&[MARK, text].concat()).ok().as_ref(), Some(&list), "a byte order mark");
    }
    // Within quotes a line end is a part of a field.
    if let Some(text) = with_carriage_returns(text).filter(|text| !text.contains(&b'"')) {
        assert_eq!(read(&text).ok().as_ref(), Some(&list), "line ends of CR LF");
    }
    let wishes = |list: &[Entry]| list.iter().map(|entry| entry.wish).collect::<Vec<_>>();
    let again = read(written(&list).as_bytes()).expect("what was written");
    assert_eq!(wishes(&again), wishes(&list), "written and read again");
}

fn read(text: &[u8]) -> Result<Vec<Entry>, SheetError> {
    let list = memory::at_most(MOST + 64 * text.len(), || entries(text));
    if let Err(refusal) = &list {
        is_a_sentence(&refusal.to_string());
    }
    list
}

/// The list as this program would write it; all entries are of one kind.
fn written(list: &[Entry]) -> String {
    let row = |entry: &Entry| match entry.wish {
        Wish::Pose([x, y, theta]) => format!("{x:?},{y:?},{theta:?}\n"),
        Wish::Id(id) => format!("{id:#x}\n"),
    };
    let header = if matches!(list[0].wish, Wish::Id(_)) { "id\n" } else { "x_m,y_m,theta_deg\n" };
    header.to_owned() + &list.iter().map(row).collect::<String>()
}
