//! `index.html`: self-contained, without scripts, light and dark, for a screen and for paper.

use crate::parts::{PARTS, Part};
use crate::record::{Outcome, Record, Taken};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use pulldown_cmark::{Options, Parser};
use std::path::Path;
use std::{fs, io};

/// The claims, from the tree's root.
const CLAIMS: &str = "verify/CLAIMS.md";

const STYLE: &str = include_str!("page.css");

/// Writes the page into the folder that the record is of.
pub(crate) fn write(folder: &Path, record: &Record) -> io::Result<()> {
    let claims = fs::read_to_string(CLAIMS)
        .map_err(|error| io::Error::new(error.kind(), format!("{CLAIMS}: {error}; run it at the tree's root")))?;
    fs::write(folder.join("index.html"), page(folder, record, &claims).into_string())
}

fn page(folder: &Path, record: &Record, claims: &str) -> Markup {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "barloc: evidence" }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    h1 { "barloc: evidence that the port is the same" }
                    p { "Commit " code { (record.commit) } }
                    (overview(record))
                }
                section #claims { (PreEscaped(rendered(claims))) }
                @for part in PARTS { (section(folder, part, record)) }
                section #tools { h2 { "Tools" } table { tbody {
                    @for (name, version) in &record.versions { tr { td { (name) } td { (version) } } }
                } } }
            }
        }
    }
}

/// Each part and what became of it.
fn overview(record: &Record) -> Markup {
    html! {
        div.wide { table {
            thead { tr { th { "part" } th { "result" } th { "time" } } }
            tbody {
                tr { td { a href="#claims" { "Claims" } } td { "what is claimed, and what is not" } td {} }
                @for part in PARTS {
                    @let taken = record.of(part.name);
                    tr {
                        td { a href={ "#" (part.name) } { (part.title) } }
                        (result(taken, record))
                        td.number { @if let Some(taken) = taken { (taken.seconds) " s" } }
                    }
                }
            }
        } }
    }
}

fn result(taken: Option<&Taken>, record: &Record) -> Markup {
    match taken {
        None => html! { td.missing { "not run" } },
        Some(taken) if taken.commit != record.commit => {
            html! { td.missing { "not run at this commit; at " code { (taken.commit) } ": " (word(taken)) } }
        }
        Some(taken) => {
            html! { td.bad[taken.outcome == Outcome::Failed] .missing[taken.outcome == Outcome::NotRun] { (word(taken)) } }
        }
    }
}

fn word(taken: &Taken) -> String {
    match taken.outcome {
        Outcome::Held => "holds".to_owned(),
        Outcome::Failed => format!("FAILED: {}", taken.last_line),
        Outcome::NotRun => format!("could not run here: {}", taken.last_line),
    }
}

fn section(folder: &Path, part: &Part, record: &Record) -> Markup {
    let own = folder.join(part.name);
    let taken = record.of(part.name);
    html! {
        section id=(part.name) {
            h2 { (part.title) }
            p { (part.shows) }
            @if let Some(taken) = taken {
                pre { code { (taken.command) } }
                table { tbody { tr { (result(Some(taken), record)) td { (taken.seconds) " s" } td { code { (taken.last_line) } } } } }
                @if taken.outcome != Outcome::NotRun {
                    @for table in part.tables { (table.draw(&own)) }
                    p { "Files: " a href={ (part.name) "/log.txt" } { "log" }
                        @for (file, what) in part.files { @if own.join(file).exists() {
                            ", " a href={ (part.name) "/" (file) } { (what) }
                        } }
                    }
                }
            } @else {
                p.missing { "Not run." }
            }
        }
    }
}

/// Markdown as HTML.
fn rendered(markdown: &str) -> String {
    let mut text = String::new();
    pulldown_cmark::html::push_html(&mut text, Parser::new_ext(markdown, Options::ENABLE_TABLES));
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn taken(commit: &str, outcome: Outcome) -> Taken {
        let last_line = "a last line <".to_owned();
        Taken { outcome, command: "true".to_owned(), commit: commit.to_owned(), seconds: 7, last_line }
    }

    fn drawn(set: impl Fn(&mut Record)) -> String {
        let mut record = Record::default();
        record.commit = "c0ffee".to_owned();
        set(&mut record);
        page(Path::new("no-such-folder"), &record, "# Claims\n\n- one").into_string()
    }

    #[test]
    fn what_did_not_run_is_said_so() {
        let nothing = drawn(|_| {});
        assert_eq!(nothing.matches("<p class=\"missing\">Not run.</p>").count(), PARTS.len());
        let some = drawn(|record| record.keep("self-test", taken("c0ffee", Outcome::NotRun)));
        assert!(some.contains("could not run here: a last line &lt;"));
        let old = drawn(|record| record.keep("self-test", taken("older", Outcome::Held)));
        assert!(old.contains("not run at this commit; at <code>older</code>"));
        let failed = drawn(|record| record.keep("self-test", taken("c0ffee", Outcome::Failed)));
        assert!(failed.contains("FAILED: a last line"));
    }

    #[test]
    fn the_page_needs_nothing_else() {
        let page = drawn(|record| record.keep("certificate", taken("c0ffee", Outcome::Held)));
        assert!(page.contains("<h1>Claims</h1>") && page.contains("<li>one</li>"));
        assert!(!page.contains("<script") && !page.contains("http://") && !page.contains("https://"));
        assert!(page.contains("certificate.json cannot be read"));
    }
}
