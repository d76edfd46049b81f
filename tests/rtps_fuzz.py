#!/usr/bin/env python3
"""Sends garbage to the RTPS ports of running nodes, on the loopback interface of this network namespace (X1).

    rtps_fuzz.py --kind data_frag --count 1000 --seed 1 --rate 2000 --nodes mpc_controller,imu

Each datagram is made of seed, kind and number alone, so that a failure can be made again. The ports are those that the
named programs hold, looked up anew while it runs: who was ended and started again is hit again. With `--multicast` the
groups in which participants announce themselves and data is sent to all are hit too; with `--each` every datagram goes to
the discovery port of every participant, one after the other. Standard library only. The last line of the output is a
JSON object: what was sent, and in what time.
"""
import argparse
import json
import os
import random
import socket
import struct
import time

GROUP = "239.255.0.1"
# RTPS 2.5, 9.6.2.3: ports of a domain.
BASE, OF_DOMAIN, SPAN = 7400, 250, 250
# Ports are looked up anew after this many seconds.
LOOK_S = 0.1
# Where nobody listens.
DISCARD = 9
# Datagrams of a fake participant to one port, its announcement among them.
TALK = 64

PAD, ACKNACK, HEARTBEAT, GAP, INFO_TS, INFO_SRC, INFO_DST, NACK_FRAG, HEARTBEAT_FRAG, DATA, DATA_FRAG = (
    0x01, 0x06, 0x07, 0x08, 0x09, 0x0C, 0x0E, 0x12, 0x13, 0x15, 0x16)
SUBMESSAGES = [PAD, ACKNACK, HEARTBEAT, GAP, INFO_TS, INFO_SRC, INFO_DST, 0x0D, 0x0F, NACK_FRAG, HEARTBEAT_FRAG, DATA,
               DATA_FRAG]
# Topics, publications, subscriptions, liveliness: middle bytes of writer (c2) and reader (c7), 9.3.1.5; and SPDP.
BUILTIN = [b"\0\0\2", b"\0\0\3", b"\0\0\4", b"\0\2\0"]
SPDP = b"\0\1\0"
UNKNOWN = b"\0\0\0\0"
LAST = 2**63 - 1
NUMBERS = [0, 1, 2, 255, 256, 257, 2**31 - 1, 2**31, 2**32 - 1, 2**32, 2**62, LAST - 1, LAST, -1, -2**63]
# Parameters of discovery: version, vendor, GUIDs, locators, names, leases, endpoints, QoS.
PARAMETERS = [0x02, 0x05, 0x07, 0x0B, 0x15, 0x16, 0x1A, 0x1B, 0x1D, 0x1E, 0x23, 0x27, 0x29, 0x2F, 0x30, 0x31, 0x32, 0x33,
              0x40, 0x41, 0x43, 0x48, 0x50, 0x52, 0x53, 0x58, 0x59, 0x5A, 0x60, 0x62, 0x70, 0x71, 0x77]


def header(prefix):
    return b"RTPS\x02\x04\x01\x12" + prefix


def submessage(kind, body, flags=0x01):
    return struct.pack("<BBH", kind, flags, len(body) & 0xFFFF) + body


def number(value):
    """A sequence number: high half, low half."""
    return struct.pack("<Q", ((value >> 32) & 0xFFFFFFFF) | (value & 0xFFFFFFFF) << 32)


def parameter(name, value):
    value += b"\0" * (-len(value) % 4)
    return struct.pack("<HH", name, len(value) & 0xFFFF) + value


def text(string):
    return struct.pack("<I", len(string) + 1) + string + b"\0"


def locator(address, port, kind=1):
    return struct.pack("<iI", kind, port) + b"\0" * 12 + bytes(int(part) for part in address.split("."))


def data(reader, writer, sequence, payload, flags=0x05):
    return submessage(DATA, struct.pack("<HH", 0, 16) + reader + writer + number(sequence) + payload, flags)


def participant(prefix, ports, lease=LAST):
    """An announcement in every respect as those of a sound participant."""
    listed = b"".join(
        parameter(name, locator("127.0.0.1", ports[offset % len(ports)])) for offset, name in enumerate((0x32, 0x31)))
    return b"\0\3\0\0" + b"".join([
        parameter(0x15, b"\2\4"),
        parameter(0x16, b"\1\x12"),
        parameter(0x50, prefix + b"\0\0\1\xc1"),
        listed,
        parameter(0x02, struct.pack("<iI", min(lease, 2**31 - 1), 0)),
        parameter(0x58, struct.pack("<I", 0xC3F)),
        parameter(0x01, b""),
    ])


def endpoint(random_, prefix, writer):
    """A writer or reader that discovery believes, on a topic of the graph or none."""
    topic = random_.choice([b"rt/printer/safety/command", b"rt/clock", b"rt/printer/heartbeat", random_.randbytes(20)])
    entity = random_.randbytes(3) + (b"\3" if writer else b"\4")
    return b"\0\3\0\0" + b"".join([
        parameter(0x5A, prefix + entity),
        parameter(0x50, prefix + b"\0\0\1\xc1"),
        parameter(0x05, text(topic)),
        parameter(0x07, text(b"std_msgs::msg::dds_::Header_")),
        parameter(0x1A, struct.pack("<IiI", 2, 0, 0)),
        parameter(0x1D, struct.pack("<I", random_.randrange(2))),
        parameter(0x01, b""),
    ])


def mutated(random_, payload):
    """A parameter list with lengths, values and tags that lie."""
    payload = bytearray(payload)
    for _ in range(random_.randrange(1, 6)):
        at = random_.randrange(4, max(len(payload), 5))
        choice = random_.randrange(4)
        if choice == 0 and at < len(payload):
            payload[at] ^= 1 << random_.randrange(8)
        elif choice == 1:
            payload[at:at + 4] = struct.pack("<I", random_.choice([0, 1, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFF]))
        elif choice == 2:
            del payload[at:]
        else:
            name = random_.choice(PARAMETERS)
            payload[4:4] = parameter(name, random_.randbytes(random_.choice([0, 1, 4, 8, 12, 16, 24, 300])))
    return bytes(payload)


def a_prefix(random_):
    return b"\1\x12" + random_.randbytes(10)


# One function a kind: random numbers, number of the datagram, ports of the nodes -> datagram.

def garbage(random_, _number, _ports):
    return random_.randbytes(random_.choice([0, 1, 3, 4, 16, 19, 20, 24, 100, 600, 1400, 9000]))


def valid_header(random_, _number, _ports):
    """The header as it ought to be; submessages with random bodies, every other one with a false length."""
    message = header(random_.randbytes(12))
    for _ in range(random_.randrange(1, 8)):
        kind = random_.choice(SUBMESSAGES + [random_.randrange(256)])
        body = random_.randbytes(random_.choice([0, 4, 8, 12, 20, 24, 28, 32, 48, 100]))
        length = len(body) if random_.random() < 0.5 else random_.choice([0, 1, 4, len(body) + 4, 0xFFFF])
        message += struct.pack("<BBH", kind, random_.randrange(256), length) + body
    return message


def discovery(random_, _number, ports):
    """DATA for every reader of discovery and for those of topics: what a participant, a writer or a reader says of itself,
    bent."""
    prefix = a_prefix(random_)
    choice = random_.randrange(4)
    if choice == 0:
        entity, payload = SPDP, participant(prefix, ports, random_.choice([0, 1, 10]))
    elif choice == 3:
        key = b"\0\0" + random_.randbytes(1)
        payload = random_.choice([b"\0\1\0\0", b"\0\0\0\0", b""]) + random_.randbytes(random_.randrange(200))
        sequence = random_.choice(NUMBERS)
        return header(prefix) + data(key + b"\4", key + b"\3", sequence, payload, random_.choice([1, 3, 5, 7, 9]))
    else:
        entity, payload = BUILTIN[choice], endpoint(random_, prefix, choice == 1)
    flags = random_.choice([0x05, 0x05, 0x07, 0x09])
    return header(prefix) + data(
        random_.choice([UNKNOWN, entity + b"\xc7"]), entity + b"\xc2", random_.choice(NUMBERS), mutated(random_, payload),
        flags)


def heartbeats(random_, _number, _ports):
    """HEARTBEAT, GAP and their kin for fragments: histories that no writer has."""
    message = header(a_prefix(random_))
    for _ in range(random_.randrange(1, 5)):
        entity = random_.choice(BUILTIN + [SPDP, b"\0\0" + random_.randbytes(1)])
        ends = random_.choice([UNKNOWN, entity + b"\xc7", entity + b"\4"]) + entity + random_.choice([b"\xc2", b"\3"])
        first, last, count = random_.choice(NUMBERS), random_.choice(NUMBERS), random_.randbytes(4)
        bits = random_.choice([0, 1, 256, 257, 0xFFFFFFFF])
        some = number(last) + struct.pack("<I", bits) + random_.randbytes(random_.choice([0, 4, 32]))
        message += random_.choice([
            submessage(HEARTBEAT, ends + number(first) + number(last) + count, random_.choice([1, 3, 5, 7])),
            submessage(GAP, ends + number(first) + some),
            submessage(HEARTBEAT_FRAG, ends + number(first) + random_.randbytes(4) + count),
            submessage(NACK_FRAG, ends + number(first) + some[4:] + count),
        ])
    return message


def fake_of(index):
    """One of few participants, which all later datagrams of a kind come from."""
    return b"\1\x12fuzz" + struct.pack("<IH", index % 16, 0xF022)


def acknack(random_, index, ports):
    """Each fake participant announces itself, then acknowledges what was never sent, to the last number there is."""
    prefix = fake_of(index // TALK)
    if index % TALK == 0:
        return header(prefix) + data(UNKNOWN, SPDP + b"\xc2", 1, participant(prefix, ports, 30))
    message = header(prefix)
    for _ in range(random_.randrange(1, 4)):
        entity = random_.choice(BUILTIN)
        base = random_.choice([LAST, LAST, random_.choice(NUMBERS)])
        bits = random_.choice([0, 0, 1, 256, 0xFFFFFFFF])
        bitmap = random_.randbytes(4 * ((bits + 31) // 32)) if bits <= 256 else b""
        message += submessage(
            ACKNACK, entity + b"\xc7" + entity + b"\xc2" + number(base) + struct.pack("<I", bits) + bitmap
            + struct.pack("<I", index), random_.choice([1, 3]))
    return message


def known_writer(random_, index, ports):
    """Heartbeats and gaps of fake participants that were announced: their readers go and ask for what is said to be there."""
    prefix = fake_of(index // TALK)
    if index % TALK == 0:
        return header(prefix) + data(UNKNOWN, SPDP + b"\xc2", 1, participant(prefix, ports, 30))
    return header(prefix) + heartbeats(random_, index, ports)[20:]


def data_frag(random_, _number, _ports):
    """A fragment of a sample that is said to be of up to 4 GiB: the receiver makes room for all of it."""
    size = random_.choice([2**20, 2**24, 2**28, 2**30, 2**31 - 1, 2**32 - 1])
    fragment = random_.choice([1, 1000, 1024, 65535])
    entity = random_.choice(BUILTIN + [SPDP, SPDP])
    payload = random_.randbytes(min(fragment, 1000))
    return header(a_prefix(random_)) + submessage(
        DATA_FRAG, struct.pack("<HH", 0, 28) + entity + b"\xc7" + entity + b"\xc2" + number(random_.randrange(1, 100))
        + struct.pack("<IHHI", 1, 1, fragment, size) + payload)


def participants(random_, _number, ports):
    """A participant that nobody has heard of, that never leaves, and answers nothing."""
    prefix = a_prefix(random_)
    return header(prefix) + data(UNKNOWN, SPDP + b"\xc2", 1, participant(prefix, ports))


KINDS = {
    "garbage": garbage,
    "valid_header": valid_header,
    "discovery": discovery,
    "heartbeats": heartbeats,
    "known_writer": known_writer,
    "acknack": acknack,
    "data_frag": data_frag,
    "participants": participants,
}


def sockets_of(nodes):
    """Inodes of the sockets that the programs of these names hold."""
    inodes = set()
    for process in filter(str.isdigit, os.listdir("/proc")):
        try:
            if os.path.basename(os.readlink(f"/proc/{process}/exe")) not in nodes:
                continue
            for entry in os.listdir(f"/proc/{process}/fd"):
                target = os.readlink(f"/proc/{process}/fd/{entry}")
                if target.startswith("socket:["):
                    inodes.add(target[8:-1])
        except OSError:
            continue  # it has ended meanwhile, or is another user's
    return inodes


def ports_of(nodes, domain):
    """Unicast RTPS ports of these programs in a domain; those in which groups are heard are shared by all."""
    first = BASE + OF_DOMAIN * domain
    inodes = sockets_of(nodes)
    ports = set()
    with open("/proc/net/udp", encoding="ascii") as table:
        for line in table.readlines()[1:]:
            fields = line.split()
            port = int(fields[1].rsplit(":", 1)[1], 16)
            if fields[9] in inodes and first + 10 <= port < first + SPAN:
                ports.add(port)
    return sorted(ports)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--kind", choices=KINDS, required=True)
    arguments.add_argument("--count", type=int, required=True)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--rate", type=float, default=2000.0, help="datagrams a second at most")
    arguments.add_argument("--domain", type=int, default=0)
    arguments.add_argument("--nodes", required=True, help="programs that are hit, separated by commas")
    arguments.add_argument("--multicast", action="store_true")
    arguments.add_argument("--each", action="store_true")
    options = arguments.parse_args()
    make, nodes = KINDS[options.kind], set(options.nodes.split(","))
    out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    out.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))
    first = BASE + OF_DOMAIN * options.domain
    groups = [(GROUP, first), (GROUP, first + 1)] if options.multicast else []
    begin = looked = time.monotonic()
    ports, size, refused = ports_of(nodes, options.domain), 0, 0
    hit = set(ports)
    for index in range(options.count):
        now = time.monotonic()
        if now - looked > LOOK_S:
            looked, ports = now, ports_of(nodes, options.domain)
            hit.update(ports)
        wait = begin + index / options.rate - now
        if wait > 0:
            time.sleep(wait)
        # Who is nowhere gets nothing, and what was to be sent is sent all the same.
        heard = [port for port in ports if not options.each or port % 2 == 0] or [DISCARD]
        targets = [("127.0.0.1", port) for port in heard] + groups
        made_of = index // len(targets) if options.each else index
        random_ = random.Random(f"{options.seed} {options.kind} {made_of}")
        datagram = make(random_, made_of, heard)
        if options.each:
            chosen = index % len(targets)
        elif make in (acknack, known_writer):
            # A fake participant says all it has to say to one of them.
            chosen = index // TALK % len(targets)
        else:
            chosen = random_.randrange(len(targets))
        try:
            size += out.sendto(datagram, targets[chosen])
        except OSError:
            refused += 1
    took = time.monotonic() - begin
    print(json.dumps({"kind": options.kind, "sent": options.count - refused, "refused": refused, "bytes": size,
                      "took_s": round(took, 3), "ports": sorted(hit)}))


if __name__ == "__main__":
    main()
