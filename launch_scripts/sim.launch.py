"""The whole graph on the simulated printer, as `fdm up` starts it.

    ros2 launch launch_scripts/sim.launch.py gcode:=tests/data/gcode/prusa_cube_pla_marlin_relE.gcode speed:=4.0

What `fdm up` does beyond: it checks every parameter file before anything runs, waits for the end of the print and
prints its figures. Here the graph runs until Ctrl-C or until the printer ends.
"""

import os
import time

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))

# Who records and who guards come first. A printer that was started again would begin its file anew: it is not.
NODES = [
    "bag_recorder",
    "safety_supervisor",
    "thermistor",
    "imu",
    "camera",
    "filament_encoder",
    "state_estimator",
    "defect_classifier",
    "mpc_controller",
    "printer_sim",
]

# name, default, description, allowed values
ARGUMENTS = [
    ("gcode", None, "G-code file to print", None),
    ("scenario", "nominal", "scenario of config/scenarios, or a path to one", None),
    ("control", "mpc", "control level", ["off", "encoder", "mpc"]),
    ("mode", "act", "mode of the supervisor", ["observe", "advise", "act"]),
    ("host", "native", "host profile", ["native", "serial"]),
    ("material", "PLA", "material of the file: a name in config/materials", None),
    ("speed", "1.0", "simulated over wall time, 0.1 to 20", None),
    ("layers", "0", "print only the first layers; 0: all", None),
    ("warm", "false", "start with hot end and bed at the file's set-points", ["true", "false"]),
    ("seed", "1", "seed of all noise", None),
    ("namespace", "/printer", "namespace of the printer", None),
    ("bag", "", "folder of the bag, which must be new; empty: bags/<file>-<time>-<control>", None),
    ("config", os.path.join(ROOT, "config"), "folder with the parameter files", None),
    ("bin", os.path.join(ROOT, "target", "release"), "folder with the node binaries", None),
]


def files_of(node, config, material):
    """Parameter files of a node in the order in which they are merged."""
    own = [f"{node}.param.yaml"]
    nominal = ["printers/ender3.yaml", f"materials/{material.lower()}.yaml"]
    more = {
        "state_estimator": nominal,
        "mpc_controller": nominal,
        "defect_classifier": ["quality.yaml"] + nominal,
        "printer_sim": ["plants/ender3.yaml", "printers/ender3.yaml", "printers/ender3_motion.yaml", "quality.yaml"]
        + nominal[1:],
    }
    return [os.path.join(config, name) for name in own + more.get(node, [])]


def overrides_of(node, chosen, bag):
    """Parameters that the arguments decide."""
    logs = bag + "_logs"
    values = {
        "bag_recorder": {"bag_dir": bag},
        "safety_supervisor": {"start_mode": chosen["mode"], "latch_file": os.path.join(logs, "latch.json")},
        "defect_classifier": {
            "models.network": os.path.join(chosen["config"], "models", "toolhead.json"),
            "models.edge": os.path.join(chosen["config"], "models", "road_edge.json"),
        },
        "mpc_controller": {"control": chosen["control"]},
        "printer_sim": {
            "run.gcode": os.path.abspath(chosen["gcode"]),
            "run.scenario": scenario_path(chosen["scenario"], chosen["config"]),
            "run.seed": int(chosen["seed"]),
            "run.speed": float(chosen["speed"]),
            "run.layers": int(chosen["layers"]),
            "run.warm": chosen["warm"] == "true",
            "run.material_set_points": False,
            "run.allow_fault_injection": False,
            "run.config_file": "",
            "simulator.host": chosen["host"],
            # Frames in place of the stand-in that gives the road's width.
            "camera.enabled": True,
            "simulator.width_period_s": 0.0,
        },
    }.get(node, {})
    # The simulated printer makes the time that the others follow.
    return values if node == "printer_sim" else {**values, "use_sim_time": True}


def scenario_path(name, config):
    path = name if name.endswith(".yaml") else os.path.join(config, "scenarios", f"{name}.yaml")
    return os.path.abspath(path)


def nodes(context):
    chosen = {name: LaunchConfiguration(name).perform(context) for name, *_ in ARGUMENTS}
    if not os.path.isfile(chosen["gcode"]):
        raise RuntimeError(f"gcode:={chosen['gcode']}: no such file")
    stem = os.path.splitext(os.path.basename(chosen["gcode"]))[0]
    bag = chosen["bag"] or os.path.join("bags", f"{stem}-{int(time.time())}-{chosen['control']}")
    bag = os.path.abspath(bag)
    if os.path.isdir(bag) and os.listdir(bag):
        raise RuntimeError(f"bag:={bag}: the folder is there and not empty")
    os.makedirs(bag + "_logs", exist_ok=True)
    started = []
    for name in NODES:
        program = os.path.join(chosen["bin"], name)
        if not os.path.isfile(program):
            raise RuntimeError(f"{program} is missing: build all nodes with `cargo build --release`")
        printer = name == "printer_sim"
        started.append(
            Node(
                executable=program,
                name=name,
                namespace=chosen["namespace"],
                parameters=files_of(name, chosen["config"], chosen["material"]) + [overrides_of(name, chosen, bag)],
                ros_arguments=["--log-level", "info"],
                output="screen",
                respawn=not printer,
                respawn_delay=0.5,
                additional_env={} if printer else {"FDM_STARTED_AGAIN": "1"},
                on_exit=Shutdown(reason="the simulated printer has ended") if printer else None,
            )
        )
    return started


def generate_launch_description():
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=description, choices=choices)
        for name, default, description, choices in ARGUMENTS
    ]
    return LaunchDescription(declared + [OpaqueFunction(function=lambda context: nodes(context))])
