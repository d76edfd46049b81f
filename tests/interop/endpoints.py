"""Who has which endpoints: as DDS itself has discovered them, and as the nodes tell it on `ros_discovery_info`."""

from __future__ import annotations

import time
from dataclasses import dataclass, field

from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication, BuiltinTopicDcpsSubscription
from cyclonedds.idl import annotations, make_idl_struct, types

from graph import LATCHED, DataReader, Peer, Policy, Qos, check

#: Topics without a namespace by the rules of ROS: what is said there names who says it.
SHARED = {"/diagnostics", "/rosout", "/parameter_events", "/tf", "/tf_static"}
#: What topics, requests and replies of ROS begin with on DDS.
OF_ROS = ("rt", "rq", "rr")
#: Time in which discovery tells all that there is `[s]`.
DISCOVERY_S = 1.0


def is_of_ros(name: str) -> bool:
    return name.partition("/")[0] in OF_ROS


@dataclass
class Endpoints:
    """Keys of readers and writers, and the names of their topics."""

    readers: dict[bytes, str] = field(default_factory=dict)
    writers: dict[bytes, str] = field(default_factory=dict)

    def names(self) -> set[str]:
        """Topics and services of ROS."""
        return {name for name in (*self.readers.values(), *self.writers.values()) if is_of_ros(name)}


class Discovery:
    """What DDS knows of others."""

    def __init__(self, peer: Peer) -> None:
        self.own = peer.participant.guid.bytes
        self.subscriptions = BuiltinDataReader(peer.participant, BuiltinTopicDcpsSubscription)
        self.publications = BuiltinDataReader(peer.participant, BuiltinTopicDcpsPublication)

    def by_participant(self) -> dict[bytes, Endpoints]:
        """Endpoints by the key of their participant, our own left out."""
        found: dict[bytes, Endpoints] = {}
        for reader, of in ((self.subscriptions, "readers"), (self.publications, "writers")):
            for endpoint in reader.read(10_000):
                name = getattr(endpoint, "topic_name", "")
                key = getattr(endpoint, "participant_key", None)
                if name and key is not None and key.bytes != self.own:
                    getattr(found.setdefault(key.bytes, Endpoints()), of)[endpoint.key.bytes] = name
        return found


def participants(peer: Peer, namespaces: tuple[str, ...]) -> dict[str, int]:
    """Participants of each namespace. Who has a topic or service of two of them, or of none, is a failure."""
    discovery = Discovery(peer)
    time.sleep(DISCOVERY_S)
    found: dict[bytes, set[str]] = {}
    for key, endpoints in discovery.by_participant().items():
        names = {name.partition("/")[2] for name in endpoints.names()}
        own = {f"/{name.split('/')[0]}" for name in names if f"/{name}" not in SHARED}
        if own:
            found[key] = own
    mixed = {key.hex(): names for key, names in found.items() if len(names) != 1 or not names <= set(namespaces)}
    check(not mixed, f"participants with topics of both, or of none: {mixed}")
    return {name: sum(names == {name} for names in found.values()) for name in namespaces}


def discovery_info():
    """`rmw_dds_common/ParticipantEntitiesInfo`: which participant has which nodes."""
    struct = lambda name, fields: annotations.final(
        make_idl_struct(name, f"rmw_dds_common::msg::dds_::{name}_", fields)
    )
    gid = struct("Gid", {"data": types.array[types.uint8, 16]})
    node = struct(
        "NodeEntitiesInfo",
        {
            "node_namespace": types.bounded_str[256],
            "node_name": types.bounded_str[256],
            "reader_gid_seq": types.sequence[gid],
            "writer_gid_seq": types.sequence[gid],
        },
    )
    return struct("ParticipantEntitiesInfo", {"gid": gid, "node_entities_info_seq": types.sequence[node]})


class Told:
    """What participants tell of their nodes; the newest word of each counts."""

    def __init__(self, peer: Peer) -> None:
        # A node tells it anew with each of its endpoints, and the topic has no key: the depth is that of all.
        qos = Qos(*(policy for policy in LATCHED if "History" not in repr(policy)), Policy.History.KeepLast(1000))
        self.reader = DataReader(peer.subscriber, peer.topic("ros_discovery_info", discovery_info()), qos)
        self.newest: dict[bytes, list] = {}

    def by_participant(self) -> dict[bytes, list]:
        """Nodes by the gid of their participant."""
        for info in self.reader.take(1000):
            self.newest[bytes(info.gid.data)] = info.node_entities_info_seq
        return self.newest


def differences(told: dict[bytes, list], found: dict[bytes, Endpoints]) -> list[str]:
    """Endpoints that are told and not there, or there for ROS and not told, participant by participant: of
    `ros_discovery_info` itself nobody needs to tell."""
    wrong = []
    for key, endpoints in found.items():
        nodes = told.get(key, [])
        who = " ".join(node.node_name for node in nodes) or key.hex()
        for of, there in (("reader", endpoints.readers), ("writer", endpoints.writers)):
            gids = {bytes(gid.data) for node in nodes for gid in getattr(node, f"{of}_gid_seq")}
            untold = [name for gid, name in there.items() if is_of_ros(name) and gid not in gids]
            wrong += [f"{who}: {of} of {name} is not told" for name in untold]
            wrong += [f"{who}: {of} {gid.hex()} is not there" for gid in gids if gid not in there]
    return wrong
