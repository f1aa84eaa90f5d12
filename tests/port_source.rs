//! What the port's source may not hold, read from its syntax: floating-point numbers, `unsafe`, an allocator, and whatever
//! panics in a release build. (Arithmetic that overflows wraps there; that it does not overflow is for the proofs.)
//!
//! The rules are stricter than the language: what they refuse and yet cannot panic is in [`EXCEPTIONS`], with its reason.

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use quote::ToTokens;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use syn::parse::{ParseStream, Parser};
use syn::punctuated::Punctuated;
use syn::visit::{self, Visit};
use syn::{Attribute, BinOp, Expr, Ident, ImplItem, Item, Lit, Pat, Token, UnOp};

/// What is refused by rule and cannot panic: file, expression, why not.
#[rustfmt::skip] // one to a line
const EXCEPTIONS: [(&str, &str, &str); 27] = [
    ("accept.rs", "residual.clamp(least, greatest)", LIMITED),
    ("accept/margin.rs", "(self.residual - change).clamp(least, greatest)", LIMITED),
    ("quiet_zone.rs", "seen.residual(self.edges.layer(self.format, self.layer.stripes, pixel)).clamp(least, greatest)", LIMITED),
    ("trellis/viterbi.rs", "((base + step) >> (RESIDUAL_BITS - SQUARED_BITS)).clamp(least, greatest)", LIMITED),
    ("fit/step.rs", "spread.clamp(smallest - blur, largest - blur)", "the same is subtracted from two constants in order"),
    ("light.rs", "(gain + along(gain_slope)).clamp(-limit, limit)", "`limit` is a positive constant"),
    ("motion/state.rs", "sum.clamp(-limit, limit)", "`limit` is a positive constant"),
    ("accept/margin.rs", "before[0]", LITERAL),
    ("accept/margin.rs", "before[1]", LITERAL),
    ("fit/step.rs", "solution[3]", LITERAL),
    ("sampling.rs", "before[0]", LITERAL),
    ("sampling.rs", "before[1]", LITERAL),
    ("trellis/viterbi.rs", "before.split_at(8)", "an array of 16"),
    ("trellis/viterbi.rs", "self.branches.split_at(16)", "an array of 32"),
    ("fit/layer.rs", "extent / u16::from(format.stripes() / 2)", STRIPES),
    ("light.rs", "extent / u16::from(format.stripes() / 2)", STRIPES),
    ("quiet_zone.rs", "extent.div_ceil(u16::from(format.stripes() / 2))", STRIPES),
    ("camera.rs", "FocalLength::from_num", "of a width that has been found to be at most 640; the type holds 2^16"),
    ("fit.rs", "Column::from_num", "of a pixel of a line, at most 640, and of a format's stripes; the type holds 2^11"),
    ("covariance.rs", "kk.max(0).unsigned_abs().saturating_mul(1 << 10).isqrt()", UNSIGNED),
    ("covariance/paper.rs", "square.isqrt()", UNSIGNED),
    ("filter/root.rs", "s.unsigned_abs().isqrt()", UNSIGNED),
    ("filter/root.rs", "normal.isqrt()", UNSIGNED),
    ("skew.rs", "m.saturating_mul(m).saturating_add(s.unsigned_abs().saturating_mul(s.unsigned_abs())).isqrt()", UNSIGNED),
    ("skew/play.rs", "variance.isqrt()", UNSIGNED),
    ("hypotheses.rs", "self.taken.insert(seed.first_region)", SET),
    ("hypotheses.rs", "self.taken.insert(region)", SET),
];

const LIMITED: &str = "`Limited::range` gives constants in order";
const LITERAL: &str = "a literal index of an array, which rustc checks (`unconditional_panic`)";
const STRIPES: &str = "formats have 20 or 24 stripes";
const UNSIGNED: &str = "of an unsigned number, which always has a root";
const SET: &str = "the port's own set, not a vector";

/// Names that mean a floating-point number, a system or an allocator.
const NAMES: [&str; 8] = ["f16", "f32", "f64", "f128", "std", "alloc", "Box", "String"];

/// Macros that do not panic; `sentences` is the port's own, and its definition is read too.
const MACROS: [&str; 2] = ["matches", "sentences"];

/// Methods that panic if there is nothing, if something is out of bounds, or if a result does not fit.
const METHODS: [&str; 31] = [
    "unwrap",
    "expect",
    "unwrap_err",
    "expect_err",
    "split_at",
    "split_at_mut",
    "copy_from_slice",
    "clone_from_slice",
    "copy_within",
    "swap",
    "swap_remove",
    "remove",
    "insert",
    "drain",
    "split_off",
    "select_nth_unstable",
    "rotate_left",
    "rotate_right",
    "ilog",
    "ilog2",
    "ilog10",
    "isqrt",
    "from_num",
    "to_num",
    "strict_add",
    "strict_sub",
    "strict_mul",
    "strict_neg",
    "strict_shl",
    "strict_shr",
    "borrow_mut",
];

/// Types whose names look like modules'.
const PRIMITIVES: [&str; 13] =
    ["u8", "u16", "u32", "u64", "u128", "usize", "i8", "i16", "i32", "i64", "i128", "isize", "str"];

/// Methods that panic if their argument is zero.
const DIVISIONS: [&str; 12] = [
    "div_euclid",
    "rem_euclid",
    "div_ceil",
    "div_floor",
    "next_multiple_of",
    "step_by",
    "chunks",
    "chunks_mut",
    "chunks_exact",
    "chunks_exact_mut",
    "rchunks",
    "windows",
];

/// Reads the syntax of a file.
#[derive(Default)]
struct Reader {
    findings: Vec<String>,
    /// Modules that are files of their own.
    modules: Vec<Ident>,
}

impl Reader {
    fn refuse(&mut self, what: impl ToTokens) {
        self.findings.push(what.to_token_stream().to_string());
    }

    /// The definition of a macro, which has no syntax yet: by its tokens alone.
    fn definition(&mut self, tokens: TokenStream) {
        let mut before: Option<TokenTree> = None;
        for token in tokens {
            match &token {
                TokenTree::Group(group) => {
                    let after_value = matches!(before, Some(TokenTree::Ident(_) | TokenTree::Group(_)));
                    if group.delimiter() == Delimiter::Bracket && after_value {
                        self.refuse(group);
                    }
                    self.definition(group.stream());
                }
                TokenTree::Ident(name) => {
                    if name == "unsafe"
                        || [&NAMES[..], &METHODS, &DIVISIONS].concat().iter().any(|refused| name == refused)
                    {
                        self.refuse(name);
                    }
                }
                TokenTree::Punct(sign) if "/%".contains(sign.as_char()) => self.refuse(sign),
                TokenTree::Punct(sign) if sign.as_char() == '!' => {
                    if let Some(TokenTree::Ident(name)) = &before {
                        self.refuse(name);
                    }
                }
                TokenTree::Punct(_) => {}
                TokenTree::Literal(literal) => {
                    if let Lit::Float(float) = Lit::new(literal.clone()) {
                        self.refuse(float);
                    }
                }
            }
            before = Some(token);
        }
    }
}

impl<'ast> Visit<'ast> for Reader {
    fn visit_item(&mut self, item: &'ast Item) {
        let attributes = match item {
            Item::Const(item) => &item.attrs,
            Item::Enum(item) => &item.attrs,
            Item::ExternCrate(item) => &item.attrs,
            Item::Fn(item) => &item.attrs,
            Item::Impl(item) => &item.attrs,
            Item::Macro(item) => &item.attrs,
            Item::Mod(item) => &item.attrs,
            Item::Static(item) => &item.attrs,
            Item::Struct(item) => &item.attrs,
            Item::Trait(item) => &item.attrs,
            Item::Type(item) => &item.attrs,
            Item::Use(item) => &item.attrs,
            _ => return self.refuse(item), // unions, foreign functions
        };
        if !is_for_tests(attributes) {
            visit::visit_item(self, item);
        }
    }

    fn visit_impl_item(&mut self, item: &'ast ImplItem) {
        let for_tests = matches!(item, ImplItem::Fn(function) if is_for_tests(&function.attrs));
        if !for_tests {
            visit::visit_impl_item(self, item);
        }
    }

    fn visit_item_mod(&mut self, module: &'ast syn::ItemMod) {
        if module.content.is_none() {
            self.modules.push(module.ident.clone());
        }
        visit::visit_item_mod(self, module);
    }

    fn visit_item_macro(&mut self, item: &'ast syn::ItemMacro) {
        if item.mac.path.is_ident("macro_rules") {
            self.definition(item.mac.tokens.clone());
        } else {
            visit::visit_item_macro(self, item);
        }
    }

    fn visit_ident(&mut self, name: &'ast Ident) {
        if NAMES.iter().any(|refused| name == refused) {
            self.refuse(name);
        }
    }

    fn visit_lit_float(&mut self, literal: &'ast syn::LitFloat) {
        self.refuse(literal);
    }

    fn visit_expr_unsafe(&mut self, block: &'ast syn::ExprUnsafe) {
        self.refuse(block);
    }

    fn visit_signature(&mut self, signature: &'ast syn::Signature) {
        if matches!(signature.safety, syn::Safety::Unsafe(_)) {
            self.refuse(signature);
        }
        visit::visit_signature(self, signature);
    }

    fn visit_item_impl(&mut self, item: &'ast syn::ItemImpl) {
        if item.unsafety.is_some() {
            self.refuse(&item.self_ty);
        }
        visit::visit_item_impl(self, item);
    }

    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        if !MACROS.iter().any(|name| call.path.is_ident(name)) {
            return self.refuse(call);
        }
        match arguments.parse2(call.tokens.clone()) {
            Ok(arguments) => arguments.iter().for_each(|argument| self.visit_expr(argument)),
            Err(_) => self.refuse(call),
        }
    }

    fn visit_expr_index(&mut self, index: &'ast syn::ExprIndex) {
        self.refuse(index);
        visit::visit_expr_index(self, index);
    }

    fn visit_expr_binary(&mut self, binary: &'ast syn::ExprBinary) {
        let divides = matches!(binary.op, BinOp::Div(_) | BinOp::Rem(_) | BinOp::DivAssign(_) | BinOp::RemAssign(_));
        if divides && !is_positive(&binary.right) {
            self.refuse(binary);
        }
        visit::visit_expr_binary(self, binary);
    }

    fn visit_expr_method_call(&mut self, call: &'ast syn::ExprMethodCall) {
        if may_panic(&call.method.to_string(), &call.args) {
            self.refuse(call);
        }
        visit::visit_expr_method_call(self, call);
    }

    /// `T::method(value)` is what `value.method()` is.
    fn visit_expr_path(&mut self, path: &'ast syn::ExprPath) {
        if let Some(last) = path.path.segments.last()
            && let Some(of) = path.path.segments.iter().nth_back(1)
            && (of.ident.to_string().starts_with(char::is_uppercase) || PRIMITIVES.iter().any(|name| of.ident == name))
            && may_panic(&last.ident.to_string(), &Punctuated::new())
        {
            self.refuse(path);
        }
        visit::visit_expr_path(self, path);
    }
}

/// The expressions that `matches!` and others of [`MACROS`] are given: the first one, and what may follow a pattern.
fn arguments(input: ParseStream<'_>) -> syn::Result<Vec<Expr>> {
    let first = input.parse()?;
    let mut all = vec![first];
    if input.parse::<Option<Token![,]>>()?.is_some() && !input.is_empty() {
        Pat::parse_multi_with_leading_vert(input)?;
        if input.parse::<Option<Token![if]>>()?.is_some() {
            all.push(input.parse()?);
        }
        input.parse::<Option<Token![,]>>()?;
    }
    Ok(all)
}

/// Whether a method may panic.
fn may_panic(method: &str, arguments: &Punctuated<Expr, Token![,]>) -> bool {
    METHODS.contains(&method)
        || DIVISIONS.contains(&method) && !arguments.last().is_some_and(is_positive)
        // Limits in the wrong order; of constants the first call shows it.
        || method == "clamp" && !arguments.iter().all(is_constant)
}

/// A literal other than zero, the larger one of it and something else, or a constant: rustc refuses one that is zero.
fn is_positive(expr: &Expr) -> bool {
    match expr {
        Expr::Lit(literal) => matches!(&literal.lit, Lit::Int(value) if value.base10_digits() != "0"),
        Expr::MethodCall(call) if call.method == "max" => call.args.iter().all(is_positive),
        Expr::Call(call) if converts(call) => call.args.iter().all(is_positive),
        _ => is_constant(expr) && !matches!(expr, Expr::Unary(_)),
    }
}

/// What is known at compile time: literals, constants by their names, and what is computed or converted from them.
fn is_constant(expr: &Expr) -> bool {
    match expr {
        Expr::Lit(_) => true,
        Expr::Path(path) => path.path.segments.last().is_some_and(|last| {
            last.ident.to_string().chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_')
        }),
        Expr::Unary(unary) => matches!(unary.op, UnOp::Neg(_)) && is_constant(&unary.expr),
        Expr::Paren(inner) => is_constant(&inner.expr),
        Expr::Cast(cast) => is_constant(&cast.expr),
        Expr::Binary(binary) => is_constant(&binary.left) && is_constant(&binary.right),
        Expr::Call(call) => converts(call) && call.args.iter().all(is_constant),
        _ => false,
    }
}

/// A call of `T::from`.
fn converts(call: &syn::ExprCall) -> bool {
    matches!(&*call.func, Expr::Path(path) if path.path.segments.last().is_some_and(|last| last.ident == "from"))
}

fn is_for_tests(attributes: &[Attribute]) -> bool {
    let test: Attribute = syn::parse_quote!(#[cfg(test)]);
    attributes.contains(&test)
}

/// What is refused in a piece of source, and the modules that it has in files of their own.
fn read(source: &str) -> (Vec<String>, Vec<Ident>) {
    let mut reader = Reader::default();
    reader.visit_file(&syn::parse_file(source).unwrap());
    (reader.findings, reader.modules)
}

/// What is refused in a file and in the modules below, with the file's name.
fn read_module(root: &Path, file: &Path, findings: &mut Vec<(PathBuf, String)>) -> usize {
    let (found, modules) = read(&std::fs::read_to_string(root.join(file)).unwrap());
    findings.extend(found.into_iter().map(|finding| (file.to_owned(), finding)));
    let folder = if file == Path::new("lib.rs") { PathBuf::new() } else { file.with_extension("") };
    let below = modules.iter().map(|module| read_module(root, &folder.join(format!("{module}.rs")), findings));
    1 + below.sum::<usize>()
}

#[test]
fn the_port_holds_nothing_that_panics_and_no_floating_point() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixedpoint/src");
    let mut findings = Vec::new();
    let files = read_module(&root, Path::new("lib.rs"), &mut findings);
    assert!(files > 60, "{files} files");
    let mut unused = EXCEPTIONS.to_vec();
    let mut refused = String::new();
    for (file, finding) in findings {
        let is_exception = |&(path, expression, _): &(&str, &str, &str)| {
            let expression = expression.parse::<TokenStream>().unwrap().to_string();
            Path::new(path) == file && expression == finding
        };
        unused.retain(|exception| !is_exception(exception));
        if !EXCEPTIONS.iter().any(is_exception) {
            writeln!(refused, "{}: {finding}", file.display()).unwrap();
        }
    }
    assert!(refused.is_empty(), "refused:\n{refused}");
    assert!(unused.is_empty(), "exceptions of nothing: {unused:?}");
}

/// One piece of source for each rule, and what is refused in it.
#[test]
fn each_rule_is_seen_to_refuse() {
    let within = |body: &str| read(&format!("fn f(a: &[u8], n: usize) {{ {body} }}")).0;
    for (source, refused) in [
        ("let x = 1.5;", "1.5"),
        ("let x = 2e3;", "2e3"),
        ("let x: f32 = g();", "f32"),
        ("let x = n as f64;", "f64"),
        ("unsafe { g() }", "unsafe { g () }"),
        ("let x = std::mem::take(n);", "std"),
        ("let x = alloc::vec::Vec::new();", "alloc"),
        ("let x = Box::new(n);", "Box"),
        ("panic!();", "panic ! ()"),
        ("assert!(n > 0);", "assert ! (n > 0)"),
        ("assert_eq!(n, 0);", "assert_eq ! (n , 0)"),
        ("debug_assert!(n > 0);", "debug_assert ! (n > 0)"),
        ("unreachable!()", "unreachable ! ()"),
        ("todo!()", "todo ! ()"),
        ("unimplemented!()", "unimplemented ! ()"),
        ("core::panic!()", "core :: panic ! ()"),
        ("let x = a.first().unwrap();", "a . first () . unwrap ()"),
        ("let x = a.first().expect(\"one\");", "a . first () . expect (\"one\")"),
        ("let x = g().unwrap_err();", "g () . unwrap_err ()"),
        ("let x = a.first().map(Option::unwrap);", "Option :: unwrap"),
        ("let x = a[n];", "a [n]"),
        ("let x = a[0];", "a [0]"),
        ("let x = &a[1..n];", "a [1 .. n]"),
        ("a[n] += 1;", "a [n]"),
        ("let x = 7 / n;", "7 / n"),
        ("let x = 7 % n;", "7 % n"),
        ("x /= n;", "x /= n"),
        ("x %= n;", "x %= n"),
        ("let x = 7 / 0;", "7 / 0"),
        ("let x = 7 / -1;", "7 / - 1"),
        ("let x = n.div_ceil(n);", "n . div_ceil (n)"),
        ("let x = a.chunks(n);", "a . chunks (n)"),
        ("let x = a.split_at(n);", "a . split_at (n)"),
        ("let x = n.clamp(0, n);", "n . clamp (0 , n)"),
        ("let x = a.iter().map(|b| u32::ilog2(*b));", "u32 :: ilog2"),
        ("let x = 7 / n.max(0);", "7 / n . max (0)"),
        ("let x = matches!(a[n], 1 | 2);", "a [n]"),
        ("let x = matches!(n, 1 | 2 if a[n] > 0);", "a [n]"),
        ("g(|| a.iter().map(|b| if n > 1 { 1 / n } else { 0 }));", "1 / n"),
        ("const { a[n] }", "a [n]"),
        ("macro_rules! m { ($a:expr) => { $a.unwrap() }; }", "unwrap"),
        ("macro_rules! m { ($a:expr) => { $a / 2 }; }", "/"),
        ("macro_rules! m { ($a:expr) => { $a[0] }; }", "[0]"),
        ("macro_rules! m { ($a:expr) => { panic!() }; }", "panic"),
        ("macro_rules! m { ($a:expr) => { 0.5 }; }", "0.5"),
    ] {
        assert_eq!(within(source), [refused], "{source}");
    }
    for (source, refused) in [
        ("unsafe fn f() {}", "unsafe fn f ()"),
        ("unsafe impl Send for T {}", "T"),
        ("unsafe extern \"C\" { fn f(); }", "unsafe extern \"C\" { fn f () ; }"),
        ("extern crate alloc;", "alloc"),
        ("use std::vec::Vec;", "std"),
        ("struct S { x: f32 }", "f32"),
        ("mod m { fn f() { panic!() } }", "panic ! ()"),
        ("impl T { fn f(&self) { todo!() } }", "todo ! ()"),
        ("#[cfg(not(test))] fn f() { todo!() }", "todo ! ()"),
        ("const X: usize = Y / n();", "Y / n ()"),
    ] {
        assert_eq!(read(source).0, [refused], "{source}");
    }
}

/// What looks like it and is not.
#[test]
fn what_cannot_panic_is_not_refused() {
    for source in [
        "#[cfg(test)] mod tests { fn f() { panic!(\"{}\", 1.5) } }",
        "#[cfg(test)] extern crate std;",
        "impl T { #[cfg(test)] fn f(&self) { todo!() } }",
        "/// Divides by 1.5, `a[0]`.\nfn f(n: u8) -> u8 { n / 2 % BLOCK }",
        "fn f(n: i32) -> i32 { n.clamp(-LIMIT, i32::from(i16::MAX)) / (1 << 20) }",
        "fn f(a: &[u8]) -> Option<&u8> { a.chunks(4).next()?.get(1) }",
        "fn f(a: [u8; 2]) -> u8 { let [one, other] = a; one.max(other).wrapping_add(1) }",
        "fn f(n: u8) -> u16 { core::mem::swap(x, y); 7 / u16::from(n.max(1)) }",
        "fn f(n: u8) -> bool { matches!(n, 1 | 2) }",
        "fn f(n: Option<u8>) -> u8 { n.unwrap_or(0).checked_div(n).unwrap_or_default() }",
    ] {
        assert_eq!(read(source).0, Vec::<String>::new(), "{source}");
    }
}

/// A module in a file of its own is read wherever it is declared.
#[test]
fn modules_in_files_are_followed() {
    let (_, modules) = read("pub mod one; mod two { fn f() {} } #[cfg(test)] mod tests; mod three;");
    assert_eq!(modules, ["one", "three"]);
}
