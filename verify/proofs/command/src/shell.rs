//! Programs that are waited for, with a limit of time and a measure of memory.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

/// What became of a program.
pub(crate) struct Ended {
    /// Its exit code; none if a signal ended it.
    pub(crate) code: Option<i32>,
    /// What it wrote.
    pub(crate) output: String,
    /// Its CPU time and its children's.
    pub(crate) seconds: f64,
    /// The most memory that it and its children had at a time.
    pub(crate) megabytes: u64,
}

/// Runs a command to its end and returns what it wrote, or the end of that if it failed.
pub(crate) fn run(command: &mut Command) -> Result<String, String> {
    let what = command.get_program().to_string_lossy().into_owned();
    let output = command.output().map_err(|why| format!("{what}: {why}"))?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    let words = String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout);
    Err(format!("{what} failed: {words}"))
}

/// Runs a command, of which each process may use so many seconds of CPU time, and writes its output into a file.
///
/// CPU time, so that the limit is the same on a busy machine.
pub(crate) fn measured(command: &Command, seconds: u32, output: &Path) -> Result<Ended, String> {
    let times = output.with_extension("times");
    let mut limited = Command::new("sh");
    limited
        .arg("-c")
        .arg(format!("ulimit -t {seconds}; \"$@\"; code=$?; times > \"$TIMES\"; exit $code"))
        .arg("sh")
        .arg(command.get_program())
        .args(command.get_args())
        .envs(command.get_envs().filter_map(|(name, value)| Some((name, value?))))
        .env("TIMES", &times);
    if let Some(folder) = command.get_current_dir() {
        limited.current_dir(folder);
    }
    let error = |why: std::io::Error| format!("{}: {why}", output.display());
    let file = fs::File::create(output).map_err(error)?;
    limited.stdin(Stdio::null()).stdout(file.try_clone().map_err(error)?).stderr(file);
    let mut child = limited.spawn().map_err(error)?;
    let mut kilobytes = 0;
    let status = loop {
        kilobytes = kilobytes.max(memory(child.id()));
        match child.try_wait().map_err(error)? {
            Some(status) => break status,
            None => sleep(Duration::from_millis(20)),
        }
    };
    let words = String::from_utf8_lossy(&fs::read(output).map_err(error)?).into_owned();
    let seconds = fs::read_to_string(&times).map(|text| children(&text)).unwrap_or_default();
    fs::remove_file(&times).ok();
    Ok(Ended { code: status.code(), output: words, seconds, megabytes: kilobytes.div_ceil(1024) })
}

/// The memory of a process and its children in KB.
fn memory(process: u32) -> u64 {
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let own = status.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB")?.parse().ok());
    let children = fs::read_to_string(format!("/proc/{process}/task/{process}/children")).unwrap_or_default();
    let theirs: u64 = children.split_whitespace().filter_map(|child| child.parse().ok()).map(memory).sum();
    own.unwrap_or(0) + theirs
}

/// The seconds of the children in what the shell's `times` says: `1m2.5s 0m0.1s` in its second line.
fn children(times: &str) -> f64 {
    let seconds = |time: &str| {
        let (minutes, seconds) = time.strip_suffix('s')?.split_once('m')?;
        Some(60.0 * minutes.parse::<f64>().ok()? + seconds.parse::<f64>().ok()?)
    };
    times.lines().nth(1).unwrap_or_default().split_whitespace().filter_map(seconds).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shell_tells_the_children_s_time() {
        assert!((children("0m0.00s 0m0.00s\n1m2.50s 0m0.10s\n") - 62.6).abs() < 1e-9);
    }

    #[test]
    fn a_program_that_takes_too_long_is_ended() {
        let output = std::env::temp_dir().join(format!("barloc-proofs-{}.txt", std::process::id()));
        let mut endless = Command::new("sh");
        endless.args(["-c", "while :; do :; done"]);
        let ended = measured(&endless, 1, &output).unwrap();
        fs::remove_file(&output).ok();
        assert!(ended.code != Some(0) && ended.seconds >= 0.9, "{} s", ended.seconds);
    }
}
