"""The message and service definitions of `msgs/` as types of PyPI `cyclonedds`, an independent DDS, and values of them.

Names on the wire are those of ROS 2: `rt/<topic>`, `rq/<service>Request`, `rr/<service>Reply`, `pkg::msg::dds_::Name_`.
"""

from __future__ import annotations

import re
from pathlib import Path

from cyclonedds.idl import annotations, make_idl_struct, types

MSGS = Path(__file__).resolve().parents[2] / "msgs"

PRIMITIVES = {
    "bool": bool, "byte": types.uint8, "char": types.uint8, "string": str,
    "int8": types.int8, "uint8": types.uint8, "int16": types.int16, "uint16": types.uint16,
    "int32": types.int32, "uint32": types.uint32, "int64": types.int64, "uint64": types.uint64,
    "float32": types.float32, "float64": types.float64,
}

FIELD = re.compile(r"^([A-Za-z_][\w/]*)(\[(?:<=)?\d*\])?\s+([a-z]\w*)\s*$")
CONSTANT = re.compile(r"^[A-Za-z_]\w*\s+([A-Z][A-Z0-9_]*)\s*=\s*(\S+)")


class Definitions:
    """All definitions; types are built when they are asked for."""

    def __init__(self) -> None:
        self.texts: dict[str, str] = {}
        for path in sorted(MSGS.glob("msg/*.msg")):
            self.texts[f"fdm_loop_msgs/{path.stem}"] = path.read_text()
        for path in sorted(MSGS.glob("standard/*/*.msg")):
            self.texts[f"{path.parent.name}/{path.stem}"] = path.read_text()
        self.services: dict[str, str] = {}
        for path in sorted(MSGS.glob("srv/*.srv")):
            self.services[f"fdm_loop_msgs/{path.stem}"] = path.read_text()
        for path in sorted(MSGS.glob("standard/*/*.srv")):
            self.services[f"{path.parent.name}/{path.stem}"] = path.read_text()
        self.built: dict[str, type] = {}

    def message(self, name: str) -> type:
        """The type `package/Name`."""
        if name not in self.built:
            package, base = name.split("/")
            self.built[name] = self._struct(f"{package}::msg::dds_::{base}_", self.fields(name))
        return self.built[name]

    def service(self, name: str, part: str, header: bool = True) -> type:
        """`Request` or `Response` of a service: as Cyclone's RMW has it with the header in front of the payload."""
        key = f"{name}_{part}_{header}"
        if key not in self.built:
            package, base = name.split("/")
            text = self.services[name].split("---")[0 if part == "Request" else 1]
            fields = self._parse(text, package) or {"structure_needs_at_least_one_member": types.uint8}
            if header:
                fields = {"guid": types.uint64, "sequence_number": types.int64, **fields}
            self.built[key] = self._struct(f"{package}::srv::dds_::{base}_{part}_", fields)
        return self.built[key]

    def fields(self, name: str) -> dict[str, object]:
        return self._parse(self.texts[name], name.split("/")[0])

    def constants(self, name: str) -> dict[str, int]:
        found = (CONSTANT.match(line) for line in self.texts[name].splitlines())
        return {match[1]: int(match[2]) for match in found if match}

    def _parse(self, text: str, package: str) -> dict[str, object]:
        fields: dict[str, object] = {}
        for line in text.splitlines():
            match = FIELD.match(line.split("#")[0].strip())
            if match:
                fields[match[3]] = self._type(match[1], match[2], package)
        return fields

    def _type(self, name: str, array: str | None, package: str) -> object:
        base = PRIMITIVES.get(name) or self.message(name if "/" in name else f"{package}/{name}")
        if array is None:
            return base
        size = array.strip("[]")
        return types.array[base, int(size)] if size.isdigit() else types.sequence[base]

    @staticmethod
    def _struct(typename: str, fields: dict[str, object]) -> type:
        made = make_idl_struct(typename.replace("::", "_"), typename, fields)
        return annotations.final(made)


def bounds(kind_name: str) -> tuple[int, int]:
    """Least and largest integer of a type by its name: `uint16`."""
    bits = int(re.search(r"int(8|16|32|64)", kind_name)[1])
    return (0, 2**bits - 1) if "uint" in kind_name else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)


def number_of(kind_name: str, number: int, extreme: bool) -> float | int:
    """A number by its type's name; an extreme one lies at an end of the range."""
    if "float" in kind_name:
        # Exact in single precision too.
        return -number * 2.0**100 if extreme else number * 0.5
    if not extreme:
        return number % 100
    low, high = bounds(kind_name)
    return low + number % 100 if low < 0 and number % 2 else high - number % 100


def value(kind: object, seed: list[int], extreme: bool = False) -> object:
    """A value of a type in which no two numbers are alike, so that a swapped field is seen. An extreme one has numbers at the
    ends of their ranges, negative ones among them, and nothing in its texts and sequences."""
    seed[0] += 1
    number = seed[0]
    if kind is str:
        return "" if extreme else f"word {number} \u00b5"
    if kind is bool:
        return number % 2 == 0
    name = getattr(kind, "__idl_typename__", None)
    if name is not None:
        return kind(**{field: value(sub, seed, extreme) for field, sub in kind.__annotations__.items()})
    metadata = getattr(kind, "__metadata__", None)
    if metadata is not None:
        inner = metadata[0]
        subtype = getattr(inner, "subtype", None)
        if subtype is not None:
            length = getattr(inner, "length", None) or (0 if extreme else 2)
            return [value(subtype, seed, extreme) for _ in range(length)]
        return number_of(str(inner), number, extreme)
    raise TypeError(f"{kind}: no value")
