//! From Rust to what a model checker reads: the proofs' library, right and with a fault, and of one proof its C program.

use crate::shell;
use crate::tree::{self, Claim, Kind};
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

/// The workspace.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..")
}

/// A folder of this command's own in the workspace's target folder.
pub(crate) fn folder(name: &str) -> Result<PathBuf, String> {
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from);
    let folder = target.join("proofs").join(name);
    fs::create_dir_all(&folder).map_err(|why| format!("{}: {why}", folder.display()))?;
    folder.canonicalize().map_err(|why| format!("{}: {why}", folder.display()))
}

/// What is proved or swept, built of a port as it is or of a faulty one. One build at a time: all are in one folder.
pub(crate) struct Builder {
    /// The proofs of the port as it is, for wasm32.
    pub(crate) library: PathBuf,
    /// Its sweeps, for this machine.
    pub(crate) sweeps: PathBuf,
    turn: Mutex<()>,
}

impl Builder {
    /// Builds the port as it is.
    pub(crate) fn new() -> Result<Self, String> {
        let work = folder("work")?;
        let (library, sweeps) = (work.join("proofs.a"), work.join("sweeps"));
        // Of the copy, too: to cargo a workspace elsewhere is the same one, and what is built of a fault would count as new.
        let workspace = copied_tree()?;
        build(&workspace, Kind::Proof, &library)?;
        build(&workspace, Kind::Sweep, &sweeps)?;
        Ok(Self { library, sweeps, turn: Mutex::new(()) })
    }

    /// Builds the port with a claim's fault.
    pub(crate) fn faulty(&self, claim: &Claim) -> Result<PathBuf, String> {
        let built = folder("work")?.join(format!("{}.faulty", claim.name));
        let turn = self.turn.lock().map_err(|_| "a build did not end")?;
        let workspace = copied_tree()?;
        let (path, right, faulty) = tree::with_fault(&workspace.join("fixedpoint"), &claim.fault)?;
        let error = |why: std::io::Error| format!("{}: {why}", path.display());
        fs::write(&path, faulty).map_err(error)?;
        let outcome = build(&workspace, claim.kind, &built);
        fs::write(&path, right).map_err(error)?;
        drop(turn);
        outcome.map(|()| built).map_err(|why| format!("with its fault: {why}"))
    }
}

/// Builds the proofs or the sweeps of a workspace.
fn build(workspace: &Path, kind: Kind, built: &Path) -> Result<(), String> {
    let target = folder("build")?;
    let file = match kind {
        Kind::Proof => {
            let library = ["--lib", "--profile", "proof", "--target", TARGET, "--crate-type", "staticlib"];
            cargo(workspace, &target, "rustc", &library)?;
            target.join(TARGET).join("proof/libproofs.a")
        }
        Kind::Rounding => return Err("a script is not built".to_owned()),
        Kind::Sweep => {
            cargo(workspace, &target, "build", &["--bin", "sweep", "--profile", "sweep"])?;
            target.join("sweep/sweep")
        }
    };
    fs::remove_file(built).ok(); // a program that still runs is not overwritten
    fs::copy(&file, built).map(|_| ()).map_err(|why| format!("{}: {why}", file.display()))
}

const TARGET: &str = "wasm32v1-none";

fn cargo(workspace: &Path, target: &Path, command: &str, arguments: &[&str]) -> Result<(), String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut cargo = Command::new(cargo);
    cargo.arg(command).args(["--quiet", "--locked", "--package", "barloc-proofs"]).args(arguments);
    cargo.current_dir(workspace).env("CARGO_TARGET_DIR", target).env_remove("RUSTFLAGS");
    shell::run(&mut cargo).map(|_| ())
}

/// The workspace with a copy of the port, in which no fault is left; everything else is the workspace's own.
fn copied_tree() -> Result<PathBuf, String> {
    let tree = folder("tree")?;
    let error = |why: std::io::Error| format!("{}: {why}", tree.display());
    for name in ["Cargo.toml", "Cargo.lock", "rust-toolchain.toml"] {
        fs::copy(root().join(name), tree.join(name)).map_err(error)?;
    }
    let source = root().canonicalize().map_err(error)?;
    for entry in fs::read_dir(&source).map_err(error)? {
        let name = entry.map_err(error)?.file_name();
        let is_member = source.join(&name).join("Cargo.toml").exists() && name != "fixedpoint";
        let (own, link) = (source.join(&name), tree.join(&name));
        if is_member && fs::read_link(&link).ok().as_ref() != Some(&own) {
            fs::remove_file(&link).ok(); // of another workspace
            symlink(own, link).map_err(error)?;
        }
    }
    copy(&source.join("fixedpoint"), &tree.join("fixedpoint")).map_err(error)?;
    Ok(tree)
}

/// Copies what is not the same already, so that nothing is built twice.
fn copy(from: &Path, to: &Path) -> std::io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let (source, target) = (entry.path(), to.join(entry.file_name()));
        if source.is_dir() {
            copy(&source, &target)?;
        } else if fs::read(&source)? != fs::read(&target).unwrap_or_default() {
            fs::copy(&source, &target)?;
        }
    }
    Ok(())
}

/// The programs that are run.
pub(crate) struct Tools {
    /// Those that `verify/proofs/setup` unpacked.
    pub(crate) folder: PathBuf,
    linker: PathBuf,
}

/// A C program, and the bytes of its linear memory.
pub(crate) struct Program {
    pub(crate) path: PathBuf,
    pub(crate) memory: u32,
}

impl Tools {
    pub(crate) fn find() -> Result<Self, String> {
        let folder = folder("tools")?.join("bin");
        if !folder.join("wasm2c").exists() {
            return Err("run verify/proofs/setup first".to_owned());
        }
        let sysroot = shell::run(Command::new("rustc").args(["--print", "sysroot"]).current_dir(root()))?;
        let hosts = Path::new(sysroot.trim()).join("lib/rustlib");
        let entries = fs::read_dir(&hosts).map_err(|why| format!("{}: {why}", hosts.display()))?;
        let mut linkers = entries.filter_map(|entry| Some(entry.ok()?.path().join("bin/rust-lld")));
        let linker = linkers.find(|path| path.exists()).ok_or("the toolchain has no rust-lld")?;
        Ok(Self { folder, linker })
    }

    /// What each of them says of its version.
    pub(crate) fn versions(&self) -> Vec<String> {
        let text = fs::read_to_string(self.folder.join("../versions")).unwrap_or_default();
        text.lines().map(str::to_owned).collect()
    }

    /// Links one proof of a library and makes C of it.
    ///
    /// The stack is at the bottom of the linear memory, so that an overflow of it is out of bounds.
    pub(crate) fn program(&self, library: &Path, claim: &Claim, base: &Path) -> Result<Program, String> {
        let named = |extension: &str| {
            let mut path = base.as_os_str().to_owned();
            path.push(extension);
            PathBuf::from(path)
        };
        let (module, path) = (named(".wasm"), named(".c"));
        let mut link = Command::new(&self.linker);
        link.args(["-flavor", "wasm", "--no-entry", "--gc-sections", "--allow-undefined", "--stack-first"]);
        link.arg(format!("--export=proof_{}", claim.name)).arg("--export=__data_end");
        link.args(["-z", &format!("stack-size={}", claim.stack)]).arg("-o").arg(&module).arg(library);
        shell::run(&mut link)?;
        let mut translate = Command::new(self.folder.join("wasm2c"));
        translate.args(["-n", "p"]).arg(&module).arg("-o").arg(&path);
        shell::run(&mut translate)?;
        let error = |why: std::io::Error| format!("{}: {why}", path.display());
        let text = fs::read_to_string(&path).map_err(error)?;
        let memory = memory(&text).ok_or("wasm2c does not say where data end")?;
        let covers: Vec<String> = claim.covers.iter().map(|line| format!("COVER({line})")).collect();
        fs::write(&path, format!("#define COVERS {}\n{}", covers.concat(), bytewise(&text))).map_err(error)?;
        Ok(Program { path, memory })
    }
}

/// Where the data of a program end.
fn memory(program: &str) -> Option<u32> {
    let (_, rest) = program.split_once("w2c___data_end = ")?;
    rest.split_once("u;")?.0.parse().ok()
}

/// A program with the accesses to memory of `checker/memory.h`, and without those of floating-point numbers.
fn bytewise(program: &str) -> String {
    let is_float = |line: &str| line.starts_with("DEFINE_LOAD(f") || line.starts_with("DEFINE_STORE(f");
    let mut text = String::with_capacity(program.len());
    let mut included = false;
    for line in program.lines().filter(|line| !is_float(line)) {
        if line.starts_with("DEFINE_LOAD(") && !included {
            text.push_str("#include \"memory.h\"\n");
            included = true;
        }
        text.push_str(line);
        text.push('\n');
    }
    text
}
