//! What is wrong with a site file, and where: one line with file, line and key (SITE-2).

use core::fmt;
use core::ops::Range;
use std::path::{Path, PathBuf};
use toml::de::{DeTable, DeValue};

/// What is wrong with a site file, in one line.
#[derive(Debug)]
pub struct SiteError {
    path: PathBuf,
    /// Counted from 1; none where the file as a whole is wrong.
    line: Option<usize>,
    /// Such as `wall[2].from_m`, tables of an array counted from 1; empty where there is no key.
    key: String,
    what: String,
}

impl SiteError {
    pub(crate) fn whole_file(path: &Path, what: &str) -> Self {
        Self { path: path.to_owned(), line: None, key: String::new(), what: what.to_owned() }
    }

    /// The line, counted from 1.
    #[must_use]
    pub fn line(&self) -> Option<usize> {
        self.line
    }

    /// The key, such as `wall[2].from_m`, tables of an array counted from 1.
    #[must_use]
    pub fn key(&self) -> &str {
        &self.key
    }
}

impl fmt::Display for SiteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let line = self.line.map_or(String::new(), |line| format!(":{line}"));
        let key = if self.key.is_empty() { String::new() } else { format!(": {}", self.key) };
        // Names and keys may have any character in them.
        let sentence = format!("{}{line}{key}: {}", self.path.display(), self.what);
        let words: Vec<&str> = sentence.split(|c: char| c.is_whitespace() || c.is_control()).collect();
        f.write_str(&words.join(" "))
    }
}

impl core::error::Error for SiteError {}

/// What is wrong and in which bytes of the file.
#[derive(Debug)]
pub(crate) struct Fault {
    span: Range<usize>,
    what: String,
}

impl Fault {
    pub(crate) fn new(span: Range<usize>, what: impl Into<String>) -> Self {
        Self { span, what: what.into() }
    }

    //= reference/SPEC.md#site
    //# - **SITE-2** Whatever is wrong with a site file MUST be reported in one line with the file, the line and, where
    //# there is one, the key.
    pub(crate) fn in_file(self, path: &Path, text: &str) -> SiteError {
        let before = text.bytes().take(self.span.start).filter(|&byte| byte == b'\n').count();
        let key = match DeTable::parse(text) {
            Ok(table) => key_in_table(table.get_ref(), self.span.start),
            Err(_) => bare_key(text.get(self.span.clone())),
        };
        SiteError { path: path.to_owned(), line: Some(before + 1), key, what: self.what }
    }
}

impl From<toml::de::Error> for Fault {
    fn from(error: toml::de::Error) -> Self {
        Self::new(error.span().unwrap_or(0..0), error.message())
    }
}

/// What is no TOML has no table to look in; if a key is at fault, such as one that stands twice, the fault is its name.
fn bare_key(text: Option<&str>) -> String {
    let name = |text: &&str| text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
    text.filter(name).unwrap_or_default().to_owned()
}

/// The key in a table whose name or value begins at or before `place` and ends after it; empty without one.
fn key_in_table(table: &DeTable<'_>, place: usize) -> String {
    for (name, value) in table {
        let inner = key_in_value(value.get_ref(), place);
        if !inner.is_empty() {
            let joint = if inner.starts_with('[') { "" } else { "." };
            return format!("{}{joint}{inner}", name.get_ref());
        }
        if name.span().contains(&place) || value.span().contains(&place) {
            return name.get_ref().to_string();
        }
    }
    String::new()
}

fn key_in_value(value: &DeValue<'_>, place: usize) -> String {
    match value {
        DeValue::Table(table) => key_in_table(table, place),
        DeValue::Array(items) => {
            let inside = |(i, item): (usize, &toml::Spanned<DeValue<'_>>)| {
                // Numbers in an array have no name of their own.
                let DeValue::Table(table) = item.get_ref() else { return None };
                let inner = key_in_table(table, place);
                if !inner.is_empty() {
                    return Some(format!("[{}].{inner}", i + 1));
                }
                item.span().contains(&place).then(|| format!("[{}]", i + 1))
            };
            items.iter().enumerate().find_map(inside).unwrap_or_default()
        }
        _ => String::new(),
    }
}
