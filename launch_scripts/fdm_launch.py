"""What the launch files share: folders, parameter files of the nodes, how a node is started.

They run in a clone (`ros2 launch launch_scripts/sim.launch.py`) and installed (`ros2 launch fdm_loop sim.launch.py`).
"""

import os
import re
import time

from launch.actions import DeclareLaunchArgument, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

HERE = os.path.dirname(os.path.abspath(__file__))
if HERE.endswith(os.path.join("share", "fdm_loop", "launch")):
    PREFIX = os.path.dirname(os.path.dirname(os.path.dirname(HERE)))
    CONFIG = os.path.join(PREFIX, "share", "fdm_loop", "config")
    BIN = os.path.join(PREFIX, "lib", "fdm_loop")
else:
    ROOT = os.path.dirname(HERE)
    CONFIG = os.path.join(ROOT, "config")
    BIN = os.path.join(ROOT, "target", "release")

# The namespace whose clock is the domain's: tools that follow simulated time look for /clock.
DEFAULT_NAMESPACE = "/printer"

# name, default, description, allowed values: of every launch file
FOLDERS = [
    ("namespace", DEFAULT_NAMESPACE, "namespace of the printer", None),
    ("config", CONFIG, "folder with the parameter files", None),
    ("bin", BIN, "folder with the programs", None),
]
BAG = ("bag", "", "folder of the bag, which must be new; empty: bags/<name>-<time>-<what runs>", None)
ADVANCES = ["none", "file", "material", "planned", "predicted"]


def declared(arguments):
    return [
        DeclareLaunchArgument(name, default_value=default, description=description, choices=choices)
        for name, default, description, choices in arguments
    ]


def chosen_of(arguments, context):
    chosen = {name: LaunchConfiguration(name).perform(context) for name, *_ in arguments}
    check_namespace(chosen["namespace"])
    return chosen


def check_namespace(namespace):
    """As the nodes do, before any is started."""
    if re.fullmatch(r"/|(/[A-Za-z_][A-Za-z0-9_]*)+", namespace):
        return
    parts = [re.sub("[^A-Za-z0-9_]", "_", part) for part in namespace.split("/") if part]
    meant = "".join(f"/_{part}" if part[0].isdigit() else f"/{part}" for part in parts) or DEFAULT_NAMESPACE
    fault = (
        "each part of it has letters, digits and _ alone and begins with no digit"
        if namespace.startswith("/")
        else "begins with no /"
    )
    raise RuntimeError(f"namespace:={namespace}: {fault}: write {meant}")


def number(chosen, name, low, high, kind=float):
    """An argument as a number in its range."""
    try:
        value = kind(chosen[name])
    except ValueError:
        value = None
    if value is None or not low <= value <= high:
        what = "a whole number" if kind is int else "a number"
        raise RuntimeError(f"{name}:={chosen[name]}: must be {what} in [{low}, {high}]")
    return value


def files_of(node, config, material):
    """Parameter files of a node in the order in which they are merged."""
    own = [f"{node}.param.yaml"]
    nominal = ["printers/ender3.yaml", f"materials/{material.lower()}.yaml"]
    more = {
        "state_estimator": nominal,
        "mpc_controller": nominal,
        "defect_classifier": ["quality.yaml"] + nominal,
        "advance_predictor": ["advance/physics.yaml"],
        "printer_sim": ["plants/ender3.yaml", "printers/ender3_motion.yaml", "quality.yaml"]
        + nominal[1:],
    }
    return [os.path.join(config, name) for name in own + more.get(node, [])]


def models_of(node, config, material):
    """Networks by the path at which they stand, wherever a node is started."""
    models = os.path.join(os.path.abspath(config), "models")
    networks = {
        "defect_classifier": {"network": "toolhead.json", "edge": "road_edge.json"},
        "advance_predictor": {
            "bowden": "advance_bowden.json", "direct": "advance_direct.json", "turn": "turn.json"
        },
    }.get(node, {})
    values = {f"models.{name}": os.path.join(models, file) for name, file in networks.items()}
    return {"polymer": material.upper(), **values} if node == "advance_predictor" else values


def check_material(material, config):
    known = sorted(file[:-5] for file in os.listdir(os.path.join(config, "materials")) if file.endswith(".yaml"))
    if material.lower() not in known:
        raise RuntimeError(f"material:={material}: there are {', '.join(known)}")


def new_bag(chosen, name, what):
    """Absolute path of the bag."""
    bag = os.path.abspath(chosen["bag"] or os.path.join("bags", f"{name}-{int(time.time())}-{what}"))
    if os.path.isdir(bag) and os.listdir(bag):
        raise RuntimeError(f"bag:={bag}: the folder is there and not empty")
    return bag


def beside(bag, started):
    """What is started, with the folder of the nodes' own files beside the bag: where all is well up to here."""
    os.makedirs(bag + "_logs", exist_ok=True)
    return started


def program(name, chosen):
    path = os.path.join(chosen["bin"], name)
    if not os.path.isfile(path):
        raise RuntimeError(f"{path} is missing: build all programs with `cargo build --release --workspace --bins`")
    return path


def node(name, chosen, material, values, over=()):
    """A node as a process, with the parameter files `over` on top of its own. A simulated printer that was started again
    would begin its file anew: it is not."""
    simulated = name == "printer_sim"
    files = files_of(name, chosen["config"], material) + [os.path.join(chosen["config"], file) for file in over]
    values = {**models_of(name, chosen["config"], material), **values}
    return Node(
        executable=program(name, chosen),
        name=name,
        namespace=chosen["namespace"],
        parameters=files + ([values] if values else []),
        # The time of one simulated printer is not that of another in the same domain.
        remappings=[] if chosen["namespace"] == DEFAULT_NAMESPACE else [("/clock", f"{chosen['namespace'].rstrip('/')}/clock")],
        ros_arguments=["--log-level", "info"],
        output="screen",
        respawn=not simulated,
        respawn_delay=0.5,
        additional_env={} if simulated else {"FDM_STARTED_AGAIN": "1"},
        on_exit=Shutdown(reason="the simulated printer has ended") if simulated else None,
    )
