#!/usr/bin/env bash
# Installs what the tests need and runs all of them. `--long` adds the long runs.
. "$(dirname "$0")/setup.sh"
long=${1:-}
case "$long" in '' | --long) ;; *) echo "usage: test.sh [--long]" >&2; exit 2 ;; esac

# A checkout that is built once needs no state for the next build: a third less disk.
if [ -n "${CI:-}" ]; then export CARGO_INCREMENTAL=0; fi

step() { printf '\n== %s (%d s)\n' "$1" "$SECONDS"; }

step "Python readers of bags (PyPI, in target/venv); a browser that looks at reports"
need_packages python3 python3-venv chromium fonts-dejavu-core
if [ ! -x target/venv/bin/python ] || ! target/venv/bin/python -c 'import rosbags, mcap_ros2' 2>/dev/null; then
  mkdir -p target
  python3 -m venv target/venv
  target/venv/bin/pip install -q --disable-pip-version-check -r tests/requirements.txt
fi

step "format and lints"
cargo fmt --all --check
cargo clippy --workspace --all-targets --locked -- -D warnings

step "brains build without ROS"
for node in thermistor filament_encoder imu camera defect_classifier state_estimator mpc_controller advance_predictor safety_supervisor printer_sim printer_bridge bag_recorder; do
  cargo check -q --locked -p "$node" --lib --no-default-features
done

step "node binaries"
cargo build --workspace --bins --locked

step "tests"
cargo test --workspace --locked

if [ -n "$long" ]; then
  step "long: the tests over DDS, 20 times"
  for _ in $(seq 20); do
    cargo test -p system_tests --locked --test process_faults --test refusals --test bag --test orphans -- --include-ignored
  done
fi

step "licences, bans and sources"
if command -v cargo-deny >/dev/null; then
  cargo deny check licenses bans sources
else
  echo "cargo-deny is not installed: skipped (cargo install cargo-deny)"
fi
step "done"
