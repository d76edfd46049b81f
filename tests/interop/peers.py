"""What a graph bears: late joiners, peers that are killed, stopped or do not read, many processes, simulated time.

    peers.py BINARIES DOMAIN [CHECK ...]
"""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

from endpoints import Discovery, Told, differences, participants
from graph import BEST_EFFORT, DEFINITIONS, LATCHED, RELIABLE, ROOT, Failed, Node, Peer, check, matched, run, until

THERMISTOR = ["thermistor.param.yaml"]
SUPERVISOR = ["safety_supervisor.param.yaml"]
#: A permit holds this long `[s]`: a printer that waits longer goes back to the slicer's values.
VALIDITY_S = 0.25
#: Of `SafetyState` and `PrinterState`.
SAFE_OFF, FAILED = 6, 5


def seconds(header) -> float:
    return header.stamp.sec + header.stamp.nanosec * 1e-9


def permits_of(reader, length_s: float) -> list[float]:
    """Stamps of the permits that come within a time."""
    stamps, deadline = [], time.monotonic() + length_s
    while time.monotonic() < deadline:
        stamps += [seconds(permit.header) for permit in reader.take(100)]
        time.sleep(0.01)
    return sorted(stamps)


def longest(stamps: list[float]) -> float:
    return max(after - before for before, after in zip(stamps, stamps[1:]))


def regular(stamps: list[float], length_s: float, what: str) -> float:
    check(len(stamps) > 25 * length_s, f"{what}: {len(stamps)} permits in {length_s} s")
    check(longest(stamps) < VALIDITY_S, f"{what}: {longest(stamps):.3f} s without a permit")
    return longest(stamps)


def late_joiner(domain: int) -> str:
    """Who joins late ends on the newest latched state."""
    early, mode = Peer(domain), 0
    Node("safety_supervisor", SUPERVISOR, ROS_DOMAIN_ID=domain)
    set_mode = early.service("/printer/safety/set_mode", "fdm_loop_msgs/SetMode")
    states = early.reader("/printer/safety/state", "fdm_loop_msgs/SafetyState", LATCHED)
    newest = lambda reader: max(reader.take(100), key=lambda state: state.sequence, default=None)
    for mode in (1, 2, 3, 2, 1, 2):
        check(set_mode(mode=mode).accepted, f"mode {mode}")
    known = until(lambda: newest(states), "a state")
    reader = Peer(domain).reader("/printer/safety/state", "fdm_loop_msgs/SafetyState", LATCHED)
    begin = time.monotonic()
    state = until(lambda: newest(reader), "the state for a late joiner")
    check(state.sequence >= known.sequence and state.set_mode == mode, f"{state} after {known}")
    return f"newest state {(time.monotonic() - begin) * 1e3:.0f} ms after joining"


#: Whoever is killed or stopped, with their files; who gives the permits is not among them.
OTHERS = {
    "thermistor": THERMISTOR,
    "filament_encoder": ["filament_encoder.param.yaml"],
    "state_estimator": ["state_estimator.param.yaml", "printers/ender3.yaml", "materials/pla.yaml"],
    "mpc_controller": ["mpc_controller.param.yaml", "printers/ender3.yaml", "materials/pla.yaml"],
}


def killed_and_stopped(domain: int) -> str:
    """kill -9, and SIGSTOP with SIGCONT, of each process: the permits go on, and the killed comes back."""
    peer = Peer(domain)
    Node("safety_supervisor", SUPERVISOR, ROS_DOMAIN_ID=domain)
    others = {name: Node(name, files, ROS_DOMAIN_ID=domain) for name, files in OTHERS.items()}
    permits = peer.reader("/printer/safety/command", "fdm_loop_msgs/ControlCommand")
    hearts = peer.reader("/printer/heartbeat", "fdm_loop_msgs/Heartbeat", BEST_EFFORT)
    until(lambda: permits.take(100), "permits")
    gaps, backs = [], []
    for name, other in others.items():
        sessions = lambda: {beat.session_id for beat in hearts.take(1000) if beat.node == f"/printer/{name}"}
        first = until(sessions, f"the heart of {name}")
        other.kill()
        gaps.append(regular(permits_of(permits, 1.0), 1.0, f"after kill -9 of {name}"))
        hearts.take(1000)
        begin = time.monotonic()
        other.start()
        until(lambda: sessions() - first, f"the next run of {name}")
        backs.append(time.monotonic() - begin)
        check(backs[-1] < 1.4, f"{name} is back after {backs[-1]:.2f} s")
        other.signal(signal.SIGSTOP)
        gaps.append(regular(permits_of(permits, 1.5), 1.5, f"while {name} is stopped"))
        other.signal(signal.SIGCONT)
        check(other.process.wait(5) == 75, f"{name} was stopped and ends, to be started again")
        gaps.append(regular(permits_of(permits, 0.5), 0.5, f"after SIGCONT of {name}"))
    return f"back {max(backs) * 1e3:.0f} ms after its start, longest time between permits {max(gaps) * 1e3:.0f} ms"


def stalled(domain: int) -> str:
    """A reliable subscriber that does not read any more holds nobody up."""
    peer = Peer(domain)
    Node("safety_supervisor", SUPERVISOR, ROS_DOMAIN_ID=domain)
    permits = peer.reader("/printer/safety/command", "fdm_loop_msgs/ControlCommand", BEST_EFFORT)
    until(lambda: permits.take(100), "permits")
    other = subprocess.Popen([sys.executable, __file__, "--read", str(domain)], stdout=subprocess.PIPE, text=True)
    try:
        check(other.stdout.readline().strip() == "reads", "the other reads")
        other.send_signal(signal.SIGSTOP)
        permits.take(1000)
        gap_s = regular(permits_of(permits, 4.0), 4.0, "beside a stalled subscriber")
    finally:
        other.kill()
        other.wait()
    return f"longest time between permits {gap_s * 1e3:.0f} ms"


def rival(domain: int) -> str:
    """Who else writes permits is heard by the supervisor, which hears none of its own."""
    peer = Peer(domain)
    Node("safety_supervisor", SUPERVISOR, ROS_DOMAIN_ID=domain)
    permits = peer.reader("/printer/safety/command", "fdm_loop_msgs/ControlCommand", BEST_EFFORT)
    states = peer.reader("/printer/safety/state", "fdm_loop_msgs/SafetyState", LATCHED)
    until(lambda: permits.take(100), "permits")
    time.sleep(1.0)
    refused = lambda: max([state.refused_sequence for state in states.read(100)], default=-1)
    until(lambda: refused() >= 0, "a state")
    check(refused() == 0, f"{refused()} of its own permits are refused")
    writer = peer.writer("/printer/safety/command", "fdm_loop_msgs/ControlCommand")
    begin = time.monotonic()

    def told() -> bool:
        for permit in permits.take(100):
            writer.write(permit)
        return refused() > 0

    until(told, "a refused permit")
    return f"told {time.monotonic() - begin:.1f} s after it began"


def read(domain: int) -> None:
    """Reads reliably until it is stopped."""
    peer = Peer(domain)
    permits = peer.reader("/printer/safety/command", "fdm_loop_msgs/ControlCommand", RELIABLE)
    states = peer.reader("/printer/safety/state", "fdm_loop_msgs/SafetyState", LATCHED)
    until(lambda: permits.take(100) and states.read(1), "permits and state")
    print("reads", flush=True)
    while True:
        permits.take(100)
        time.sleep(0.01)


def ten_processes(domain: int) -> str:
    """Ten processes are found within 3 s, and tell the graph of every endpoint that DDS has found, and of no other."""
    peer = Peer(domain)
    hearts = peer.reader("/printer/heartbeat", "fdm_loop_msgs/Heartbeat", BEST_EFFORT)
    told, discovery = Told(peer), Discovery(peer)
    names = {f"thermistor_{number}" for number in range(10)}
    begin = time.monotonic()
    for name in names:
        Node("thermistor", THERMISTOR, "-r", f"__node:={name}", ROS_DOMAIN_ID=domain)
    heard: set[str] = set()

    def all_heard() -> bool:
        heard.update(beat.node.rsplit("/")[-1] for beat in hearts.take(1000))
        return names <= heard

    until(all_heard, "ten hearts")
    found_s = time.monotonic() - begin
    check(found_s < 3.0, f"all found after {found_s:.2f} s")

    def ours() -> tuple[dict, dict]:
        """What the ten tell, and what DDS has found of them; those of checks before may be known still."""
        of_ours = {key: nodes for key, nodes in told.by_participant().items() if names & {n.node_name for n in nodes}}
        return of_ours, {key: found for key, found in discovery.by_participant().items() if key in of_ours}

    def all_told() -> bool:
        of_ours, found = ours()
        return len(of_ours) == len(found) == len(names) and not differences(of_ours, found)

    try:
        until(all_told, "ros_discovery_info of all")
    except Failed as failed:
        raise Failed(f"{failed}: {differences(*ours())}") from failed
    found = ours()[1]
    counts = [len(endpoints.readers) + len(endpoints.writers) for endpoints in found.values()]
    # Eleven services, each with a reader and a writer, and what else a node reads and says.
    check(min(counts) > 22, f"endpoints of the participants: {counts}")
    return f"ten found in {found_s:.2f} s, {sum(counts)} endpoints told"


def clock(domain: int) -> str:
    """A node under `use_sim_time` follows /clock, forward and back."""
    peer = Peer(domain)
    Node("thermistor", THERMISTOR, "-p", "use_sim_time:=true", ROS_DOMAIN_ID=domain)
    writer = peer.writer("/clock", "rosgraph_msgs/Clock", RELIABLE)
    hearts = peer.reader("/printer/heartbeat", "fdm_loop_msgs/Heartbeat", BEST_EFFORT)
    reports = peer.reader("/diagnostics", "diagnostic_msgs/DiagnosticArray")
    until(lambda: matched(writer), "a subscriber of /clock")
    time_kind, clock_kind = (DEFINITIONS.message(f"{name}") for name in ("builtin_interfaces/Time", "rosgraph_msgs/Clock"))

    def at(second: int) -> None:
        def shown() -> bool:
            writer.write(clock_kind(clock=time_kind(sec=second, nanosec=500_000_000)))
            return any(abs(seconds(beat.header) - second - 0.5) < 1e-6 for beat in hearts.take(100))

        until(shown, f"a stamp at {second}.5 s")

    for second in (100, 250, 40, 41):
        at(second)
    values = lambda: {
        value.value
        for report in reports.take(100)
        for status in report.status
        for value in status.values
        if value.key == "clock_jumps_back"
    }
    until(lambda: "1" in values(), "one jump back in /diagnostics")
    return "forward, and back once"


def diagnostics(domain: int) -> str:
    """A node that was killed is ERROR on /diagnostics within 1 s, under its own name; so is who watches the others."""
    peer = Peer(domain)
    nodes = {
        "/printer/thermistor": Node("thermistor", THERMISTOR, ROS_DOMAIN_ID=domain),
        "/printer/safety_supervisor": Node("safety_supervisor", SUPERVISOR, ROS_DOMAIN_ID=domain),
    }
    reader = peer.reader("/diagnostics", "diagnostic_msgs/DiagnosticArray")
    statuses = lambda: [status for report in reader.take(100) for status in report.status]
    seen: dict[str, str] = {}

    def all_seen() -> bool:
        seen.update((status.name, status.hardware_id) for status in statuses())
        return set(nodes) <= set(seen)

    until(all_seen, "both nodes")
    check(set(seen.values()) == {"printer"}, f"names and hardware: {seen}")
    time.sleep(1.0)
    slowest_s = 0.0
    for name, node in nodes.items():
        statuses()
        begin = time.monotonic()
        node.kill()
        until(lambda: any(s.name == name and s.level == 2 for s in statuses()), f"{name} as ERROR", 3.0)
        slowest_s = max(slowest_s, time.monotonic() - begin)
        node.start()
        until(lambda: any(s.name == name and s.level < 2 for s in statuses()), f"{name} is back")
        time.sleep(0.5)
    check(slowest_s < 1.0, f"told after {slowest_s:.2f} s")
    return f"told {slowest_s * 1e3:.0f} ms after kill -9"


def namespaces(domain: int) -> str:
    """Two printers in one domain: no endpoint of the one is the other's, and a stop of the left one is none of the right."""
    peer, names = Peer(domain), ("/left", "/right")
    nominal = ["printers/ender3.yaml", "materials/pla.yaml"]
    printer = ["plants/ender3.yaml", "printers/ender3_motion.yaml", "quality.yaml", nominal[1]]
    files = {"safety_supervisor": [], "thermistor": [], "state_estimator": nominal, "printer_sim": printer}
    gcode = ROOT / "tests/data/gcode/quirks_handmade.gcode"
    for namespace in names:
        for name, more in files.items():
            words = ["-r", f"__ns:={namespace}", "-r", f"/clock:={namespace}/clock"]
            words += ["-p", f'run.gcode:="{gcode}"'] if name == "printer_sim" else ["-p", "use_sim_time:=true"]
            Node(name, [f"{name}.param.yaml", *more], *words, ROS_DOMAIN_ID=domain)
    states = {name: peer.reader(f"{name}/printer/state", "fdm_loop_msgs/PrinterState", BEST_EFFORT) for name in names}
    modes = {name: peer.reader(f"{name}/safety/state", "fdm_loop_msgs/SafetyState", LATCHED) for name in names}
    newest: dict[tuple[str, str], object] = {}

    def look() -> bool:
        for kind, readers in (("state", states), ("mode", modes)):
            for name, reader in readers.items():
                newest.update(((kind, name), sample) for sample in reader.take(1000))
        return len(newest) == 4

    until(look, "both printers")
    found = participants(peer, names)
    check(found == dict.fromkeys(names, len(files)), f"participants {found}")
    stop = peer.service("/left/safety/stop", "std_srvs/Trigger")
    check(stop().success, "the left one stops")
    until(lambda: look() and newest["mode", "/left"].mode == SAFE_OFF, "the left supervisor's mode")
    until(lambda: look() and newest["state", "/left"].phase == FAILED, "the left printer has given up")
    before = seconds(newest["state", "/right"].header)
    until(lambda: look() and seconds(newest["state", "/right"].header) > before + 0.5, "the right one goes on")
    check(newest["mode", "/right"].mode < SAFE_OFF and newest["state", "/right"].phase != FAILED, f"{newest}")
    return f"{found} participants"


CHECKS = {
    "late_joiner": late_joiner,
    "killed_and_stopped": killed_and_stopped,
    "stalled": stalled,
    "rival": rival,
    "ten_processes": ten_processes,
    "clock": clock,
    "diagnostics": diagnostics,
    "namespaces": namespaces,
}


if __name__ == "__main__":
    if sys.argv[1] == "--read":
        read(int(sys.argv[2]))
    Node.binaries = Path(sys.argv[1])
    wanted = sys.argv[3:] or list(CHECKS)
    run({name: CHECKS[name] for name in wanted}, int(sys.argv[2]))
