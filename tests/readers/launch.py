"""Evaluates a launch file against stand-ins of the launch modules and prints the processes it would start as JSON.

    launch.py FILE name:=value ...

No ROS is needed. The stand-ins do what `launch` and `launch_ros` of Jazzy do with what our files use: arguments with
defaults and choices, `OpaqueFunction`, and the command line of a `Node` (its parameter dictionaries become files with
`/**`). What they cannot show is how the real `ros2 launch` starts, respawns and ends the processes.
"""

import importlib.util
import json
import os
import sys
import tempfile
import types


class LaunchDescription:
    def __init__(self, entities):
        self.entities = list(entities)


class DeclareLaunchArgument:
    def __init__(self, name, *, default_value=None, description=None, choices=None):
        self.name, self.default_value, self.choices = name, default_value, choices
        if not description:
            raise ValueError(f"argument {name} has no description")

    def execute(self, context):
        value = context.setdefault(self.name, self.default_value)
        if value is None:
            raise RuntimeError(f"Required launch argument '{self.name}' was not provided.")
        if self.choices is not None and value not in self.choices:
            raise RuntimeError(f"{self.name}:={value} is not one of {self.choices}")
        return []


class LaunchConfiguration:
    def __init__(self, name):
        self.name = name

    def perform(self, context):
        return context[self.name]


class OpaqueFunction:
    def __init__(self, *, function):
        self.function = function

    def execute(self, context):
        return self.function(context) or []


class Shutdown:
    def __init__(self, *, reason=""):
        self.reason = reason


class ExecuteProcess:
    def __init__(self, *, cmd, name, output, on_exit):
        self.cmd, self.name, self.on_exit = cmd, name, on_exit

    def process(self, folder):
        return {
            "node": self.name,
            "program": self.cmd[0],
            "arguments": self.cmd[1:],
            "respawn": False,
            "ends_all": isinstance(self.on_exit, Shutdown),
        }


class Node:
    def __init__(
        self, *, executable, name, namespace, parameters, remappings, ros_arguments, output, respawn, respawn_delay,
        additional_env, on_exit
    ):
        if respawn != ("FDM_STARTED_AGAIN" in additional_env):
            raise ValueError(f"{name} is not told whether it is started again")
        self.executable, self.name, self.namespace = executable, name, namespace
        self.parameters, self.remappings, self.ros_arguments = parameters, remappings, ros_arguments
        self.respawn, self.on_exit = respawn, on_exit

    def process(self, folder):
        words = ["--ros-args", *self.ros_arguments, "-r", f"__node:={self.name}", "-r", f"__ns:={self.namespace}"]
        words += [word for old, new in self.remappings for word in ("-r", f"{old}:={new}")]
        for index, source in enumerate(self.parameters):
            if isinstance(source, dict):
                path = os.path.join(folder, f"{self.name}_{index}.yaml")
                with open(path, "w") as file:
                    # JSON is YAML; launch_ros writes dotted names flat.
                    json.dump({"/**": {"ros__parameters": source}}, file)
                source = path
            words += ["--params-file", source]
        return {
            "node": self.name,
            "program": self.executable,
            "arguments": words,
            "respawn": self.respawn,
            "ends_all": isinstance(self.on_exit, Shutdown),
        }


def install():
    modules = {
        "launch": {"LaunchDescription": LaunchDescription},
        "launch.actions": {
            "DeclareLaunchArgument": DeclareLaunchArgument,
            "ExecuteProcess": ExecuteProcess,
            "OpaqueFunction": OpaqueFunction,
            "Shutdown": Shutdown,
        },
        "launch.substitutions": {"LaunchConfiguration": LaunchConfiguration},
        "launch_ros": {},
        "launch_ros.actions": {"Node": Node},
    }
    for name, members in modules.items():
        module = types.ModuleType(name)
        module.__dict__.update(members)
        sys.modules[name] = module


def main():
    sys.dont_write_bytecode = True
    install()
    spec = importlib.util.spec_from_file_location("launch_file", sys.argv[1])
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    context = dict(argument.split(":=", 1) for argument in sys.argv[2:])
    started, folder = [], tempfile.mkdtemp(prefix="launch_")
    waiting = list(module.generate_launch_description().entities)
    while waiting:
        entity = waiting.pop(0)
        if isinstance(entity, (ExecuteProcess, Node)):
            started.append(entity.process(folder))
        else:
            waiting = list(entity.execute(context)) + waiting
    print(json.dumps(started))


main()
