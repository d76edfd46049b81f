"""The recorder's services and its life, asked by an independent DDS; its bag, read by independent readers.

    recorder.py BINARIES DOMAIN
"""

from __future__ import annotations

import sys
import tempfile
from collections import Counter
from pathlib import Path

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.rosbag2 import Reader

from graph import DEFINITIONS, LATCHED, RELIABLE, Node, Peer, check, matched, run, until
from ros_types import value
from user import ACTIVE, INACTIVE, Life

#: Events of a stage, and of these the severity that keeps a file.
STAGE, ERROR = 20, 2
ME = "peer"


def files(bag: Path) -> dict[str, Counter]:
    """Messages by file: events of the peer by stage, states of the supervisor's topic as `state N`."""
    found = {}
    for path in sorted(bag.glob("*.mcap")):
        with path.open("rb") as stream:
            reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
            told = Counter()
            for _, channel, _, message in reader.iter_decoded_messages():
                if channel.topic.endswith("/safety/state"):
                    told[f"state {message.sequence}"] += 1
                else:
                    told[message.what if message.who == ME else "of others"] += 1
            found[path.name] = told
    return found


class Stages:
    """Says events, so many a stage; the recorder's diagnostics tell when they have come."""

    def __init__(self, peer: Peer) -> None:
        self.events = peer.writer("/printer/events", "fdm_loop_msgs/PrintEvent")
        self.reports = peer.reader("/diagnostics", "diagnostic_msgs/DiagnosticArray")
        self.states = peer.writer("/printer/safety/state", "fdm_loop_msgs/SafetyState", LATCHED)

    def figures(self) -> dict[str, str]:
        """What the recorder told last."""
        statuses = (status for report in self.reports.take(1000) for status in report.status)
        figures = {}
        for status in statuses:
            if status.name.endswith("/bag_recorder"):
                figures = {one.key: one.value for one in status.values}
        return figures

    def matched(self) -> None:
        until(lambda: matched(self.events) and matched(self.states), "the recorder listens")

    def say(self, what: str, severity: int = 0) -> None:
        kind, header = DEFINITIONS.message("fdm_loop_msgs/PrintEvent"), DEFINITIONS.message("std_msgs/Header")
        stamp = DEFINITIONS.message("builtin_interfaces/Time")(sec=0, nanosec=0)
        for _ in range(STAGE):
            words = {"who": ME, "what": what, "why": "", "before": "", "after": ""}
            self.events.write(kind(header=header(stamp=stamp, frame_id=""), severity=severity, **words))

    def state(self, number: int) -> None:
        message = value(DEFINITIONS.message("fdm_loop_msgs/SafetyState"), [0])
        message.sequence = number
        self.states.write(message)

    def heard(self, figure: str, least: int) -> None:
        """Waits until a figure of the recorder has reached a number: what was sent is in the bag, or passed over."""
        until(lambda: int(self.figures().get(figure, 0)) >= least, f"{figure} of {least}")


def recorder(domain: int) -> str:
    """Pause, resume, record, snapshot, split and keep do what they say; an inactive recorder records nothing."""
    with tempfile.TemporaryDirectory() as folder:
        return recorded(domain, Path(folder) / "bag")


def recorded(domain: int, bag: Path) -> str:
    peer = Peer(domain)
    words = ["-p", f"bag_dir:={bag}", "-p", "topics:=[events, safety/state]", "-p", "snapshot_s:=60.0"]
    node = Node("bag_recorder", ["bag_recorder.param.yaml"], *words, ROS_DOMAIN_ID=domain)
    ask = {
        name: peer.service(f"/printer/bag_recorder/{name}", "std_srvs/Trigger")
        for name in ("record", "pause", "resume", "snapshot", "split_bagfile")
    }
    stages, life = Stages(peer), Life(peer, "/printer/bag_recorder")
    stages.matched()

    def told(name: str, message: str, success: bool = True) -> None:
        answer = ask[name]()
        check((answer.success, message in answer.message) == (success, True), f"{name}: {answer}")

    stages.state(1)
    stages.say("at once")
    stages.heard("written", STAGE + 1)
    told("resume", "recording already")
    told("pause", "paused")
    stages.say("while paused")
    stages.heard("passed_over", STAGE)
    told("snapshot", "a file of their own")
    stages.heard("files_kept", 1)
    stages.say("forgotten")
    stages.heard("passed_over", 2 * STAGE)
    told("resume", "recording")
    stages.say("resumed")
    stages.heard("written", 3 * STAGE + 1)
    told("record", "a new file")
    stages.say("recorded")
    stages.heard("written", 4 * STAGE + 1)
    told("split_bagfile", "a new file")
    # An event of this severity keeps its file and the one before, whatever the disk asks for.
    stages.say("trouble", ERROR)
    stages.heard("files_kept", 3)

    check(life.state() == ACTIVE and life.to(4) and life.state() == INACTIVE, "deactivate")
    stages.matched()
    for number in (2, 3):
        stages.state(number)
    stages.say("while inactive")
    check(life.to(3) and life.state() == ACTIVE, "activate")
    stages.figures()  # of the life before
    stages.say("active again")
    stages.heard("written", STAGE + 1)
    check(node.end() == 0, "an orderly end")
    return judged(bag)


def judged(bag: Path) -> str:
    found = files(bag)
    by_stage = {stage: [name for name, stages in found.items() if stages[stage]] for stage in all_stages(found)}
    counts = sum(found.values(), Counter())
    wanted = ("at once", "while paused", "resumed", "recorded", "trouble", "active again")
    check({stage: counts[stage] for stage in wanted} == dict.fromkeys(wanted, STAGE), f"{counts}")
    check(not counts["forgotten"] and not counts["while inactive"], f"what nobody asked for: {counts}")
    homes = [by_stage[stage] for stage in wanted]
    check(all(len(home) == 1 for home in homes) and len({home[0] for home in homes}) == len(wanted), f"{by_stage}")
    # Of a latched topic the state that holds when recording begins belongs to the bag, and no earlier one.
    check((counts["state 2"], counts["state 3"]) == (0, 1) and by_stage["state 3"] == homes[-1], f"{by_stage}")
    kept = {path.name.split(".")[0] for path in bag.iterdir() if "keep" in path.name}
    check({homes[1][0], homes[4][0]} <= {f"{name}.mcap" for name in kept}, f"{kept} of {by_stage}")
    with Reader(bag) as reader:
        check(reader.message_count == sum(counts.values()), f"rosbags: {reader.message_count} of {counts}")
    return f"{sum(counts.values())} messages in {len(found)} files"


def all_stages(found: dict[str, Counter]) -> set[str]:
    return {stage for stages in found.values() for stage in stages}


if __name__ == "__main__":
    Node.binaries = Path(sys.argv[1])
    run({"recorder": recorder}, int(sys.argv[2]))
