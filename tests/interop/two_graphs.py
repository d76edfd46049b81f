"""Two whole graphs in two namespaces of one domain: no endpoint of the one speaks to the other, and what a person does
to the one printer leaves the other printing.

    two_graphs.py BINARIES DOMAIN

Twenty processes find each other by multicast only: to be run in a network namespace with it, and with release binaries,
for discovery alone takes two cores for seconds (`launch_scripts/test.sh --long`).
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

os.environ["FDM_INTEROP_MULTICAST"] = "1"

from endpoints import participants  # noqa: E402
from graph import LATCHED, RELIABLE, ROOT, Node, Peer, check, run, until  # noqa: E402

FILE = "tests/data/gcode/prusa_cube_pla_marlin_relE.gcode"
NAMESPACES = ("/left", "/right")
PRINTING, SAFE_OFF = 2, 6


def start(folder: Path, namespace: str, domain: int) -> subprocess.Popen:
    words = ["up", "--gcode", FILE, "--warm", "--speed", "1", "--namespace", namespace]
    return subprocess.Popen(
        [Node.binaries / "fdm", *words, "--bag", folder / namespace.strip("/")],
        cwd=ROOT, env={**os.environ, "ROS_DOMAIN_ID": str(domain)}, stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )


def two_graphs(domain: int) -> str:
    folder = Path(tempfile.mkdtemp(prefix="fdm_two_graphs_"))
    graphs: list[subprocess.Popen] = []
    try:
        return apart(domain, graphs, lambda namespace: start(folder, namespace, domain))
    finally:
        for graph in graphs:
            graph.send_signal(signal.SIGINT)
        for graph in graphs:
            try:
                graph.wait(15)
            except subprocess.TimeoutExpired:
                graph.kill()
        # A graph that had to be killed may write on for a moment.
        shutil.rmtree(folder, ignore_errors=True)


def apart(domain: int, graphs: list[subprocess.Popen], begin) -> str:
    peer = Peer(domain)
    states = {name: peer.reader(f"{name}/printer/state", "fdm_loop_msgs/PrinterState", RELIABLE) for name in NAMESPACES}
    modes = {name: peer.reader(f"{name}/safety/state", "fdm_loop_msgs/SafetyState", LATCHED) for name in NAMESPACES}
    newest: dict[str, object] = {}

    def look(readers) -> dict[str, object]:
        for name, reader in readers.items():
            for sample in reader.take(1000):
                newest[name, reader is states[name]] = sample
        check(all(graph.poll() is None for graph in graphs), "both graphs run")
        return newest

    printing = lambda name: getattr(newest.get((name, True)), "phase", None) == PRINTING
    for name in NAMESPACES:
        # One after the other: twenty processes that find each other at once want more than two cores have.
        graphs.append(begin(name))
        until(lambda: look(states) is newest and printing(name), f"{name} prints", 60.0)
    by_name = participants(peer, NAMESPACES)
    check(all(count >= 11 for count in by_name.values()), f"participants: {by_name}")
    command = [Node.binaries / "fdm", "stop", "--namespace", NAMESPACES[0]]
    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
    subprocess.run(command, env=environment, check=True, timeout=20, stdout=subprocess.DEVNULL)
    stopped = lambda: getattr(newest.get((NAMESPACES[0], False)), "mode", None) == SAFE_OFF
    until(lambda: look(modes) and stopped(), "the left printer is off")
    before = newest[NAMESPACES[1], True].line
    graphs.pop(0).wait(15)
    until(lambda: look({NAMESPACES[1]: states[NAMESPACES[1]]}) and newest[NAMESPACES[1], True].line > before + 5,
          "the right one prints on", 30.0)
    look({NAMESPACES[1]: modes[NAMESPACES[1]]})
    check(newest[NAMESPACES[1], False].cause == "", f"the right one is untouched: {newest[NAMESPACES[1], False]}")
    return f"{by_name} participants"


if __name__ == "__main__":
    Node.binaries = Path(sys.argv[1])
    run({"two_graphs": two_graphs}, int(sys.argv[2]))
