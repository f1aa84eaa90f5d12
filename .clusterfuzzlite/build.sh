#!/bin/bash -eu
# Run by ClusterFuzzLite in its image: builds every target of fuzz/targets.txt into $OUT, with its corpus and dictionary.
cd "$SRC/barloc"

# The compiler of rust-toolchain.toml, which the image's choice would override.
unset RUSTUP_TOOLCHAIN
export RUSTC_BOOTSTRAP=1
host="$(rustc -vV | sed -n 's/^host: //p')"

# The engine runs each target under one sanitizer; for its coverage reports it sets RUSTFLAGS itself.
sanitizer=address
[ "${SANITIZER:-address}" = address ] || sanitizer=none
cargo fuzz build --fuzz-dir fuzz --sanitizer "$sanitizer" --target-dir target/fuzz

sed 's/#.*//;/^ *$/d' fuzz/targets.txt | while read -r target length; do
  cp "target/fuzz/$host/release/$target" "$OUT/"
  find "fuzz/corpus/$target" "fuzz/regressions/$target" -type f 2>/dev/null | zip -q -j -@ "$OUT/${target}_seed_corpus.zip"
  [ ! -f "fuzz/dictionaries/$target.dict" ] || cp "fuzz/dictionaries/$target.dict" "$OUT/"
  printf '[libfuzzer]\nmax_len = %s\ntimeout = 20\nrss_limit_mb = 2048\nmalloc_limit_mb = 256\n' "$length" >"$OUT/$target.options"
done
