//! The claims in the tree: each function that proves or sweeps something, with what its documentation says.

use std::fs;
use std::path::{Path, PathBuf};
use syn::{Attribute, Expr, ExprLit, Item, ItemFn, Lit, Meta};

/// How a claim is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// By the model checker.
    Proof,
    /// By trying everything.
    Sweep,
    /// By Gappa, of a formula's rounding errors.
    Rounding,
}

/// What is put into the port to see that a claim can fail.
#[derive(Clone, Debug)]
pub(crate) struct Fault {
    /// The file, below `fixedpoint/src`.
    pub(crate) file: String,
    /// What stands there, once.
    pub(crate) from: String,
    /// What shall stand there instead.
    pub(crate) to: String,
    /// What is wrong then.
    pub(crate) what: String,
}

/// A proof or a sweep.
#[derive(Clone, Debug)]
pub(crate) struct Claim {
    pub(crate) kind: Kind,
    /// The function.
    pub(crate) name: String,
    /// Its file, below the proofs' sources.
    pub(crate) file: String,
    pub(crate) says: String,
    pub(crate) domain: String,
    pub(crate) fault: Fault,
    /// How often loops are unwound.
    pub(crate) unwind: u32,
    pub(crate) solver: String,
    /// Whether the checker takes each byte of memory for a variable of its own: where most addresses are constants.
    pub(crate) cells: bool,
    /// Bytes of the stack.
    pub(crate) stack: u32,
    /// CPU seconds after which a run has failed.
    pub(crate) seconds: u32,
    /// The lines of its file that ask for a cover.
    pub(crate) covers: Vec<usize>,
}

/// The sources of the proofs.
fn sources() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../src")
}

/// All proofs, and then all sweeps, by file and place.
pub(crate) fn claims() -> Result<Vec<Claim>, String> {
    let mut claims = Vec::new();
    for (folder, kind) in [(sources(), Kind::Proof), (sources().join("sweep"), Kind::Sweep)] {
        let entries = fs::read_dir(&folder).map_err(|why| format!("{}: {why}", folder.display()))?;
        let mut files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
        files.retain(|path| path.extension().is_some_and(|extension| extension == "rs"));
        files.sort();
        for path in files {
            let text = fs::read_to_string(&path).map_err(|why| format!("{}: {why}", path.display()))?;
            let name = path.strip_prefix(sources()).unwrap_or(&path).display().to_string();
            claims.extend(claims_of(&name, &text, kind).map_err(|why| format!("{name}: {why}"))?);
        }
    }
    let folder = sources().join("../gappa");
    let entries = fs::read_dir(&folder).map_err(|why| format!("{}: {why}", folder.display()))?;
    let mut scripts: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    scripts.sort();
    for path in scripts {
        claims.push(rounding(&path).map_err(|why| format!("{}: {why}", path.display()))?);
    }
    Ok(claims)
}

/// The claim of a script: its first comment.
fn rounding(path: &Path) -> Result<Claim, String> {
    let text = fs::read_to_string(path).map_err(|why| why.to_string())?;
    let lines =
        text.lines().map_while(|line| line.strip_prefix('#')).map(|line| line.strip_prefix(' ').unwrap_or(line));
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    described(
        Kind::Rounding,
        name,
        format!("../gappa/{}", path.file_name().unwrap_or_default().display()),
        &lines.collect::<Vec<_>>().join("\n"),
    )
}

fn claims_of(file: &str, text: &str, kind: Kind) -> Result<Vec<Claim>, String> {
    let parsed = syn::parse_file(text).map_err(|why| why.to_string())?;
    let covers: Vec<usize> =
        (1..).zip(text.lines()).filter(|(_, line)| line.contains("kani::cover!(")).map(|(number, _)| number).collect();
    let functions =
        parsed.items.iter().filter_map(|item| if let Item::Fn(function) = item { Some(function) } else { None });
    functions
        .filter(|function| match kind {
            Kind::Proof => attribute(function, "proof").is_some(),
            Kind::Sweep | Kind::Rounding => documentation(function).contains("\n- Fault:"),
        })
        .map(|function| {
            claim_of(file, function, kind, covers.clone()).map_err(|why| format!("{}: {why}", function.sig.ident))
        })
        .collect()
}

fn claim_of(file: &str, function: &ItemFn, kind: Kind, covers: Vec<usize>) -> Result<Claim, String> {
    let claim = described(kind, function.sig.ident.to_string(), file.to_owned(), &documentation(function))?;
    let argument = |name: &str| Some(attribute(function, name)?.meta.require_list().ok()?.tokens.to_string());
    Ok(Claim {
        unwind: argument("unwind").map_or(Ok(2), |text| text.parse().map_err(|_| "its bound is no number"))?,
        solver: argument("solver").unwrap_or(claim.solver),
        covers,
        ..claim
    })
}

/// A claim as far as its description says: a paragraph and a list.
fn described(kind: Kind, name: String, file: String, text: &str) -> Result<Claim, String> {
    let (says, items) = text.split_once("\n\n").ok_or("its description has no list")?;
    let items = items.replace("\n- ", "\n\n- ").replace("\n  ", " ");
    let item =
        |name: &str| items.split("\n\n").find_map(|item| item.strip_prefix(&format!("- {name}: ")).map(str::to_owned));
    let number = |name: &str, default: u32| match item(name) {
        Some(text) => text.parse().map_err(|_| format!("its `{name}` is no number")),
        None => Ok(default),
    };
    let method = match kind {
        Kind::Proof => "cadical",
        Kind::Sweep => "exhaustive sweep",
        Kind::Rounding => "gappa",
    };
    Ok(Claim {
        kind,
        name,
        file,
        says: says.replace('\n', " "),
        domain: item("Domain").ok_or("it says no domain")?,
        fault: fault(&item("Fault").ok_or("it names no fault")?)
            .ok_or("its fault is not `file`: `from` → `to`: what")?,
        unwind: 0,
        solver: method.to_owned(),
        cells: item("Memory").is_some_and(|text| text.starts_with("by cells")),
        stack: number("Stack", 1024)?,
        seconds: number("Seconds", 60)?,
        covers: Vec::new(),
    })
}

/// `` `file`: `from` → `to`: what ``, with `\n` for a line's end.
fn fault(text: &str) -> Option<Fault> {
    let parts: Vec<&str> = text.splitn(7, '`').collect();
    let [_, file, _, from, " → ", to, what] = parts[..] else { return None };
    let lines = |text: &str| text.replace("\\n", "\n");
    Some(Fault {
        file: file.to_owned(),
        from: lines(from),
        to: lines(to),
        what: what.strip_prefix(": ")?.trim_end_matches('.').to_owned(),
    })
}

/// An attribute of Kani's.
fn attribute<'a>(function: &'a ItemFn, name: &str) -> Option<&'a Attribute> {
    function.attrs.iter().find(|attribute| {
        let path: Vec<String> = attribute.path().segments.iter().map(|segment| segment.ident.to_string()).collect();
        path == ["kani", name]
    })
}

/// The lines of a function's documentation.
fn documentation(function: &ItemFn) -> String {
    let lines = function.attrs.iter().filter_map(|attribute| {
        let Meta::NameValue(pair) = &attribute.meta else { return None };
        let Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) = &pair.value else { return None };
        pair.path.is_ident("doc").then(|| text.value().strip_prefix(' ').unwrap_or_default().trim_end().to_owned())
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// A script with the numbers of the port's tables in place of `NAME[i]`, from the text of their file.
pub(crate) fn with_numbers(script: &str, port: &str) -> Result<String, String> {
    let mut text = script.to_owned();
    for table in port.split("const ").skip(1) {
        let Some((name, rest)) = table.split_once(": [i64;") else { continue };
        let Some((_, rest)) = rest.split_once("= [") else { continue };
        let numbers = rest.split_once(']').map(|(numbers, _)| numbers).unwrap_or_default();
        for (i, number) in numbers.split(',').map(|number| number.trim().replace('_', "")).enumerate() {
            text = text.replace(&format!("{name}[{i}]"), &number);
        }
    }
    if text.contains("[0]") { Err("a table of the port is missing".to_owned()) } else { Ok(text) }
}

/// A file of the port, and the same with a fault.
pub(crate) fn with_fault(port: &Path, fault: &Fault) -> Result<(PathBuf, String, String), String> {
    let path = port.join("src").join(&fault.file);
    let text = fs::read_to_string(&path).map_err(|why| format!("{}: {why}", path.display()))?;
    let tests = text.find("\n#[cfg(test)]\n").unwrap_or(text.len());
    let (code, tests) = text.split_at(tests);
    if code.matches(&fault.from).count() != 1 {
        return Err(format!("{} does not have `{}` once", fault.file, fault.from));
    }
    let faulty = code.replacen(&fault.from, &fault.to, 1) + tests;
    Ok((path, text, faulty))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_fault_stands_once_in_the_port() {
        let port = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../fixedpoint");
        for claim in claims().unwrap() {
            let (_, text, faulty) =
                with_fault(&port, &claim.fault).unwrap_or_else(|why| panic!("{}: {why}", claim.name));
            assert_ne!(text, faulty, "{}", claim.name);
        }
    }

    #[test]
    fn names_are_different_and_proofs_have_covers() {
        let claims = claims().unwrap();
        let names: BTreeSet<_> = claims.iter().map(|claim| claim.name.clone()).collect();
        assert_eq!(names.len(), claims.len());
        for claim in claims.iter().filter(|claim| claim.kind == Kind::Proof) {
            assert!(!claim.covers.is_empty(), "{} covers nothing", claim.name);
        }
    }

    #[test]
    fn every_sweep_is_in_the_program() {
        let program = fs::read_to_string(sources().join("sweep/main.rs")).unwrap();
        for claim in claims().unwrap().iter().filter(|claim| claim.kind == Kind::Sweep) {
            assert!(program.contains(&format!("(\"{}\", ", claim.name)), "{}", claim.name);
        }
    }

    #[test]
    fn a_claim_is_read_from_its_documentation() {
        let text = "/// One is\n/// one.\n///\n/// - Domain: ones.\n/// - Fault: `a/b.rs`: `1\\n` → ``: none.\n\
            #[kani::proof]\n#[kani::unwind(7)]\n#[kani::solver(z3)]\nfn one() { kani::cover!(true); }\nfn other() {}\n";
        let claims = claims_of("file.rs", text, Kind::Proof).unwrap();
        assert_eq!(claims.len(), 1);
        let Claim { says, unwind, solver, fault, covers, .. } = &claims[0];
        assert_eq!((says.as_str(), *unwind, solver.as_str(), covers.as_slice()), ("One is one.", 7, "z3", &[9][..]));
        assert_eq!((fault.file.as_str(), fault.from.as_str(), fault.to.as_str()), ("a/b.rs", "1\n", ""));
        assert!(claims_of("file.rs", "/// One.\n#[kani::proof]\nfn one() {}", Kind::Proof).is_err());
    }
}
