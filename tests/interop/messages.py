"""Every message type of every topic both ways between `cyclonedds` and our nodes, bytes equal to those of `rosbags`.

    messages.py BINARIES DOMAIN        with the mirror's executable in FDM_INTEROP_MIRROR
"""

from __future__ import annotations

import os
import subprocess
import sys
import time

from cyclonedds import _clayer
from cyclonedds.core import InstanceState, SampleState, ViewState
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from graph import BEST_EFFORT, DEFINITIONS, LATCHED, RELIABLE, Node, Peer, check, matched, run, until
from ros_types import value

#: Of each type; the last one is extreme.
SAMPLES = 4
#: Of all that the mirror hears, what is offered best effort.
BEST_EFFORT_TOPICS = {"/in/clock", "/in/heartbeat", "/in/printer/report/filament", "/in/printer/report/temperature"}
ANY = SampleState.Any | ViewState.Any | InstanceState.Any


def typestore():
    """Our own definitions beside those that `rosbags` has."""
    store = get_typestore(Stores.ROS2_JAZZY)
    for name, text in DEFINITIONS.texts.items():
        package, base = name.split("/")
        if f"{package}/msg/{base}" not in store.fielddefs:
            store.register(get_types_from_msg(text, f"{package}/msg/{base}"))
    return store


def by_rosbags(store, name: str, message) -> bytes:
    """The bytes that `rosbags` makes of the same value, field by field by its name."""
    import numpy

    def convert(kind: str, of):
        fields = store.fielddefs[kind][1]
        made = {}
        for field, (node, detail) in fields:
            part = getattr(of, field)
            if node == 1 and detail[0] == "byte":  # an octet, which `rosbags` takes for a signed number
                part = part - 256 if part > 127 else part
            elif node == 2:  # a message
                part = convert(detail, part)
            elif node in (3, 4):  # an array or a sequence
                inner, inner_detail = detail[0]
                if inner == 2:
                    part = [convert(inner_detail, one) for one in part]
                elif inner_detail[0] != "string":
                    part = numpy.array(list(part), dtype={"byte": "uint8"}.get(inner_detail[0], inner_detail[0]))
                else:
                    part = list(part)
            made[field] = part
        return store.types[kind](**made)

    package, base = name.split("/")
    kind = f"{package}/msg/{base}"
    return bytes(store.serialize_cdr(convert(kind, message), kind))


def raw(reader) -> list[bytes]:
    """Messages as they came over the wire."""
    return [bytes(data) for data, info in _clayer.ddspy_take(reader._ref, ANY, 100) if info.valid_data]


def holds(data: bytes, message: bytes) -> bool:
    """Whether these are the bytes of a message behind their header, made up to a multiple of four with zeros and no more."""
    rest = data[len(message):]
    return data[4 : len(message)] == message[4:] and len(rest) < 4 and not any(rest)


def messages(domain: int) -> str:
    # The test's own executable: with the variable set, its only test is the mirror.
    command = [os.environ["FDM_INTEROP_MIRROR"], "--nocapture"]
    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain), "FDM_INTEROP_ROLE": "mirror"}
    process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        return reflected(domain, process)
    finally:
        process.kill()
        process.wait()


def reflected(domain: int, process) -> str:
    peer, store, pairs = Peer(domain), typestore(), []
    for line in process.stdout:
        words = line.split()
        if words[-2:] == ["mirror", "end"]:
            break
        if "mirror" in words[:-4]:
            words = words[words.index("mirror"):]
        if len(words) == 5 and words[0] == "mirror":
            pairs.append(words[1:])
    kinds = {kind for _, _, kind, _ in pairs}
    # Who subscribes as ROS does by default hears all but beats, simulated time and what the bridge tells sensor nodes.
    unreliable = {heard for heard, _, _, offered in pairs if offered != "Reliable"}
    check(unreliable == BEST_EFFORT_TOPICS, f"offered best effort: {unreliable}")
    own = {name for name in DEFINITIONS.texts if name.startswith("fdm_loop_msgs/")}
    check(own <= kinds, f"no topic carries {own - kinds}")
    compared = 0
    for heard, said, kind, offered in pairs:
        qos = RELIABLE if offered == "Reliable" else BEST_EFFORT
        reader, writer = peer.reader(said, kind, qos), peer.writer(heard, kind, LATCHED)
        until(lambda: matched(writer) and matched(reader), f"both ends of {heard}")
        for sample in range(SAMPLES):
            message = value(DEFINITIONS.message(kind), [1000 * sample], extreme=sample == SAMPLES - 1)
            theirs = by_rosbags(store, kind, message)
            ours = bytes(message.serialize())
            check(holds(ours, theirs), f"{kind}: cyclonedds and rosbags differ: {ours.hex()}, {theirs.hex()}")

            def comes_back() -> bool:
                # Sensor topics are read best effort, and the mirror may find both ends later than we do: asked again.
                writer.write(message)
                deadline = time.monotonic() + 0.3
                while time.monotonic() < deadline:
                    if any(holds(data, theirs) for data in raw(reader)):
                        return True
                    time.sleep(0.005)
                return False

            until(comes_back, f"{kind} on {said}")
            compared += 1
    return f"{compared} messages of {len(kinds)} types on {len(pairs)} topics"


if __name__ == "__main__":
    run({"messages": messages}, int(sys.argv[2]))
