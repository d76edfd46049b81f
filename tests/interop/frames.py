"""One tree of frames: what `/tf_static` and `/tf` say together, and every frame that a message of a sensor names.

    frames.py BINARIES DOMAIN
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

from graph import BEST_EFFORT, LATCHED, RELIABLE, ROOT, Node, Peer, check, run, until

PRINTER = ["plants/ender3.yaml", "printers/ender3_motion.yaml", "quality.yaml", "materials/pla.yaml"]
ROOT_FRAME = "printer"
PARTS = {"printer", "bed", "toolhead", "nozzle", "hotend", "camera_optical", "imu"}
#: Topics that name a frame: `sensor_msgs` as the tools know them, and our own beside them.
FRAMED = {
    "sensors/hotend/temperature": "sensor_msgs/Temperature",
    "sensors/bed/temperature": "sensor_msgs/Temperature",
    "sensors/imu/data_raw": "sensor_msgs/Imu",
    "sensors/imu/batch": "fdm_loop_msgs/ImuBatch",
    "sensors/camera/camera_info": "sensor_msgs/CameraInfo",
    "sensors/camera/image_raw/compressed": "sensor_msgs/CompressedImage",
}


def add(tree: dict[str, str], transforms) -> None:
    """Child and parent of each transform; a child with two parents is a failure."""
    for one in transforms:
        child, parent = one.child_frame_id, one.header.frame_id
        check(child and parent and child != parent, f"{child} hangs on {parent}")
        check(tree.setdefault(child, parent) == parent, f"{child} hangs on {tree[child]} and on {parent}")
        turn = one.transform.rotation
        length = math.sqrt(sum(part * part for part in (turn.x, turn.y, turn.z, turn.w)))
        check(abs(length - 1.0) < 1e-9, f"{child}: a rotation of length {length}")
        place = one.transform.translation
        check(all(math.isfinite(part) for part in (place.x, place.y, place.z)), f"{child}: {place}")


def way_up(tree: dict[str, str], frame: str) -> list[str]:
    """From a frame to its root; a cycle is a failure."""
    way = [frame]
    while way[-1] in tree:
        way.append(tree[way[-1]])
        check(len(way) <= len(tree) + 1, f"a cycle: {way}")
    return way


def frames(domain: int) -> str:
    """One root, no cycle, one parent each; whatever a message names is in the tree."""
    peer = Peer(domain)
    gcode = ROOT / "tests/data/gcode/prusa_cube_pla_marlin_relE.gcode"
    words = [f'run.gcode:="{gcode}"', "run.warm:=true", "run.layers:=2", "camera.enabled:=true", "run.speed:=2.0"]
    parameters = [word for one in words for word in ("-p", one)]
    Node("printer_sim", ["printer_sim.param.yaml", *PRINTER], *parameters, ROS_DOMAIN_ID=domain)
    for name in ("thermistor", "imu", "camera"):
        Node(name, [f"{name}.param.yaml"], "-p", "use_sim_time:=true", ROS_DOMAIN_ID=domain)
    fixed = peer.reader("/tf_static", "tf2_msgs/TFMessage", LATCHED)
    moving = peer.reader("/tf", "tf2_msgs/TFMessage", RELIABLE)
    sensors = {topic: peer.reader(f"/printer/{topic}", kind, BEST_EFFORT) for topic, kind in FRAMED.items()}
    tree, named = {}, {}

    def look() -> bool:
        for reader in (fixed, moving):
            for message in reader.take(1000):
                add(tree, message.transforms)
        for topic, reader in sensors.items():
            named.update((topic, message.header.frame_id) for message in reader.take(1000))
        return PARTS <= tree.keys() | set(tree.values()) and named.keys() == sensors.keys()

    try:
        until(look, "the whole tree and a message of each sensor", 20.0)
    finally:
        print(f"  tree {tree}, named {named}", flush=True)
    roots = {way_up(tree, frame)[-1] for frame in tree}
    check(roots == {ROOT_FRAME}, f"roots {roots}")
    check(tree.keys() | set(tree.values()) == PARTS, f"parts {tree}")
    check(set(named.values()) <= PARTS, f"frames that are in no tree: {named}")
    late = peer.reader("/tf_static", "tf2_msgs/TFMessage", LATCHED)
    again: dict[str, str] = {}
    until(lambda: [add(again, message.transforms) for message in late.take(10)], "/tf_static for a late joiner")
    check(again == {child: parent for child, parent in tree.items() if child != "toolhead"}, f"{again} of {tree}")
    return f"{len(tree)} frames under {ROOT_FRAME}, {len(named)} topics"


if __name__ == "__main__":
    Node.binaries = Path(sys.argv[1])
    run({"frames": frames}, int(sys.argv[2]))
