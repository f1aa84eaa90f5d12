//! The command `barloc`: see [`verify::command`].

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(verify::command::run(std::env::args_os()).code())
}
