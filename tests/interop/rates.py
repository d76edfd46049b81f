"""Rate and loss, both ways; domains that do not hear each other.

    rates.py BINARIES DOMAIN [CHECK ...]
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path
from statistics import median

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from graph import BEST_EFFORT, DEFINITIONS, RELIABLE, Node, Peer, check, matched, run, until
from ros_types import value

#: Permits that are followed: 5 s of them, and the time between two `[s]`.
PERMITS, PERIOD_S = 250, 0.02
#: Messages that are recorded, and the time between two: 1 kHz `[s]`.
SENT, PACE_S = 3000, 0.001
#: Beats that are heard beside the domain in which none may be.
BEATS = 20


def permits(domain: int) -> str:
    """The permits come at 50 Hz, and none of them is lost."""
    peer = Peer(domain)
    Node("safety_supervisor", ["safety_supervisor.param.yaml"], ROS_DOMAIN_ID=domain)
    reader = peer.reader("/printer/safety/command", "fdm_loop_msgs/ControlCommand", RELIABLE)
    heard: list = []

    def enough() -> bool:
        heard.extend(reader.take(100))
        return len(heard) >= PERMITS

    until(enough, f"{PERMITS} permits", 15.0)
    numbers = [permit.sequence for permit in heard]
    lost = sum(after - before - 1 for before, after in zip(numbers, numbers[1:]))
    check(numbers == sorted(set(numbers)) and lost == 0, f"{lost} lost, or twice, or in another order")
    stamps = [permit.header.stamp.sec + permit.header.stamp.nanosec * 1e-9 for permit in heard]
    usual_s = median(after - before for before, after in zip(stamps, stamps[1:]))
    check(abs(usual_s / PERIOD_S - 1.0) < 0.1, f"{1 / usual_s:.2f} Hz")
    return f"{1 / usual_s:.2f} Hz, {lost} of {len(heard)} lost"


def recorded(domain: int) -> str:
    """What is said reliably at 1 kHz is recorded: each message once, in its order."""
    with tempfile.TemporaryDirectory() as folder:
        return counted(domain, Path(folder) / "bag")


def counted(domain: int, bag: Path) -> str:
    peer = Peer(domain)
    words = ["-p", f"bag_dir:={bag}", "-p", "topics:=[printer/motion]"]
    node = Node("bag_recorder", ["bag_recorder.param.yaml"], *words, ROS_DOMAIN_ID=domain)
    moves = peer.writer("/printer/printer/motion", "fdm_loop_msgs/MotionSegment", RELIABLE)
    reports = peer.reader("/diagnostics", "diagnostic_msgs/DiagnosticArray")
    until(lambda: matched(moves), "the recorder listens")
    message = value(DEFINITIONS.message("fdm_loop_msgs/MotionSegment"), [0])
    begin = time.monotonic()
    for number in range(SENT):
        message.line = number
        moves.write(message)
        time.sleep(max(0.0, begin + (number + 1) * PACE_S - time.monotonic()))
    rate_hz = SENT / (time.monotonic() - begin)

    def written() -> int:
        values = [one for report in reports.take(1000) for status in report.status for one in status.values]
        return max((int(one.value) for one in values if one.key == "/printer/printer/motion written"), default=0)

    until(lambda: written() >= SENT, f"{SENT} recorded")
    check(node.end() == 0, "an orderly end")
    lines = []
    for path in sorted(bag.glob("*.mcap")):
        with path.open("rb") as stream:
            reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
            lines += [message.line for *_, message in reader.iter_decoded_messages()]
    check(lines == list(range(SENT)), f"{len(lines)} of {SENT}, or in another order")
    return f"{len(lines)} of {SENT} at {rate_hz:.0f} Hz"


def domains(domain: int) -> str:
    """A node is in the domain of `ROS_DOMAIN_ID`, and in no other."""
    name, readers = f"apart_{time.monotonic_ns()}", {}
    for number in (domain, domain + 1):
        readers[number] = Peer(number).reader("/printer/heartbeat", "fdm_loop_msgs/Heartbeat", BEST_EFFORT)
    words = ["-r", f"__node:={name}"]
    Node("thermistor", ["thermistor.param.yaml"], *words, ROS_DOMAIN_ID=domain)
    heard = {number: 0 for number in readers}

    def enough() -> bool:
        for number, reader in readers.items():
            heard[number] += sum(beat.node == f"/printer/{name}" for beat in reader.take(100))
        return heard[domain] >= BEATS

    until(enough, f"{BEATS} beats")
    check(heard[domain + 1] == 0, f"beats by domain: {heard}")
    return f"beats by domain: {heard}"


CHECKS = {"permits": permits, "recorded": recorded, "domains": domains}


if __name__ == "__main__":
    Node.binaries = Path(sys.argv[1])
    wanted = sys.argv[3:] or list(CHECKS)
    run({name: CHECKS[name] for name in wanted}, int(sys.argv[2]))
