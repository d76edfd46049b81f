#!/bin/sh
# The peers of `fdm bench estimator|controller|sim` in target/bench_peers, a virtual environment of their own.
set -eu
cd "$(dirname "$0")/../.."
mkdir -p target
python3 -m venv target/bench_peers
target/bench_peers/bin/pip install -q --disable-pip-version-check -r tests/bench_peers/requirements.txt
target/bench_peers/bin/python -W ignore -c 'import filterpy.kalman, osqp, do_mpc, casadi'
echo "The peers are in target/bench_peers: fdm bench estimator, controller or sim"
