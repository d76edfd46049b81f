#!/usr/bin/env python3
"""Writes identify.gcode: a print that `fdm identify` can learn a printer from, about ten minutes, 200 mm of bed.

Cold start, heat-up, a step of the set-point down and up, steps of the part fan, then roads whose speed (and with it the
flow) changes every few seconds, slow and fast, without and with the fan. One layer, lines 1 mm apart. No advance.
"""

import itertools
import math
import pathlib

HEIGHT_MM, WIDTH_MM, FILAMENT_MM = 0.2, 0.48, 1.75
LEFT_MM, RIGHT_MM, FRONT_MM, APART_MM = 15.0, 215.0, 15.0, 1.0
SET_POINT_C, LOW_C = 220, 180
# Speeds in mm/s and for how long in s; the times are no multiples of a frame's period, so that frames see every phase.
SLOW = [(12, 3.1), (34, 2.3), (18, 2.7), (42, 1.9), (24, 2.2)]
FAST = [(26, 2.9), (68, 1.7), (40, 2.2), (72, 1.8), (52, 2.3)]
BLOCKS = [(SLOW, 0, 48.0), (FAST, 0, 60.0), (FAST, 255, 60.0), (SLOW, 255, 48.0)]

area_mm2 = HEIGHT_MM * (WIDTH_MM - HEIGHT_MM) + math.pi * HEIGHT_MM**2 / 4
per_mm = area_mm2 / (math.pi * FILAMENT_MM**2 / 4)
lines = [
    "; written by identify.py: a print to learn a printer from; no brim, no second layer",
    "; filament_type = PLA",
    f"; filament_diameter = {FILAMENT_MM}",
    f"; layer_height = {HEIGHT_MM}",
    "G21",
    "G90",
    "M83",
    "M107",
    "G28",
    "G4 S20",
    f"M109 S{SET_POINT_C}",
    "G4 S50",
    f"M104 S{LOW_C}",
    "G4 S50",
    f"M109 S{SET_POINT_C}",
    "G4 S30",
    "M106 S255",
    "G4 S50",
    "M106 S128",
    "G4 S30",
    "M107",
    "G4 S45",
    "G92 E0",
    f"G1 Z5 X{LEFT_MM:.0f} Y{FRONT_MM:.0f} F3000",
    "G1 E12 F150",
    f"G1 Z{HEIGHT_MM} F600",
    ";LAYER_CHANGE",
    f";Z:{HEIGHT_MM}",
    f";HEIGHT:{HEIGHT_MM}",
    ";TYPE:External perimeter",
    f";WIDTH:{WIDTH_MM}",
]

x, y, right = LEFT_MM, FRONT_MM, True


def road(length_mm, speed_mm_s):
    """A stretch along the lines, around their ends."""
    global x, y, right
    while length_mm > 1e-6:
        end = RIGHT_MM if right else LEFT_MM
        step = min(length_mm, abs(end - x))
        if step > 1e-6:
            x += step if right else -step
            lines.append(f"G1 X{x:.3f} Y{y:.3f} E{per_mm * step:.5f} F{60 * speed_mm_s:.0f}")
            length_mm -= step
        if abs(end - x) < 1e-6:
            y, right = y + APART_MM, not right
            lines.append(f"G1 X{x:.3f} Y{y:.3f} E{per_mm * APART_MM:.5f} F{60 * speed_mm_s:.0f}")
            length_mm -= APART_MM


for pattern, fan, block_s in BLOCKS:
    lines.append(f"M106 S{fan}" if fan else "M107")
    spent_s = 0.0
    for speed_mm_s, time_s in itertools.cycle(pattern):
        if spent_s >= block_s:
            break
        road(speed_mm_s * time_s, speed_mm_s)
        spent_s += time_s
lines += ["G1 Z10 F600", "M104 S0", "G4 S60", "M107", ""]
assert y < 215.0, y
pathlib.Path(__file__).with_suffix(".gcode").write_text("\n".join(lines))
