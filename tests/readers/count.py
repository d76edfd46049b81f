"""Counts the messages of a bag with two independent readers and prints them as JSON.

count.py BAG            whole bag: `rosbags` through metadata.yaml, `mcap` with `mcap_ros2` file by file; every message
                        is decoded with the schema that the bag holds
count.py --active FILE  whole records of a file that a killed recorder left
"""

from __future__ import annotations

import json
import struct
import sys
from collections import Counter
from pathlib import Path

from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Channel, Message
from mcap.stream_reader import StreamReader
from mcap_ros2.decoder import DecoderFactory
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore


def with_rosbags(bag: Path) -> dict[str, object]:
    """Counts per topic, the counts that metadata.yaml declares, and types that differ from the reader's own."""
    own, seen = get_typestore(Stores.ROS2_JAZZY), get_typestore(Stores.EMPTY)
    counts: Counter[str] = Counter()
    declared: Counter[str] = Counter()
    with Reader(bag) as reader:
        for connection in reader.connections:
            declared[connection.topic] += connection.msgcount
            seen.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
        for connection, _, data in reader.messages():
            seen.deserialize_cdr(data, connection.msgtype)
            counts[connection.topic] += 1
        differing = [
            name
            for name in seen.fielddefs
            if name in own.fielddefs
            and seen.generate_msgdef(name, ros_version=2)[1] != own.generate_msgdef(name, ros_version=2)[1]
        ]
        total = reader.message_count
    return {"counts": counts, "declared": declared, "total": total, "differing": differing}


def with_mcap(bag: Path) -> dict[str, object]:
    """Counts per topic, counts per file, and the newest `fdm_loop` record."""
    counts: Counter[str] = Counter()
    files: dict[str, int] = {}
    note: dict[str, str] = {}
    for path in sorted(bag.glob("*.mcap")):
        with path.open("rb") as stream:
            reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
            topics = [channel.topic for _, channel, _, _ in reader.iter_decoded_messages()]
            counts.update(topics)
            files[path.name] = len(topics)
            for record in reader.iter_metadata():
                note.update(record.metadata if record.name == "fdm_loop" else {})
    return {"counts": counts, "files": files, "note": note}


def active(path: Path) -> Counter[str]:
    """Counts per topic of the records up to the first that is not whole."""
    topics: dict[int, str] = {}
    counts: Counter[str] = Counter()
    with path.open("rb") as stream:
        try:
            for record in StreamReader(stream).records:
                if isinstance(record, Channel):
                    topics[record.id] = record.topic
                elif isinstance(record, Message):
                    counts[topics[record.channel_id]] += 1
        except (McapError, struct.error):
            pass  # the record that was being written
    return counts


if __name__ == "__main__":
    if sys.argv[1] == "--active":
        print(json.dumps(active(Path(sys.argv[2]))))
    else:
        folder = Path(sys.argv[1])
        print(json.dumps({"rosbags": with_rosbags(folder), "mcap": with_mcap(folder)}))
