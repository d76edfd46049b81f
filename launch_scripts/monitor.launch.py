"""The graph beside a real printer: `printer_bridge` in place of the simulated printer, on the machine's own time.

    ros2 launch fdm_loop monitor.launch.py device:=/dev/serial/by-id/usb-...

The bridge reads and sends no commands yet, whatever the mode. systemd starts the same nodes with the same files, see
launch_scripts/systemd. Runs until Ctrl-C.
"""

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import fdm_launch  # noqa: E402
from launch import LaunchDescription  # noqa: E402
from launch.actions import OpaqueFunction  # noqa: E402

# Who records and who guards come first; the advance predictor where it is asked for alone.
NODES = [
    "bag_recorder",
    "safety_supervisor",
    "printer_bridge",
    "thermistor",
    "imu",
    "camera",
    "filament_encoder",
    "state_estimator",
    "defect_classifier",
    "advance_predictor",
    "mpc_controller",
]

# What differs behind the bridge's line.
OVER = {"safety_supervisor": ["hosts/marlin.param.yaml"]}

# Where a driver of the camera finds its frames.
CAMERA_SOURCES = {"folder": "folder.path", "video": "video.source", "mjpeg": "mjpeg.url"}
STATE = os.environ.get("XDG_STATE_HOME") or os.path.join(os.path.expanduser("~"), ".local", "state")

# name, default, description, allowed values
ARGUMENTS = [
    ("device", "/dev/ttyACM0", "serial line of the printer; rather one of /dev/serial/by-id", None),
    ("baud", "115200", "its rate in Bd: BAUDRATE of the firmware", None),
    ("camera", "printer", "driver of the camera; printer: none of its own", ["printer"] + list(CAMERA_SOURCES)),
    ("camera_source", "", "folder, video device, file or rtsp://..., or http://... of that driver", None),
    ("control", "mpc", "control level", ["off", "encoder", "mpc"]),
    ("mode", "observe", "mode of the supervisor", ["observe", "advise", "act"]),
    ("advance", "planned", "source of the pressure advance; predicted starts advance_predictor", fdm_launch.ADVANCES),
    ("material", "PLA", "what is printed: PLA, PETG or ABS", None),
    ("latch_file", "", "where a latched stop is remembered, mode and pause beside it; empty: below $XDG_STATE_HOME/fdm_loop", None),
    fdm_launch.BAG,
] + fdm_launch.FOLDERS


def latch_file(chosen):
    """One a printer; it outlives the graph, so that a new start does not forget a stop."""
    if chosen["latch_file"]:
        return os.path.abspath(chosen["latch_file"])
    return os.path.join(STATE, "fdm_loop", chosen["namespace"].strip("/") or "root", "latch.json")


def camera_values(chosen):
    values = {"driver": chosen["camera"]}
    parameter = CAMERA_SOURCES.get(chosen["camera"])
    if bool(parameter) != bool(chosen["camera_source"]):
        raise RuntimeError(
            f"camera:={chosen['camera']} camera_source:={chosen['camera_source']}: "
            "a driver of its own needs a source, the printer's has none"
        )
    return {**values, parameter: chosen["camera_source"]} if parameter else values


def values_of(node, chosen, bag):
    """Parameters that the arguments decide."""
    return {
        "bag_recorder": {"bag_dir": bag},
        "safety_supervisor": {"start_mode": chosen["mode"], "latch_file": latch_file(chosen)},
        "printer_bridge": {
            "serial.path": chosen["device"],
            "serial.baud": fdm_launch.number(chosen, "baud", 1200, 4_000_000, int),
            # The printer is heard once somebody guards it. For nobody else: without a record, a camera or a controller it is
            # to be guarded all the same.
            "start_after": ["safety_supervisor"],
        },
        "camera": camera_values(chosen),
        "mpc_controller": {"control": chosen["control"], "advance.source": chosen["advance"]},
    }.get(node, {})


def nodes(context):
    chosen = fdm_launch.chosen_of(ARGUMENTS, context)
    fdm_launch.check_material(chosen["material"], chosen["config"])
    camera_values(chosen)
    bag = fdm_launch.new_bag(chosen, "monitor", chosen["mode"])
    try:
        os.makedirs(os.path.dirname(latch_file(chosen)), exist_ok=True)
    except OSError as error:
        raise RuntimeError(f"latch_file:={latch_file(chosen)}: {error.strerror}: name a folder that is yours") from error
    wanted = [name for name in NODES if name != "advance_predictor" or chosen["advance"] == "predicted"]
    started = [
        fdm_launch.node(name, chosen, chosen["material"], values_of(name, chosen, bag), OVER.get(name, []))
        for name in wanted
    ]
    return fdm_launch.beside(bag, started)


def generate_launch_description():
    return LaunchDescription(
        fdm_launch.declared(ARGUMENTS) + [OpaqueFunction(function=lambda context: nodes(context))]
    )
