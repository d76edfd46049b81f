#!/usr/bin/env bash
# Installs what the tests need and runs all of them. `--long` adds the long runs.
. "$(dirname "$0")/setup.sh"
long=${1:-}
case "$long" in '' | --long) ;; *) echo "usage: test.sh [--long]" >&2; exit 2 ;; esac

# A checkout that is built once needs no state for the next build and no debugger: less disk, less to link.
if [ -n "${CI:-}" ]; then export CARGO_INCREMENTAL=0 CARGO_PROFILE_DEV_DEBUG=0; fi

step() { printf '\n== %s (%d s)\n' "$1" "$SECONDS"; }

step "Python readers of bags (PyPI, in target/venv); a browser that looks at reports"
need_packages python3 python3-venv iproute2 chromium fonts-dejavu-core
if [ ! -x target/venv/bin/python ] || ! target/venv/bin/python -c 'import rosbags, mcap_ros2, cyclonedds' 2>/dev/null; then
  mkdir -p target
  python3 -m venv target/venv
  target/venv/bin/pip install -q --disable-pip-version-check -r tests/requirements.txt
fi

step "format and lints"
cargo fmt --all --check
cargo clippy --workspace --all-targets --locked -- -D warnings

step "brains build without ROS"
brains=(thermistor filament_encoder imu camera defect_classifier state_estimator mpc_controller advance_predictor safety_supervisor printer_sim printer_bridge bag_recorder)
cargo check -q --locked --lib --no-default-features "${brains[@]/#/-p=}"

# Together: what tests ask of a library would have it built a second time for them.
step "programs and tests"
cargo build --workspace --bins --tests --locked

# All of them, even after one has failed: who mends the first sees the others.
step "tests"
cargo test --workspace --locked --no-fail-fast

if [ -n "$long" ]; then
  step "long: the catalogue of faults with twenty seeds, 300 hours of sound prints"
  cargo run --release --locked -p cli -- faults --seeds 1..20 --hours 300 --html target/faults.html

  step "long: 10^6 datagrams of garbage to the ports of a printing graph as it is installed, whole again in 5 s"
  cargo build --release --workspace --bins --locked
  FDM_WHOLE_LIMIT_S=5 FDM_RTPS_DATAGRAMS=1000000 cargo test --release -p system_tests --locked --test rtps_garbage -- --nocapture

  step "long: the faults of processes over DDS with twenty seeds, a soak of 50 minutes"
  target/release/fdm faults --process --seeds 1..20 --html target/process_faults.html
  target/release/fdm faults --process --only L5 --soak-s 3000

  step "long: the tests over DDS, 20 times"
  for _ in $(seq 20); do
    cargo test -p system_tests --locked --test refusals --test bag --test orphans --test operate -- --include-ignored
  done

  step "long: an independent DDS, 20 times"
  FDM_INTEROP_ROUNDS=20 cargo test -p system_tests --locked --test interop
  for _ in $(seq 20); do
    unshare -rn bash -c 'ip link set lo up multicast on && ip route add 239.0.0.0/8 dev lo &&
      exec target/venv/bin/python tests/interop/two_graphs.py target/release 30'
  done

  step "long: 50 kills of a recorder at random moments; the recorder beside PyPI's writer, the graph over 10^5 samples"
  FDM_KILLS=50 cargo test -p system_tests --locked --test replay no_kill
  target/release/fdm bench recorder --seconds 60
  target/release/fdm bench graph --samples 100000

  step "long: 10^5 malformed payloads a type, 10^6 orders to a firmware, 5000 poisoned prints"
  FDM_MALFORMED_PAYLOADS=100000 cargo test -p runtime --locked --test malformed
  FDM_MALFORMED_PAYLOADS=100000 cargo test --locked --lib -p thermistor -p filament_encoder -p imu -p mpc_controller -p advance_predictor malformed
  FDM_GCODE_CASES=1000000 cargo test -p models --locked --lib gcode::order
  FDM_POISON_CASES=5000 cargo test -p safety_supervisor --locked --no-default-features --test poison

  step "long: every way in under libFuzzer and the address sanitizer, five minutes each"
  if command -v cargo-fuzz >/dev/null; then
    tests/fuzz/run.sh 300
  else
    echo "cargo-fuzz is not installed: mutations of the seeds alone (cargo install cargo-fuzz --locked)"
    FDM_FUZZ_CASES=50 cargo test -p system_tests --locked --test fuzz
  fi

  step "long: lines of the supervisor's brain that are covered, 95 % at least"
  if command -v cargo-llvm-cov >/dev/null; then
    cargo llvm-cov --locked -p safety_supervisor --no-default-features --lib --tests --fail-under-lines 95 \
      --ignore-filename-regex '(/node/|node\.rs|convert\.rs|main\.rs|/tests|tests\.rs|/models/)'
  else
    echo "cargo-llvm-cov is not installed: skipped (rustup component add llvm-tools; cargo install cargo-llvm-cov --locked)"
  fi

  # All of them take hours: a tenth of them, another one with FDM_MUTANTS=1/10 and so on, all with FDM_MUTANTS=0/1.
  step "long: mutants of the supervisor's brain that are killed, 90 % at least"
  if command -v cargo-mutants >/dev/null; then
    rm -rf target/mutants
    FDM_POISON_CASES=40 cargo mutants -p safety_supervisor --no-default-features --timeout 300 -o target/mutants \
      -e '**/node.rs' -e '**/node/**' -e '**/convert.rs' -e '**/main.rs' -e '**/tests/**' \
      --sharding round-robin --shard "${FDM_MUTANTS:-0/10}" -- --lib --tests || true
    python3 - target/mutants/mutants.out/outcomes.json <<'PYTHON'
import json, sys
found = json.load(open(sys.argv[1]))
killed, missed = found["caught"] + found["timeout"], found["missed"]
print(f"{killed} of {killed + missed} mutants killed")
sys.exit(killed < 0.9 * (killed + missed))
PYTHON
  else
    echo "cargo-mutants is not installed: skipped (cargo install cargo-mutants --locked)"
  fi
fi

step "systemd units: complete, and exposed by 2.0 of 10 at most"
if command -v systemd-analyze >/dev/null; then
  units=$(mktemp -d)
  cp -r launch_scripts/systemd/. "$units"
  for node in safety_supervisor bag_recorder printer_bridge thermistor filament_encoder imu camera state_estimator defect_classifier advance_predictor mpc_controller; do
    cp "$units/fdm_loop@.service" "$units/fdm_loop@$node.service"
    systemd-analyze security --offline=true --no-pager --threshold=20 "$units/fdm_loop@$node.service" | tail -n 1
    # The programs are not installed here; anything else that it says is a fault.
    ! systemd-analyze verify --man=no "$units/fdm_loop@$node.service" 2>&1 | grep -v "/usr/lib/fdm_loop/$node is not executable" || exit 1
  done
  rm -r "$units"
else
  echo "systemd-analyze is not installed: skipped"
fi

step "licences, bans and sources"
if command -v cargo-deny >/dev/null; then
  cargo deny check licenses bans sources
else
  echo "cargo-deny is not installed: skipped (cargo install cargo-deny)"
fi
step "done"
