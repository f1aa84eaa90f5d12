//! Tables of the page, made of the JSON that a part wrote.

use maud::{Markup, html};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Objects in a file, a row for each.
pub(crate) struct Table {
    pub(crate) caption: &'static str,
    /// In the part's folder.
    pub(crate) file: &'static str,
    /// JSON pointer of the array of objects, of one object by itself, or of objects by name.
    pub(crate) rows: &'static str,
    /// Heading of each column, and the JSON pointer in an object, without its first `/`; [`NAME`] is an object's name.
    pub(crate) columns: &'static [(&'static str, &'static str)],
}

/// The column of an object's name where objects have names.
pub(crate) const NAME: &str = "";

impl Table {
    /// The table, or a sentence that says why it is not there.
    pub(crate) fn draw(&self, folder: &Path) -> Markup {
        match self.read(folder) {
            Ok(rows) => html! {
                div.wide { table {
                    caption { (self.caption) }
                    thead { tr { @for (heading, _) in self.columns { th { (heading) } } } }
                    tbody { @for row in &rows { (self.row(row)) } }
                } }
            },
            Err(why) => html! { p.missing { (self.caption) ": " (why) } },
        }
    }

    fn read(&self, folder: &Path) -> Result<Vec<Value>, String> {
        let file = self.file;
        let bytes = fs::read(folder.join(file)).map_err(|error| format!("{file} cannot be read: {error}"))?;
        let whole: Value = serde_json::from_slice(&bytes).map_err(|error| format!("{file} is no JSON: {error}"))?;
        match whole.pointer(self.rows) {
            Some(Value::Array(rows)) => Ok(rows.clone()),
            Some(Value::Object(one)) if self.columns.iter().all(|(_, key)| *key != NAME) => {
                Ok(vec![Value::Object(one.clone())])
            }
            Some(Value::Object(rows)) => Ok(rows.iter().filter_map(|(name, row)| named(name, row)).collect()),
            _ => Err(format!("{file} has nothing at {}", self.rows)),
        }
    }

    fn row(&self, row: &Value) -> Markup {
        html! {
            tr { @for (_, key) in self.columns {
                @let value = row.pointer(&format!("/{key}")).unwrap_or(&Value::Null);
                td.number[value.is_number()] .bad[is_bad(value)] { (breakable(&shown(value))) }
            } }
        }
    }
}

/// An object with its own name in it.
fn named(name: &str, row: &Value) -> Option<Value> {
    let mut row = row.as_object()?.clone();
    row.insert(NAME.to_owned(), Value::String(name.to_owned()));
    Some(Value::Object(row))
}

/// Names and paths with places where a line may break: they are longer than a column.
fn breakable(text: &str) -> Markup {
    html! { @for piece in text.split_inclusive(['_', '/']) { (piece) wbr; } }
}

/// A word that a reader should not miss.
fn is_bad(value: &Value) -> bool {
    matches!(value.as_str(), Some("fail" | "fails" | "failed" | "FAIL"))
}

/// A value as text: three or four digits are enough on a page.
fn shown(value: &Value) -> String {
    match value {
        Value::Null => "–".to_owned(),
        Value::String(text) => text.clone(),
        Value::Bool(yes) => if *yes { "yes" } else { "no" }.to_owned(),
        Value::Number(number) => match number.as_f64() {
            Some(float) if number.is_f64() => rounded(float),
            _ => number.to_string(),
        },
        Value::Array(items) if items.is_empty() => "none".to_owned(),
        Value::Array(items) if items.iter().all(Value::is_object) => items.len().to_string(), // a list of its own
        Value::Array(items) => items.iter().map(shown).collect::<Vec<_>>().join(", "),
        Value::Object(_) => value.to_string(),
    }
}

fn rounded(float: f64) -> String {
    let magnitude = float.abs();
    if float == 0.0 {
        "0".to_owned()
    } else if (100.0..1e6).contains(&magnitude) {
        format!("{float:.0}")
    } else if (0.01..100.0).contains(&magnitude) {
        let digits = if magnitude < 1.0 { 3 } else { 1 };
        format!("{float:.digits$}")
    } else {
        format!("{float:.2e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn numbers_are_short_and_nothing_is_lost_of_words() {
        let values = [
            json!(0.0),
            json!(1.5e-7),
            json!(0.123_456),
            json!(1_039_630),
            json!("pass"),
            json!(null),
            json!([1, "a"]),
            json!([1166.24, 6.25]),
            json!([]),
        ];
        let texts: Vec<String> = values.iter().map(shown).collect();
        assert_eq!(texts, ["0", "1.50e-7", "0.123", "1039630", "pass", "–", "1, a", "1166, 6.2", "none"]);
    }

    #[test]
    fn a_missing_file_or_list_is_said_so() {
        let table = Table { caption: "Proofs", file: "none.json", rows: "/proofs", columns: &[("proof", "name")] };
        let folder = std::env::temp_dir().join(format!("barloc-table-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        assert!(table.draw(&folder).into_string().contains("none.json cannot be read"));
        fs::write(folder.join("none.json"), "{}").unwrap();
        assert!(table.draw(&folder).into_string().contains("has nothing at /proofs"));
        fs::write(folder.join("none.json"), r#"{"proofs": [{"name": "a < b"}, {"name": "failed"}]}"#).unwrap();
        let drawn = table.draw(&folder).into_string();
        fs::remove_dir_all(&folder).unwrap();
        assert!(drawn.contains("a &lt; b") && drawn.contains("bad"), "{drawn}");
    }

    #[test]
    fn objects_have_rows_by_themselves_or_by_their_names() {
        let folder = std::env::temp_dir().join(format!("barloc-objects-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("some.json"), r#"{"a.rs": {"lines": {"all": 7}, "missed": [{}, {}]}}"#).unwrap();
        let rows = |rows, columns| Table { caption: "", file: "some.json", rows, columns }.draw(&folder).into_string();
        let named = rows("", &[("file", NAME), ("lines", "lines/all"), ("missed", "missed")]);
        let alone = rows("/a.rs", &[("lines", "lines/all")]);
        fs::remove_dir_all(&folder).unwrap();
        let cells = |drawn: &str| drawn.matches("<td").count();
        assert!(named.contains(">a.rs<") && named.contains(">7<") && named.contains(">2<"), "{named}");
        assert_eq!((cells(&named), cells(&alone)), (3, 1));
        assert!(alone.contains(">7<"), "{alone}");
    }
}
