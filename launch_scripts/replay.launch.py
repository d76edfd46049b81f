"""Plays a bag with its own time on /clock, as `fdm play BAG --clock --rate X` does: for tools to look at.

    ros2 launch fdm_loop replay.launch.py bag:=bags/part-1766000000-mpc rate:=2.0

With `brains:=true` only what printer and sensors said is played, and estimator, classifier, controller and supervisor
say anew what they make of it, on the bag's time; no printer listens. What would have changed with other parameters says
`fdm replay`, without any graph. Ends with the bag.
"""

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import fdm_launch  # noqa: E402
from launch import LaunchDescription  # noqa: E402
from launch.actions import ExecuteProcess, OpaqueFunction, Shutdown  # noqa: E402

BRAINS = ["safety_supervisor", "state_estimator", "defect_classifier", "mpc_controller"]

# name, default, description, allowed values
ARGUMENTS = [
    ("bag", None, "folder of the bag", None),
    ("rate", "1.0", "bag's over wall time, 0.01 to 100", None),
    ("start", "0.0", "begin so far into the bag, in seconds", None),
    ("times", "1", "play it so often; /clock jumps back in between", None),
    ("brains", "false", "play only what printer and sensors said, and run the brains over it", ["true", "false"]),
    ("material", "PLA", "what was printed, for the brains: PLA, PETG or ABS", None),
    ("control", "mpc", "control level of the brains", ["off", "encoder", "mpc"]),
] + fdm_launch.FOLDERS


def player(chosen):
    words = ["--clock", "--rate", chosen["rate"], "--start", chosen["start"], "--times", chosen["times"]]
    return ExecuteProcess(
        cmd=[fdm_launch.program("fdm", chosen), "play", os.path.abspath(chosen["bag"])]
        + words
        + (["--inputs"] if chosen["brains"] == "true" else []),
        name="play",
        output="screen",
        on_exit=Shutdown(reason="the bag has ended"),
    )


def values_of(node, chosen):
    """Parameters that the arguments decide."""
    values = {
        "safety_supervisor": {"start_mode": "act", "latch_file": ""},
        "mpc_controller": {"control": chosen["control"]},
    }.get(node, {})
    return {**values, "use_sim_time": True}


def nodes(context):
    chosen = fdm_launch.chosen_of(ARGUMENTS, context)
    if not os.path.isfile(os.path.join(chosen["bag"], "metadata.yaml")):
        raise RuntimeError(f"bag:={chosen['bag']}: no bag (metadata.yaml is missing); fdm recover mends one after a crash")
    fdm_launch.number(chosen, "rate", 0.01, 100.0)
    fdm_launch.number(chosen, "start", 0.0, 1e9)
    fdm_launch.number(chosen, "times", 1, 2**32 - 1, int)
    if chosen["brains"] == "false":
        return [player(chosen)]
    fdm_launch.check_material(chosen["material"], chosen["config"])
    brains = [fdm_launch.node(name, chosen, chosen["material"], values_of(name, chosen)) for name in BRAINS]
    return brains + [player(chosen)]


def generate_launch_description():
    return LaunchDescription(
        fdm_launch.declared(ARGUMENTS) + [OpaqueFunction(function=lambda context: nodes(context))]
    )
