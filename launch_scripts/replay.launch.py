"""Plays a bag with its own time on /clock, for tools to look at, as `fdm play BAG --clock --rate X` does.

    ros2 launch fdm_loop replay.launch.py bag:=bags/part-1766000000-mpc rate:=2.0

Ends with the bag. What the brains would have done with other parameters says `fdm replay`, without any graph.
"""

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import fdm_launch  # noqa: E402
from launch import LaunchDescription  # noqa: E402
from launch.actions import ExecuteProcess, OpaqueFunction, Shutdown  # noqa: E402

# name, default, description, allowed values
ARGUMENTS = [
    ("bag", None, "folder of the bag", None),
    ("rate", "1.0", "bag's over wall time, above 0", None),
    ("bin", fdm_launch.BIN, "folder with the programs", None),
]


def nodes(context):
    chosen = fdm_launch.chosen_of(ARGUMENTS, context)
    if not os.path.isfile(os.path.join(chosen["bag"], "metadata.yaml")):
        raise RuntimeError(f"bag:={chosen['bag']}: no bag (metadata.yaml is missing); fdm recover mends one after a crash")
    if not float(chosen["rate"]) > 0.0:
        raise RuntimeError(f"rate:={chosen['rate']}: must be above 0")
    player = [fdm_launch.program("fdm", chosen), "play", os.path.abspath(chosen["bag"]), "--clock", "--rate", chosen["rate"]]
    return [ExecuteProcess(cmd=player, name="play", output="screen", on_exit=Shutdown(reason="the bag has ended"))]


def generate_launch_description():
    return LaunchDescription(
        fdm_launch.declared(ARGUMENTS) + [OpaqueFunction(function=lambda context: nodes(context))]
    )
