# Sourced by the scripts beside it: what they need, and what they have in common. Sets `root`, `triple` and `known`.
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
cd "$root"
if ! command -v cargo >/dev/null && [ -x "$HOME/.cargo/bin/cargo" ]; then PATH="$HOME/.cargo/bin:$PATH"; fi

# Sanitizers and coverage of edges are not stable yet; the pinned compiler has them all the same.
export RUSTC_BOOTSTRAP=1
triple="$(rustc -vV | sed -n 's/^host: //p')"
mapfile -t known < <(sed 's/#.*//;/^ *$/d' fuzz/targets.txt | cut -d' ' -f1)

# need COMMAND PACKAGE: installs what is missing.
need() { command -v "$1" >/dev/null || { apt-get update -q && apt-get install -qy "$2"; } >&2; }

# The longest input of a target.
length() { awk -v target="$1" '$1 == target { print $2 }' fuzz/targets.txt; }

# seeds TARGET: the folders of inputs that are in the tree.
seeds() {
  for folder in "fuzz/corpus/$1" "fuzz/regressions/$1"; do [ ! -d "$folder" ] || echo "$folder"; done
}

# chosen [TARGET...]: the targets that are named, or all; a name that is none ends the script.
chosen() {
  local target
  for target in "$@"; do
    printf '%s\n' "${known[@]}" | grep -qx -- "$target" || { echo "$target: is no target of fuzz/targets.txt" >&2; exit 2; }
  done
  if [ $# -gt 0 ]; then printf '%s\n' "$@"; else printf '%s\n' "${known[@]}"; fi
}

# build FOLDER: all targets for the engine, with the address sanitizer. Incremental in target/FOLDER.
build() {
  need c++ g++
  need jq jq
  command -v cargo-fuzz >/dev/null || cargo install --locked --version 0.13.2 cargo-fuzz >&2
  cargo fuzz build --fuzz-dir fuzz --target-dir "target/$1" --codegen-units 4 >&2
}

# Options of the engine that every run has: an input may take 20 s, which is not halved for a warning on a busy machine,
# 2 GiB in all and 256 MiB at once.
engine=(-timeout=20 -report_slow_units=20 -rss_limit_mb=2048 -malloc_limit_mb=256 -print_final_stats=1)

# stat LOG NAME: a number of the engine's last lines, 0 where it did not come to that.
stat() { sed -n "s/^stat::$2: *//p" "$1" | tail -n 1 | grep . || echo 0; }

# together DIR NAME...: what is known of all targets in one list, DIR/targets.json.
together() {
  local out="$1" files=() name
  shift
  for name in "$@"; do [ ! -f "$out/$name.json" ] || files+=("$out/$name.json"); done
  jq -s . "${files[@]}" </dev/null >"$out/targets.json"
}

# now: seconds with decimals.
now() { date +%s.%N; }
