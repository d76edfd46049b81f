"""What a ROS user asks of our nodes, by an independent DDS.

    user.py BINARIES DOMAIN [CHECK ...]
"""

from __future__ import annotations

import signal
import sys
import time
from pathlib import Path

from graph import BEST_EFFORT, LATCHED, RELIABLE, DEFINITIONS, ROOT, Node, Peer, check, matched, run, until

UNCONFIGURED, INACTIVE, ACTIVE, FINALIZED = 1, 2, 3, 4
THERMISTOR = ["thermistor.param.yaml"]
SUPERVISOR = ["safety_supervisor.param.yaml"]
STATE, TRANSITION = "lifecycle_msgs/State", "lifecycle_msgs/Transition"


def parameter(name: str, **fields):
    value = DEFINITIONS.message("rcl_interfaces/ParameterValue")
    empty = {
        field: [] if "array" in field else "" if field == "string_value" else 0 for field in value.__annotations__
    }
    made = value(**{**empty, "bool_value": False, **fields})
    return DEFINITIONS.message("rcl_interfaces/Parameter")(name=name, value=made)


def double(name: str, number: float):
    return parameter(name, type=3, double_value=number)


def texts(name: str, value: str | list[str]):
    """A text, or several."""
    if isinstance(value, str):
        return parameter(name, type=4, string_value=value)
    return parameter(name, type=9, string_array_value=value)


class Life:
    """The five services of a node."""

    def __init__(self, peer: Peer, node: str) -> None:
        service = lambda name, kind: peer.service(f"{node}/{name}", f"lifecycle_msgs/{kind}")
        self.change = service("change_state", "ChangeState")
        self.get = service("get_state", "GetState")
        self.states = service("get_available_states", "GetAvailableStates")
        self.transitions = service("get_available_transitions", "GetAvailableTransitions")
        self.graph = service("get_transition_graph", "GetAvailableTransitions")

    def state(self) -> int:
        return self.get().current_state.id

    def to(self, number: int, label: str = "") -> bool:
        return self.change(transition=DEFINITIONS.message(TRANSITION)(id=number, label=label)).success


def report(stamp_s: float):
    """A report of the printer's temperatures."""
    kind = DEFINITIONS.message("fdm_loop_msgs/TemperatureReport")
    header = DEFINITIONS.message("std_msgs/Header")
    time_kind = DEFINITIONS.message("builtin_interfaces/Time")
    stamp = time_kind(sec=int(stamp_s), nanosec=int(stamp_s % 1 * 1e9))
    fields = {"header": header(stamp=stamp, frame_id="printer")}
    for field, of in kind.__annotations__.items():
        if field not in fields:
            fields[field] = True if of is bool else 200.0 if "hotend" in field else 60.0
    return kind(**fields)


def lifecycle(domain: int) -> str:
    """A life by hand: refusals, the graph, what is published when; then the stop of the permits, and finalized."""
    peer = Peer(domain)
    Node("thermistor", THERMISTOR, "-p", "autostart:=false", ROS_DOMAIN_ID=domain)
    life = Life(peer, "/printer/thermistor")
    events = peer.reader("/printer/thermistor/transition_event", "lifecycle_msgs/TransitionEvent")
    temperatures = peer.reader("/printer/sensors/hotend/temperature", "sensor_msgs/Temperature", BEST_EFFORT)
    reports = peer.writer("/printer/printer/report/temperature", "fdm_loop_msgs/TemperatureReport")
    check(life.state() == UNCONFIGURED, "a node that is not to start by itself is unconfigured")
    check(len(life.states().available_states) == 11, "eleven states")
    check(len(life.graph().available_transitions) == 25, "25 transitions")
    labels = [way.transition.label for way in life.transitions().available_transitions]
    check(labels == ["configure", "shutdown"], f"transitions from unconfigured: {labels}")
    for number in (2, 3, 4, 6, 7, 10, 99):
        check(not life.to(number), f"transition {number} is refused")
    check(life.to(1) and life.state() == INACTIVE, "configure")
    until(lambda: matched(reports), "the thermistor listens when it is inactive")

    def heard(limit_s: float) -> int:
        time.sleep(0.1)
        temperatures.take(1000)
        count, deadline = 0, time.monotonic() + limit_s
        while time.monotonic() < deadline:
            reports.write(report(time.clock_gettime(time.CLOCK_MONOTONIC)))
            time.sleep(0.05)
            count += len(temperatures.take(100))
        return count

    check(heard(0.6) == 0, "an inactive node publishes nothing")
    check(life.to(0, "activate") and life.state() == ACTIVE, "activate, by name")
    check(heard(0.6) >= 5, "an active node publishes")
    check(life.to(4) and life.state() == INACTIVE and heard(0.4) == 0, "deactivate")
    check(life.to(2) and life.state() == UNCONFIGURED, "cleanup")
    check(life.to(1) and life.to(3) and heard(0.6) >= 5, "and again")
    check(life.to(7) and life.state() == FINALIZED and heard(0.3) == 0, "shutdown")
    told = [(event.start_state.label, event.goal_state.label) for event in events.take(100)]
    check(told[:2] == [("unconfigured", "configuring"), ("configuring", "inactive")], f"events {told}")
    check(len(told) == 14, f"{len(told)} events")
    check(Node.running[0].end() == 0, "a finalized node ends in order")
    return f"{len(told)} transition events"


def deactivation(domain: int) -> str:
    """The supervisor's last permit before it is inactive carries the slicer's own values; then there are none."""
    peer = Peer(domain)
    node = Node("safety_supervisor", SUPERVISOR, "-p", "start_mode:=act", ROS_DOMAIN_ID=domain)
    permits = peer.reader("/printer/safety/command", "fdm_loop_msgs/ControlCommand")
    life = Life(peer, "/printer/safety_supervisor")
    until(lambda: permits.take(100), "permits")
    check(life.state() == ACTIVE, "a node starts by itself")
    check(life.to(4), "deactivate")
    taken = permits.take(1000)
    time.sleep(0.3)
    check(not permits.take(1000), "no permit of an inactive supervisor")
    last = taken[-1]
    check((last.flow_factor, last.speed_factor) == (1.0, 1.0), f"the last permit is neutral: {last}")
    begin = time.monotonic()
    check(life.to(3), "activate")
    until(lambda: permits.take(100), "permits again")
    again_s = time.monotonic() - begin
    check(again_s < 0.5, f"permits again after {again_s:.2f} s")
    check(node.end() == 0, "an orderly end")
    return f"permits {again_s * 1e3:.0f} ms after activate"


def parameters(domain: int) -> str:
    """The six services in Cyclone's mapping: told, refused with name, value, unit and range, changed, told as events."""
    peer = Peer(domain)
    Node("safety_supervisor", SUPERVISOR, ROS_DOMAIN_ID=domain)
    node = "/printer/safety_supervisor"
    service = lambda name, kind: peer.service(f"{node}/{name}", f"rcl_interfaces/{kind}")
    changes = peer.reader("/parameter_events", "rcl_interfaces/ParameterEvent")
    events = peer.reader("/printer/events", "fdm_loop_msgs/PrintEvent")
    listed = service("list_parameters", "ListParameters")(prefixes=[], depth=0).result.names
    check("modes.ramp_s" in listed and "use_sim_time" in listed, f"names: {listed[:5]} ...")
    kinds = service("get_parameter_types", "GetParameterTypes")(names=["modes.ramp_s", "no.such"]).types
    check(list(kinds) == [3, 0], f"types {kinds}")
    get = service("get_parameters", "GetParameters")
    check(get(names=["modes.ramp_s"]).values[0].double_value == 0.8, "value")
    describe = service("describe_parameters", "DescribeParameters")
    told = describe(names=["modes.ramp_s"]).descriptors[0]
    span = told.floating_point_range[0]
    check((span.from_value, span.to_value) == (0.05, 2.0) and told.description.startswith("[s]"), f"{told}")
    check(told.read_only, "read-only while active")
    set_one = service("set_parameters", "SetParameters")
    refused = set_one(parameters=[double("modes.ramp_s", 7.0)]).results[0]
    check("modes.ramp_s = 7 s: must be in [0.05, 2]" in refused.reason, refused.reason)
    refused = set_one(parameters=[double("modes.ramp_s", 0.9)]).results[0]
    check("read-only while the node is active" in refused.reason, refused.reason)
    life = Life(peer, node)
    check(life.to(4), "deactivate")
    check(not describe(names=["modes.ramp_s"]).descriptors[0].read_only, "free while inactive")
    together = service("set_parameters_atomically", "SetParametersAtomically")
    pair = ["modes.ramp_s", "modes.adopt_s"]
    values = lambda: [value.double_value for value in get(names=pair).values]
    for wanted in ((0.7, 31.0), (7.0, 2.0)):
        result = together(parameters=[double(*one) for one in zip(pair, wanted)]).result
        check(not result.successful and values() == [0.8, 1.0], f"all or none: {result}, {values()}")
    check(not [change for change in changes.take(100) if change.changed_parameters], "nothing is told of none")
    check(together(parameters=[double(*one) for one in zip(pair, (0.7, 2.0))]).result.successful, "both together")
    check(values() == [0.7, 2.0], f"both: {values()}")
    change = until(lambda: [c for c in changes.take(100) if c.changed_parameters], "/parameter_events of both")[0]
    check([one.name for one in change.changed_parameters] == pair, f"{change}")
    event = until(lambda: [e for e in events.take(100) if e.what == "parameter_set"], "events of both")
    check((event[0].before, event[0].after) == ("0.8", "0.7"), f"{event}")
    check(set_one(parameters=[double("modes.ramp_s", 0.5)]).results[0].successful, "set while inactive")
    check(get(names=["modes.ramp_s"]).values[0].double_value == 0.5, "the new value")
    change = until(lambda: [c for c in changes.take(100) if c.changed_parameters], "/parameter_events")[0]
    check((change.node, change.changed_parameters[0].name) == (node, "modes.ramp_s"), f"{change}")
    wanted = lambda: [e for e in events.take(100) if e.what == "parameter_set" and e.after == "0.5"]
    event = until(wanted, "events")[0]
    check((event.who, event.before, event.after) == (node, "0.7", "0.5"), f"{event}")
    check(life.to(3) and life.state() == ACTIVE, "works on with it")
    return f"{len(listed)} parameters"


def unconfigured(domain: int) -> str:
    """A node that was never configured checks what is set as at its start, and describes what an option has set."""
    peer, told = Peer(domain), 0
    started = (
        ("thermistor", THERMISTOR, "hotend.sigma_k", 11.0, "must be in [0, 10]", 0.5),
        ("safety_supervisor", SUPERVISOR, "modes.ramp_s", 7.0, "must be in [0.05, 2]", 0.5),
    )
    for name, files, parameter, wrong, rule, right in started:
        words = ["-p", "autostart:=false", "-p", f"{parameter}:=0.2", "-p", f"other:{parameter}:=99.0"]
        node = Node(name, files, *words, ROS_DOMAIN_ID=domain)
        service = lambda what, kind: peer.service(f"/printer/{name}/{what}", f"rcl_interfaces/{kind}")
        life = Life(peer, f"/printer/{name}")
        set_one, get = service("set_parameters", "SetParameters"), service("get_parameters", "GetParameters")
        value = lambda: get(names=[parameter]).values[0].double_value
        check(life.state() == UNCONFIGURED and value() == 0.2, f"{name}: {value()}")
        refused = set_one(parameters=[double(parameter, wrong)]).results[0]
        check(not refused.successful and rule in refused.reason, f"{name}: {refused}")
        check(value() == 0.2 and set_one(parameters=[double(parameter, right)]).results[0].successful, f"{name}: set")
        described = service("describe_parameters", "DescribeParameters")(names=[parameter]).descriptors[0]
        check(described.description.startswith("[") and described.floating_point_range, f"{name}: {described}")
        check(life.to(1) and life.to(3) and life.state() == ACTIVE and value() == right, f"{name} works with it")
        check(node.end() == 0, f"{name}: an orderly end")
        told += 1
    return f"{told} nodes"


def described(domain: int) -> str:
    """All that the node with most parameters says of them comes in one answer each: one above 64 KiB would not come."""
    peer = Peer(domain)
    printer = ["plants/ender3.yaml", "printers/ender3_motion.yaml", "quality.yaml"]
    files = ["printer_sim.param.yaml", *printer, "materials/pla.yaml"]
    gcode = ROOT / "tests/data/gcode/quirks_handmade.gcode"
    Node("printer_sim", files, "-p", f'run.gcode:="{gcode}"', ROS_DOMAIN_ID=domain)
    service = lambda name, kind: peer.service(f"/printer/printer_sim/{name}", f"rcl_interfaces/{kind}")
    names = service("list_parameters", "ListParameters")(prefixes=[], depth=0).result.names
    told = service("describe_parameters", "DescribeParameters")(names=names).descriptors
    bare = [one.name for one in told if not one.description]
    check([one.name for one in told] == names and not bare, f"not described: {bare}")
    values = service("get_parameters", "GetParameters")(names=names).values
    check(all(value.type for value in values), "a value of each")
    return f"{len(names)} parameters, {sum(len(one.description) for one in told)} letters"


def live(domain: int) -> str:
    """What a node has declared changes while it is active, and at once; a wrong value is refused with its range."""
    peer = Peer(domain)
    Node("thermistor", THERMISTOR, ROS_DOMAIN_ID=domain)
    temperatures = peer.reader("/printer/sensors/hotend/temperature", "sensor_msgs/Temperature", BEST_EFFORT)
    reports = peer.writer("/printer/printer/report/temperature", "fdm_loop_msgs/TemperatureReport")
    set_one = peer.service("/printer/thermistor/set_parameters", "rcl_interfaces/SetParameters")
    describe = peer.service("/printer/thermistor/describe_parameters", "rcl_interfaces/DescribeParameters")
    told = describe(names=["hotend.sigma_k", "hotend.stamp_age_max_s"]).descriptors
    check([one.read_only for one in told] == [False, True], f"{told}")

    def variance(expected: float) -> bool:
        reports.write(report(time.clock_gettime(time.CLOCK_MONOTONIC)))
        return any(abs(one.variance - expected) < 1e-9 for one in temperatures.take(100))

    until(lambda: variance(0.15**2), "a variance of 0.15 K")
    refused = set_one(parameters=[double("hotend.sigma_k", 11.0)]).results[0].reason
    check("hotend.sigma_k = 11 K: must be in [0, 10]" in refused, refused)
    check(set_one(parameters=[double("hotend.sigma_k", 0.5)]).results[0].successful, "set while active")
    begin = time.monotonic()
    until(lambda: variance(0.25), "a variance of 0.5 K")
    return f"in force {(time.monotonic() - begin) * 1e3:.0f} ms after the answer"


def logs(domain: int) -> str:
    """/rosout has the logger of the node and the levels of `rcl_interfaces/Log`; `--log-level` knows that logger."""
    peer = Peer(domain)
    lines = peer.reader("/rosout", "rcl_interfaces/Log", RELIABLE)
    word = ["--log-level", "printer.quiet:=error"]
    for name, words in (("thermistor", []), ("quiet", word)):
        Node(name, THERMISTOR, "-r", f"__node:={name}", *words, program="thermistor", ROS_DOMAIN_ID=domain)
    heard = []
    for name in ("thermistor", "quiet"):
        life = Life(peer, f"/printer/{name}")
        check(life.to(4) and not life.to(4), "deactivated once")

    def all_heard() -> bool:
        heard.extend(lines.take(100))
        return any(line.level == 30 for line in heard) and any(line.level == 20 for line in heard)

    until(all_heard, "a line of level INFO and one of level WARN")
    names = {line.name for line in heard}
    check(names == {"printer.thermistor"}, f"loggers {names}")
    check(all(line.file and line.line for line in heard), "each line names its place")
    check(all(node.end() == 0 for node in Node.running), "SIGINT ends in order, as launch expects it")
    return f"{len(heard)} lines"


CHECKS = {
    "lifecycle": lifecycle,
    "deactivation": deactivation,
    "parameters": parameters,
    "unconfigured": unconfigured,
    "described": described,
    "live": live,
    "logs": logs,
}


if __name__ == "__main__":
    Node.binaries = Path(sys.argv[1])
    wanted = sys.argv[3:] or list(CHECKS)
    run({name: CHECKS[name] for name in wanted}, int(sys.argv[2]))
