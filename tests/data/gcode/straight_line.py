#!/usr/bin/env python3
"""Writes straight_line.gcode: one road of constant speed, as the figures of constant speed need it.

No bed is six metres long: the file is for the simulator. 50 mm/s, 0.2 mm high, 0.48 mm wide, in pieces of 20 mm, so
that a host that attaches trims to moves can do so.
"""

import math
import pathlib

SPEED_MM_S, HEIGHT_MM, WIDTH_MM, PIECE_MM, PIECES = 50.0, 0.2, 0.48, 20.0, 300
FILAMENT_MM = 1.75

area_mm2 = HEIGHT_MM * (WIDTH_MM - HEIGHT_MM) + math.pi * HEIGHT_MM**2 / 4
feed = area_mm2 * PIECE_MM / (math.pi * FILAMENT_MM**2 / 4)
lines = [
    "; written by straight_line.py: a road of constant speed for the simulator, no printer has such a bed",
    "; filament_type = PLA",
    f"; filament_diameter = {FILAMENT_MM}",
    f"; layer_height = {HEIGHT_MM}",
    "M140 S60",
    "M104 S210",
    "M190 S60",
    "M109 S210",
    "M106 S255",
    "G28",
    "G21",
    "G90",
    "M83",
    "M900 K0.63",
    "G92 E0",
    "G1 Z5 F600",
    "G1 E15 F150",
    "G4 P5000",
    f"G1 Z{HEIGHT_MM} F600",
    ";LAYER_CHANGE",
    f";Z:{HEIGHT_MM}",
    f";HEIGHT:{HEIGHT_MM}",
    ";TYPE:External perimeter",
    f";WIDTH:{WIDTH_MM}",
    f"G1 F{60 * SPEED_MM_S:.0f}",
]
lines += [f"G1 X{PIECE_MM * (piece + 1):.0f} Y0 E{feed:.5f}" for piece in range(PIECES)]
lines += ["M107", "M104 S0", "M140 S0", ""]
pathlib.Path(__file__).with_suffix(".gcode").write_text("\n".join(lines))
