"""Several clients of one node, clients that ask for much, and clients in the mapping of Fast DDS.

    clients.py BINARIES DOMAIN [CHECK ...]
"""

from __future__ import annotations

import sys
import tempfile
import threading
import time
from pathlib import Path

from graph import Failed, Node, Peer, PlainService, check, run, until
from user import ACTIVE, INACTIVE, SUPERVISOR, THERMISTOR, UNCONFIGURED, Life, texts

#: Steps that two clients ask for at once, over and over; those that cannot be taken are refused.
STEPS = ((4, 3), (4, 2, 1, 3))
ROUNDS = 10
#: Settings of each kind that come together with a step.
SETTINGS = 10


def two_clients(domain: int) -> str:
    """Every step that two clients ask for at once is answered, taken or refused; then the node goes on."""
    lives = [Life(Peer(domain), "/printer/safety_supervisor") for _ in STEPS]
    node = Node("safety_supervisor", SUPERVISOR, ROS_DOMAIN_ID=domain)
    until(lambda: lives[0].state() == ACTIVE, "active")
    for life in lives:
        life.change.wait()
    answers: list[bool | str] = []

    def ask(life: Life, steps: tuple[int, ...]) -> None:
        for step in steps * ROUNDS:
            try:
                answers.append(life.to(step))
            except Failed as error:
                answers.append(str(error))

    asking = [threading.Thread(target=ask, args=one) for one in zip(lives, STEPS)]
    for thread in asking:
        thread.start()
    for thread in asking:
        thread.join()
    silent = [said for said in answers if not isinstance(said, bool)]
    check(not silent and len(answers) == 60, f"{len(silent)} of {len(answers)} without an answer: {silent[:1]}")
    check(node.process.poll() is None and lives[0].state() in (UNCONFIGURED, INACTIVE, ACTIVE), "it goes on")
    return f"{sum(map(bool, answers))} of {len(answers)} steps taken, all answered"


def long_answers(domain: int) -> str:
    """What would be longer than a datagram comes empty, and whoever asks next is answered."""
    Node("thermistor", THERMISTOR, ROS_DOMAIN_ID=domain)
    peers = Peer(domain), Peer(domain)
    name, kind = "/printer/thermistor/get_parameters", "rcl_interfaces/GetParameters"
    get, other = (peer.service(name, kind) for peer in peers)
    for count, told in ((500, 500), (2000, 0), (1, 1)):
        values = get(names=["hotend.max_c"] * count).values
        check(len(values) == told, f"{len(values)} values of {count} names, not {told}")
    check(len(other(names=["hotend.max_c"]).values) == 1, "another client is answered too")
    return ""


def enhanced(domain: int) -> str:
    """The mapping that holds where RMW_IMPLEMENTATION says nothing of Cyclone: no header in front of the payload."""
    Node("thermistor", THERMISTOR, cyclone=False, ROS_DOMAIN_ID=domain)
    peer, node = Peer(domain), "/printer/thermistor"
    service = lambda name, kind: PlainService(peer, f"{node}/{name}", kind)
    get = service("get_parameters", "rcl_interfaces/GetParameters")
    values = get(names=["hotend.max_c", "no.such"]).values
    check([value.type for value in values] == [3, 0] and values[0].double_value > 0.0, f"{values}")
    state = service("get_state", "lifecycle_msgs/GetState")
    until(lambda: state().current_state.label == "active", "active")
    change = service("change_state", "lifecycle_msgs/ChangeState")
    transition = lambda number: change(transition=change.request.__annotations__["transition"](id=number, label=""))
    check(transition(4).success and state().current_state.id == INACTIVE, "deactivate")
    check(not transition(4).success and transition(3).success, "refused once, activate")
    return ""


def settings_and_steps(domain: int) -> str:
    """A set that makes the configuration fail, and a step right behind it: all are answered, and `active` is at work."""
    with tempfile.TemporaryDirectory() as folder:
        return asked_together(domain, Path(folder))


def asked_together(domain: int, folder: Path) -> str:
    peer, name = Peer(domain), "/printer/bag_recorder"
    words = ["-p", "autostart:=false", "-p", f"bag_dir:={folder}/0"]
    node = Node("bag_recorder", ["bag_recorder.param.yaml"], *words, ROS_DOMAIN_ID=domain)
    life, setting = Life(peer, name), peer.service(f"{name}/set_parameters", "rcl_interfaces/SetParameters").wait()
    check(life.to(1), "configure")

    def at_once(parameter, step: int, pause_s: float) -> tuple[bool, bool]:
        """Whether a parameter was set, and a step taken that was asked for before the answer to that."""
        setting.number += 1
        fields = {"guid": setting.guid, "sequence_number": setting.number}
        setting.writer.write(setting.request(parameters=[parameter], **fields))
        time.sleep(pause_s)
        taken = life.to(step)
        mine = lambda: [one for one in setting.reader.take(10) if one.sequence_number == setting.number]
        return until(mine, "an answer to the setting")[0].results[0].successful, taken

    failed = 0
    for number, step in enumerate((3, 2) * SETTINGS):
        pause_s = (0.0, 0.0005, 0.002)[number % 3]
        was_set, taken = at_once(texts("topics", ["no_such_topic"]), step, pause_s)
        state = until(lambda: state if (state := life.state()) in (UNCONFIGURED, INACTIVE, ACTIVE) else 0, "a state")
        if was_set:
            check(not (taken and step == 3) and state == UNCONFIGURED, f"{step} was taken: {taken}, state {state}")
            failed += 1
        elif step == 3:
            check(state == ACTIVE and life.to(4), "active with what was set before")
        if life.state() == UNCONFIGURED:
            check(setting(parameters=[texts("topics", [])]).results[0].successful, "set while unconfigured")
            check(life.to(1), "configured again")
    for number in range(1, 1 + SETTINGS):
        was_set, taken = at_once(texts("bag_dir", f"{folder}/{number}"), 3, 0.0)
        check(taken and life.state() == ACTIVE, "active")
        there = (folder / str(number)).exists()
        check(there == was_set, f"bag_dir {number} was set: {was_set}; there is one: {there}")
        check(life.to(4), "deactivate")
    blocked = folder / "file"
    blocked.write_text("")
    check(setting(parameters=[texts("bag_dir", f"{blocked}/bag")]).results[0].successful, "a folder in a file")
    check(not life.to(3) and life.state() == UNCONFIGURED, "who cannot write is not active")
    check(node.end() == 0, "an orderly end")
    return f"{failed} of {2 * SETTINGS} configurations failed beside a step, {SETTINGS} folders in force"


CHECKS = {
    "two_clients": two_clients,
    "long_answers": long_answers,
    "enhanced": enhanced,
    "settings_and_steps": settings_and_steps,
}


if __name__ == "__main__":
    Node.binaries = Path(sys.argv[1])
    wanted = sys.argv[3:] or list(CHECKS)
    run({name: CHECKS[name] for name in wanted}, int(sys.argv[2]))
