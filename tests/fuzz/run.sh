#!/usr/bin/env bash
# Runs fuzz targets under libFuzzer and the address sanitizer: run.sh [SECONDS [TARGET...]], all of them by default.
# Needs cargo-fuzz (cargo install cargo-fuzz --locked). What it finds is kept in corpus/ and artifacts/ beside this file.
set -euo pipefail
cd "$(dirname "$0")"
seconds=${1:-60}
shift || true
targets=("$@")
[ ${#targets[@]} -gt 0 ] || mapfile -t targets < <(cd fuzz_targets && printf '%s\n' *.rs | sed 's/\.rs$//')

# The versions that are shipped.
cp ../../Cargo.lock Cargo.lock
FDM_FUZZ_CORPUS=$PWD/corpus FDM_FUZZ_CASES=0 cargo test -q --manifest-path ../../Cargo.toml -p system_tests --locked --test fuzz

# Files of a case lie in memory: it is the readers that are tested, not the disk.
scratch=$(mktemp -d -p /dev/shm)
trap 'rm -rf "$scratch"' EXIT
failed=()
for target in "${targets[@]}"; do
  # The first variable lets the stable compiler take the switches of the sanitizer.
  RUSTC_BOOTSTRAP=1 TMPDIR=$scratch cargo fuzz run --fuzz-dir . "$target" -- \
    -max_total_time="$seconds" -max_len=16384 -timeout=10 -rss_limit_mb=2048 -print_final_stats=1 || failed+=("$target")
done
if [ ${#failed[@]} -gt 0 ]; then
  echo "found something: ${failed[*]}" >&2
  exit 1
fi
