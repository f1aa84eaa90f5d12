//! Writing landmarks into a site file (SITE-9).

use super::SiteError;
use reference::grid::Codes;
use reference::landmark::Format;
use std::path::Path;
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, value};

/// A site file's text with landmarks of the default dimensions added behind those that it has; comments, order and
/// spelling of everything else stay (SITE-9).
//= reference/SPEC.md#site
//# - **SITE-9** Writing landmarks into a site file MUST keep its comments, order and spelling.
pub fn with_landmarks(text: &str, path: &Path, added: &[(Format, Codes)]) -> Result<String, SiteError> {
    let mut document: DocumentMut =
        text.parse().map_err(|error: toml_edit::TomlError| SiteError::whole_file(path, error.message()))?;
    let mut last = last_position(document.as_table());
    let entry = document.entry("landmark").or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new()));
    // `landmark = [{ ... }]` means the same and becomes `[[landmark]]`.
    if let Some(array) = entry.as_array() {
        let tables = array.iter().filter_map(|item| item.as_inline_table().cloned()).map(InlineTable::into_table);
        *entry = Item::ArrayOfTables(tables.collect());
    }
    let Some(tables) = entry.as_array_of_tables_mut() else {
        return Err(SiteError::whole_file(path, "landmark is not an array of tables"));
    };
    for (format, codes) in added {
        let mut table = Table::new();
        table.insert("codes", value([codes.x, codes.y, codes.theta].map(i64::from).into_iter().collect::<Array>()));
        table.insert("format", value(crate::certificate::format_name(*format)));
        last += 1;
        table.set_position(Some(last));
        tables.push(table);
    }
    // The library reads over a byte order mark.
    let mark = if text.starts_with('\u{feff}') { "\u{feff}" } else { "" };
    Ok(format!("{mark}{document}"))
}

/// The place of the last table in the file.
fn last_position(table: &Table) -> isize {
    let inner = table.iter().map(|(_, item)| match item {
        Item::Table(table) => last_position(table),
        Item::ArrayOfTables(tables) => tables.iter().map(last_position).max().unwrap_or(0),
        _ => 0,
    });
    inner.max().unwrap_or(0).max(table.position().unwrap_or(0))
}
