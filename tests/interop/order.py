"""Who starts by itself after others: it waits inactive, says for whom, and goes on when they are active.

    order.py BINARIES DOMAIN
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

from graph import RELIABLE, Node, Peer, check, run, until
from user import ACTIVE, INACTIVE, SUPERVISOR, THERMISTOR, Life

#: Of `lifecycle_msgs/Transition`.
CONFIGURE, ACTIVATE = 1, 3
#: Who is waited for is named after 3 s, and again as often `[s]`.
LATE_S = 3.0
#: Level of a warning in `rcl_interfaces/Log`.
WARN = 30


def order(domain: int) -> str:
    """A thermistor that starts after the supervisor."""
    peer = Peer(domain)
    lines = peer.reader("/rosout", "rcl_interfaces/Log", RELIABLE)
    begin = time.monotonic()
    Node("thermistor", THERMISTOR, "-p", "start_after:=[safety_supervisor]", ROS_DOMAIN_ID=domain)
    life = Life(peer, "/printer/thermistor")
    check(until(life.state, "a state") == INACTIVE, "it waits inactive")
    said = lambda: [line for line in lines.take(100) if line.level == WARN and line.name == "printer.thermistor"]
    first = until(said, "who is waited for")[0]
    told_s = time.monotonic() - begin
    check(first.msg == "not active yet, or not asked yet: safety_supervisor", first.msg)
    check(LATE_S <= told_s, f"named after {told_s:.1f} s already")
    check(life.state() == INACTIVE, "it waits on")

    Node("safety_supervisor", SUPERVISOR, "-p", "autostart:=false", ROS_DOMAIN_ID=domain)
    supervisor = Life(peer, "/printer/safety_supervisor")
    check(supervisor.to(CONFIGURE), "configure the supervisor")
    said()
    until(said, "it is named again, for it is not active")
    check(life.state() == INACTIVE, "who is there and not active is waited for")
    check(supervisor.to(ACTIVATE), "activate the supervisor")
    begin = time.monotonic()
    until(lambda: life.state() == ACTIVE, "it goes on")
    active_s = time.monotonic() - begin
    check(all(node.end() == 0 for node in Node.running), "both end in order")
    return f"named after {told_s:.1f} s, active {active_s * 1e3:.0f} ms after the supervisor"


if __name__ == "__main__":
    Node.binaries = Path(sys.argv[1])
    run({"order": order}, int(sys.argv[2]))
