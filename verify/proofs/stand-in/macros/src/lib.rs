//! The attributes of Kani's that barloc's proofs carry.
//!
//! On wasm32 a proof becomes an exported function, from which a model checker starts; elsewhere a test that samples it.
//! Bounds and solvers are read from the sources, so nothing is left of them here.

use proc_macro::{TokenStream, TokenTree};

/// Makes a function without arguments a proof.
#[proc_macro_attribute]
pub fn proof(_attribute: TokenStream, item: TokenStream) -> TokenStream {
    let Some(name) = function(&item) else {
        return "compile_error!(\"a proof is a function\");".parse().unwrap_or_default();
    };
    let entries = format!(
        "#[cfg(target_arch = \"wasm32\")]
         #[allow(unsafe_code)] // a fixed name, by which the linker finds the proof
         #[unsafe(export_name = \"proof_{name}\")]
         extern \"C\" fn proof_of_{name}() {{ {name}(); }}
         #[cfg(all(test, not(target_arch = \"wasm32\")))]
         #[test]
         fn sampled_{name}() {{ ::kani::sample(\"{name}\", {name}); }}"
    );
    let entries: TokenStream = entries.parse().unwrap_or_default();
    item.into_iter().chain(entries).collect()
}

/// The bound of a proof's loops.
#[proc_macro_attribute]
pub fn unwind(_bound: TokenStream, item: TokenStream) -> TokenStream {
    item
}

/// What decides a proof.
#[proc_macro_attribute]
pub fn solver(_name: TokenStream, item: TokenStream) -> TokenStream {
    item
}

/// The name of a function.
fn function(item: &TokenStream) -> Option<String> {
    let mut trees = item.clone().into_iter();
    trees.find(|tree| matches!(tree, TokenTree::Ident(word) if word.to_string() == "fn"))?;
    Some(trees.next()?.to_string())
}
