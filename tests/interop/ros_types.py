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


def value(kind: object, seed: list[int]) -> object:
    """A value of a type in which no two numbers are alike, so that a swapped field is seen."""
    seed[0] += 1
    number = seed[0]
    if kind is str:
        return f"word {number} \u00b5"
    if kind is bool:
        return number % 2 == 0
    name = getattr(kind, "__idl_typename__", None)
    if name is not None:
        return kind(**{field: value(sub, seed) for field, sub in kind.__annotations__.items()})
    metadata = getattr(kind, "__metadata__", None)
    if metadata is not None:
        inner = metadata[0]
        subtype = getattr(inner, "subtype", None)
        if subtype is not None:
            length = getattr(inner, "length", None)
            return [value(subtype, seed) for _ in range(length if length else 2)]
        kind_name = str(inner)
        if "float" in kind_name:
            return number * 0.5
        return number % 100
    raise TypeError(f"{kind}: no value")
