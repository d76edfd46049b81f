"""Writes a bag as other programs do: 500 messages of std_msgs/msg/String on /chatter.

write.py BAG mcap-lz4|mcap-zstd|mcap-none    PyPI `mcap`: a file, no metadata.yaml
write.py BAG ros2                            two files and a metadata.yaml of version 5, as `ros2 bag record` of Humble
                                             leaves them, chunks of zstd
write.py BAG rosbags|rosbags-zstd|rosbags-message
                                             PyPI `rosbags`: a file without a number; each message compressed in the last
"""

from __future__ import annotations

import sys
from pathlib import Path

from mcap.writer import CompressionType, Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Rosbag2Writer
from rosbags.rosbag2.enums import CompressionFormat, CompressionMode
from rosbags.typesys import Stores, get_typestore

MESSAGES = 500
TOPIC, TYPE = "/chatter", "std_msgs/msg/String"
# As the recorder of Humble says that a topic is latched.
NEVER = "sec: 2147483647\n    nsec: 4294967295\n"
LATCHED = (
    "- history: 3\n  depth: 0\n  reliability: 1\n  durability: 1\n"
    f"  deadline:\n    {NEVER}  lifespan:\n    {NEVER}  liveliness: 1\n  liveliness_lease_duration:\n    {NEVER}"
    "  avoid_ros_namespace_conventions: false"
)
STORE = get_typestore(Stores.ROS2_JAZZY)


def payload(number: int) -> bytes:
    """The message of a number."""
    text = f"message {number} of {MESSAGES}, " * (1 + number % 5)
    return bytes(STORE.serialize_cdr(STORE.types[TYPE](data=text), TYPE))


def log_ns(number: int) -> int:
    """Its log time."""
    return 1_700_000_000_000_000_000 + number * 1_000_000


def mcap(path: Path, numbers: range, compression: CompressionType, metadata: dict[str, str]) -> None:
    """One file by PyPI's `mcap`."""
    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=4096, compression=compression)
        writer.start(profile="ros2", library="write.py")
        schema = writer.register_schema(TYPE, "ros2msg", b"string data")
        channel = writer.register_channel(TOPIC, "cdr", schema, metadata)
        for number in numbers:
            at = log_ns(number)
            writer.add_message(channel, at, payload(number), at, number)
        writer.finish()


def described(name: str) -> str:
    """`metadata.yaml` of two files."""
    half = MESSAGES // 2
    qos = LATCHED.replace("\n", "\\n")
    files = "".join(
        f"    - path: {name}_{part}.mcap\n      starting_time: {{nanoseconds_since_epoch: {log_ns(part * half)}}}\n"
        f"      duration: {{nanoseconds: {(half - 1) * 1_000_000}}}\n      message_count: {half}\n"
        for part in range(2)
    )
    return (
        "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n"
        f"  duration: {{nanoseconds: {(MESSAGES - 1) * 1_000_000}}}\n"
        f"  starting_time: {{nanoseconds_since_epoch: {log_ns(0)}}}\n  message_count: {MESSAGES}\n"
        "  topics_with_message_count:\n    - topic_metadata:\n"
        f"        name: {TOPIC}\n        type: {TYPE}\n        serialization_format: cdr\n"
        f'        offered_qos_profiles: "{qos}"\n      message_count: {MESSAGES}\n'
        "  compression_format: \"\"\n  compression_mode: \"\"\n"
        f"  relative_file_paths:\n    - {name}_0.mcap\n    - {name}_1.mcap\n  files:\n{files}"
    )


def rosbags(bag: Path, mode: CompressionMode | None) -> None:
    """A bag by PyPI's `rosbags`."""
    writer = Rosbag2Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP)
    if mode is not None:
        writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection(TOPIC, TYPE, typestore=STORE)
        for number in range(MESSAGES):
            writer.write(connection, log_ns(number), payload(number))


def main(bag: Path, form: str) -> None:
    """Writes the bag in a form."""
    kind, _, packed = form.partition("-")
    if kind == "rosbags":
        modes = {"": None, "zstd": CompressionMode.STORAGE, "message": CompressionMode.MESSAGE}
        rosbags(bag, modes[packed])
        return
    bag.mkdir()
    if kind == "mcap":
        mcap(bag / f"{bag.name}_0.mcap", range(MESSAGES), CompressionType[packed.upper()], {})
        return
    half = MESSAGES // 2
    for part in range(2):
        path = bag / f"{bag.name}_{part}.mcap"
        numbers = range(part * half, (part + 1) * half)
        mcap(path, numbers, CompressionType.ZSTD, {"offered_qos_profiles": LATCHED})
    (bag / "metadata.yaml").write_text(described(bag.name))


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2])
