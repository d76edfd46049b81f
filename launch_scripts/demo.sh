#!/usr/bin/env bash
# Builds everything and prints the first 10 layers of a real PrusaSlicer file on the simulated printer, twice: with
# the loop open and closed. From the middle on the drive gear loses 9 % of the filament.
. "$(dirname "$0")/setup.sh"

echo "Building (release; a first build takes a quarter of an hour on two cores)"
cargo build --release --locked --workspace --bins

# The printer heats up for two minutes of its own time; four times as fast fits into the patience of a demo.
"${CARGO_TARGET_DIR:-target}/release/fdm" up \
  --gcode tests/data/gcode/prusa_cube_pla_marlin_relE.gcode --layers 10 \
  --scenario slip09 --control off,mpc --host "${FDM_HOST:-native}" --speed "${FDM_SPEED:-4}"
