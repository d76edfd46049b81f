"""Node processes, and a participant of PyPI `cyclonedds` that speaks to them as ROS 2 on Cyclone DDS does."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
#: Loopback without multicast, as a host without a network has it; participants find each other by their ports.
CYCLONE = (
    '<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>'
    "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
    '<MaxAutoParticipantIndex>60</MaxAutoParticipantIndex><Peers><Peer Address="127.0.0.1"/></Peers></Discovery>'
    "</Domain></CycloneDDS>"
)
MULTICAST = (
    '<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo" multicast="true"/></Interfaces>'
    "</General></Domain></CycloneDDS>"
)
os.environ["CYCLONEDDS_URI"] = MULTICAST if "FDM_INTEROP_MULTICAST" in os.environ else CYCLONE

from cyclonedds.core import InstanceState, Qos, Policy, SampleState, ViewState  # noqa: E402
from cyclonedds.domain import DomainParticipant  # noqa: E402
from cyclonedds.pub import DataWriter, Publisher  # noqa: E402
from cyclonedds.sub import DataReader, Subscriber  # noqa: E402
from cyclonedds.topic import Topic  # noqa: E402
from cyclonedds.util import duration  # noqa: E402

from ros_types import Definitions  # noqa: E402

#: Longest wait for what has to come `[s]`.
PATIENCE_S = 10.0
#: A server that was just found needs this long until both ends are matched `[s]`.
MATCHING_S = 0.15
#: Lines of a node that are kept for a failure.
LINES = 20
DEFINITIONS = Definitions()

BEST_EFFORT = Qos(Policy.Reliability.BestEffort, Policy.Durability.Volatile, Policy.History.KeepLast(10))
RELIABLE = Qos(
    Policy.Reliability.Reliable(duration(seconds=1)), Policy.Durability.Volatile, Policy.History.KeepLast(1000)
)
LATCHED = Qos(
    Policy.Reliability.Reliable(duration(seconds=1)), Policy.Durability.TransientLocal, Policy.History.KeepLast(1)
)


class Failed(Exception):
    """A check that did not hold."""


def check(holds: bool, what: str) -> None:
    if not holds:
        raise Failed(what)


def until(found, what: str, limit_s: float = PATIENCE_S):
    """The first true answer of `found`, or a failure."""
    deadline = time.monotonic() + limit_s
    while time.monotonic() < deadline:
        answer = found()
        if answer:
            return answer
        time.sleep(0.01)
    raise Failed(f"not within {limit_s} s: {what}")


class Peer:
    """The participant."""

    def __init__(self, domain: int) -> None:
        self.participant = DomainParticipant(domain)
        self.publisher, self.subscriber = Publisher(self.participant), Subscriber(self.participant)
        self.topics: dict[str, Topic] = {}

    def topic(self, name: str, kind: type) -> Topic:
        if name not in self.topics:
            self.topics[name] = Topic(self.participant, name, kind)
        return self.topics[name]

    def reader(self, name: str, kind: str, qos: Qos = RELIABLE) -> DataReader:
        return DataReader(self.subscriber, self.topic(f"rt{name}", DEFINITIONS.message(kind)), qos)

    def writer(self, name: str, kind: str, qos: Qos = RELIABLE) -> DataWriter:
        return DataWriter(self.publisher, self.topic(f"rt{name}", DEFINITIONS.message(kind)), qos)

    def service(self, name: str, kind: str) -> "Service":
        return Service(self, name, kind)


def matched(entity) -> int:
    status = entity.get_publication_matched_status() if isinstance(entity, DataWriter) else (
        entity.get_subscription_matched_status()
    )
    return status.current_count


class Service:
    """Calls of a service in the mapping of Cyclone's RMW: identity and number stand in front of the payload."""

    header = True

    def __init__(self, peer: Peer, name: str, kind: str) -> None:
        self.name, self.request = name, DEFINITIONS.service(kind, "Request", self.header)
        response = DEFINITIONS.service(kind, "Response", self.header)
        qos = Qos(
            Policy.Reliability.Reliable(duration(seconds=1)), Policy.Durability.Volatile, Policy.History.KeepLast(10)
        )
        self.writer = DataWriter(peer.publisher, peer.topic(f"rq{name}Request", self.request), qos)
        self.reader = DataReader(peer.subscriber, peer.topic(f"rr{name}Reply", response), qos)
        self.guid, self.number = random.getrandbits(64), 0

    def wait(self, limit_s: float = PATIENCE_S) -> "Service":
        if not self.number:
            until(lambda: matched(self.writer) and matched(self.reader), f"a server of {self.name}", limit_s)
            # The server may find the reader of its answers a little later: what it says before is lost.
            time.sleep(MATCHING_S)
        return self

    def __call__(self, limit_s: float = PATIENCE_S, **fields):
        self.wait(limit_s)
        self.number += 1
        if not fields and "structure_needs_at_least_one_member" in self.request.__annotations__:
            fields = {"structure_needs_at_least_one_member": 0}
        if self.header:
            fields |= {"guid": self.guid, "sequence_number": self.number}
        self.writer.write(self.request(**fields))

        def answer():
            if not self.header:
                return next(iter(self.reader.take(1)), None)
            mine = (self.guid, self.number)
            return next((r for r in self.reader.take(10) if (r.guid, r.sequence_number) == mine), None)

        return until(answer, f"an answer of {self.name}", limit_s)


class PlainService(Service):
    """The same as Fast DDS has it: who asked stands in the protocol's own header, which is not read here. What came before
    a call is the first word of a server, which is nobody's, or an answer that was given up; what comes after is its own.
    """

    header = False

    def __call__(self, limit_s: float = PATIENCE_S, **fields):
        self.wait(limit_s)
        self.reader.take(100)
        return super().__call__(limit_s, **fields)


class Node:
    """A node process; none outlives the test."""

    running: list["Node"] = []
    binaries = Path()

    def __init__(self, name: str, files: list[str], *words: str, cyclone: bool = True, program: str = "", **variables):
        self.name = name
        arguments = [str(self.binaries / (program or name)), "--ros-args"]
        for file in files:
            arguments += ["--params-file", str(ROOT / "config" / file)]
        environment = {**os.environ, **{key: str(value) for key, value in variables.items()}}
        environment.pop("RUST_LOG", None)
        environment["RMW_IMPLEMENTATION"] = "rmw_cyclonedds_cpp" if cyclone else "rmw_fastrtps_cpp"
        self.arguments, self.environment = [*arguments, *words], environment
        self.start()
        Node.running.append(self)

    def start(self) -> None:
        self.process = subprocess.Popen(
            self.arguments, env=self.environment, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
            errors="replace",
        )
        # A pipe that nobody empties is full after 64 KiB: what is told then is lost, also to who looks for a failure.
        self.said: deque[str] = deque(maxlen=LINES)
        self.reading = threading.Thread(target=self.said.extend, args=(self.process.stderr,), daemon=True)
        self.reading.start()

    def words(self) -> list[str]:
        """What a process that has ended has said last."""
        self.reading.join(1.0)
        return list(self.said)

    def signal(self, number: int) -> None:
        self.process.send_signal(number)

    def end(self, limit_s: float = 5.0) -> int:
        """SIGINT, as launch sends it: the exit code."""
        self.signal(signal.SIGINT)
        return self.process.wait(limit_s)

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()


def run(checks: dict, domain: int) -> None:
    """Runs checks by name, each with processes of its own; ends with code 1 where one does not hold."""
    failed = 0
    for name, checked in checks.items():
        begin = time.monotonic()
        try:
            told = checked(domain)
        except (Failed, subprocess.TimeoutExpired) as error:
            failed += 1
            told = f"FAILED: {error}"
        finally:
            for node in Node.running:
                if node.process.poll() is None:
                    node.kill()
        if str(told).startswith("FAILED"):
            for node in Node.running:
                sys.stderr.writelines(f"{node.name}: {line}" for line in node.words())
        Node.running.clear()
        print(f"{name}: {told or 'ok'} ({time.monotonic() - begin:.1f} s)", flush=True)
    sys.exit(1 if failed else 0)
