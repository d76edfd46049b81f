"""The whole graph on the simulated printer, as `fdm up` starts it.

    ros2 launch fdm_loop sim.launch.py gcode:=part.gcode speed:=4.0

What `fdm up` does beyond: it checks every parameter file before anything runs, waits for the end of the print and
prints its figures. Here the graph runs until Ctrl-C or until the printer ends.
"""

import glob
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
    "thermistor",
    "imu",
    "camera",
    "filament_encoder",
    "state_estimator",
    "defect_classifier",
    "advance_predictor",
    "mpc_controller",
    "printer_sim",
]

# Read at a file's end for what it says of itself, as `fdm up` does.
MATERIAL_BYTES = 65536

# name, default, description, allowed values
ARGUMENTS = [
    ("gcode", None, "G-code file to print", None),
    ("scenario", "nominal", "scenario of config/scenarios, or a path to one", None),
    ("control", "mpc", "control level", ["off", "encoder", "mpc"]),
    ("mode", "act", "mode of the supervisor", ["observe", "advise", "act"]),
    ("host", "native", "host profile", ["native", "serial"]),
    ("advance", "planned", "source of the pressure advance; predicted starts advance_predictor", fdm_launch.ADVANCES),
    ("material", "", "PLA, PETG or ABS with its set-points; empty: the file's own", None),
    ("speed", "1.0", "simulated over wall time, 0.1 to 20", None),
    ("host_clock", "false", "run on the host's clock, as beside a real printer; at speed 1 alone", ["true", "false"]),
    ("layers", "0", "print only the first layers; 0: all", None),
    ("warm", "false", "start with hot end and bed at the file's set-points", ["true", "false"]),
    ("seed", "1", "seed of all noise", None),
    ("allow_fault_injection", "false", "serve printer_sim/inject_fault", ["true", "false"]),
    fdm_launch.BAG,
] + fdm_launch.FOLDERS


def material_of(gcode):
    """What the slicer states at the file's end; PLA where it states nothing."""
    with open(gcode, "rb") as file:
        file.seek(0, os.SEEK_END)
        file.seek(-min(MATERIAL_BYTES, file.tell()), os.SEEK_END)
        tail = file.read().decode("utf-8", "replace")
    key = "; filament_type = "
    stated = [line[len(key):].strip() for line in tail.splitlines() if line.startswith(key)]
    return stated[0].upper() if stated and stated[0] else "PLA"


def wanted_of(chosen):
    return [name for name in NODES if name != "advance_predictor" or chosen["advance"] == "predicted"]


def values_of(node, chosen, bag):
    """Parameters that the arguments decide."""
    values = {
        "bag_recorder": {"bag_dir": bag},
        "safety_supervisor": {
            "start_mode": chosen["mode"], "latch_file": os.path.join(bag + "_logs", "latch.json")
        },
        "mpc_controller": {"control": chosen["control"], "advance.source": chosen["advance"]},
        "printer_sim": {
            "run.gcode": os.path.abspath(chosen["gcode"]),
            "run.scenario": scenario_path(chosen["scenario"], chosen["config"]),
            "run.seed": fdm_launch.number(chosen, "seed", 0, 10**18, int),
            "run.speed": fdm_launch.number(chosen, "speed", 0.1, 20.0),
            "run.host_clock": chosen["host_clock"] == "true",
            "run.layers": fdm_launch.number(chosen, "layers", 0, 10**6, int),
            "run.warm": chosen["warm"] == "true",
            "run.material_set_points": bool(chosen["material"]),
            "run.allow_fault_injection": chosen["allow_fault_injection"] == "true",
            "run.config_file": "",
            "simulator.host": chosen["host"],
            # It prints when all others work; its log names whom it waits for.
            "start_after": [name for name in wanted_of(chosen) if name != "printer_sim"],
            # Frames in place of the stand-in that gives the road's width.
            "camera.enabled": True,
            "simulator.width_period_s": 0.0,
        },
    }.get(node, {})
    # The simulated printer makes the time that the others follow, unless all have the host's.
    follows = node != "printer_sim" and chosen["host_clock"] != "true"
    return {**values, "use_sim_time": True} if follows else values


def scenario_path(name, config):
    folder = os.path.join(config, "scenarios")
    path = os.path.abspath(name if name.endswith(".yaml") else os.path.join(folder, f"{name}.yaml"))
    if not os.path.isfile(path):
        known = sorted(file[:-5] for file in os.listdir(folder) if file.endswith(".yaml"))
        raise RuntimeError(f"scenario:={name}: no such file; there are {', '.join(known)}")
    return path


def nodes(context):
    chosen = fdm_launch.chosen_of(ARGUMENTS, context)
    if not os.path.isfile(chosen["gcode"]):
        raise RuntimeError(f"gcode:={chosen['gcode']}: no such file")
    material = chosen["material"] or material_of(chosen["gcode"])
    fdm_launch.check_material(material, chosen["config"])
    if chosen["host_clock"] == "true" and fdm_launch.number(chosen, "speed", 0.1, 20.0) != 1.0:
        raise RuntimeError(f"speed:={chosen['speed']} beside host_clock:=true: must be 1, the host's clock goes no faster")
    scenario_path(chosen["scenario"], chosen["config"])
    stem = os.path.splitext(os.path.basename(chosen["gcode"]))[0]
    bag = fdm_launch.new_bag(chosen, stem, chosen["control"])
    started = [fdm_launch.node(name, chosen, material, values_of(name, chosen, bag)) for name in wanted_of(chosen)]
    started = fdm_launch.beside(bag, started)
    forget_records(bag)
    return started


def forget_records(bag):
    """What the supervisor of a former print with this bag remembered: that print is gone with its simulated printer."""
    for record in glob.glob(os.path.join(glob.escape(bag + "_logs"), "latch.*")):
        os.remove(record)


def generate_launch_description():
    return LaunchDescription(
        fdm_launch.declared(ARGUMENTS) + [OpaqueFunction(function=lambda context: nodes(context))]
    )
