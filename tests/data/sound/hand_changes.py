#!/usr/bin/env python3
"""Writes hand_changes.gcode: a hollow box during which somebody changes what a slicer would not, for sound prints.

Hand-made, not sliced. Set-points of nozzle and bed, fan, speed and flow change between layers as from a printer's panel;
the print dwells, pauses (M0) and asks for a change of filament (M600). None of it is a fault.
"""

import math
import pathlib

HEIGHT_MM, WIDTH_MM, SIDE_MM, LAYERS, LOOPS = 0.2, 0.45, 60.0, 36, 3
SPEED_MM_S, FIRST_SPEED_MM_S, FILAMENT_MM, RETRACT_MM = 45.0, 20.0, 1.75, 0.8

# What somebody does before a layer.
CHANGES = {
    2: ["M106 S128"],
    3: ["M106 S255"],
    5: ["M104 S220"],
    8: ["M104 S212"],
    10: ["M109 S218"],
    12: ["M140 S55"],
    13: ["G4 P8000"],
    14: ["M106 S0"],
    16: ["M106 S255"],
    18: ["M600"],
    21: ["M104 S210"],
    23: ["M140 S60"],
    24: ["M0"],
    26: ["M220 S110"],
    28: ["M220 S100"],
    29: ["M221 S97"],
    31: ["M221 S100"],
    32: ["M109 S215"],
    33: ["M106 S77"],
    34: ["M600"],
}

area_mm2 = HEIGHT_MM * (WIDTH_MM - HEIGHT_MM) + math.pi * HEIGHT_MM**2 / 4
feed = area_mm2 / (math.pi * FILAMENT_MM**2 / 4)
lines = [
    "; written by hand_changes.py: a box during which somebody changes set-points, fan and filament",
    "; filament_type = PLA",
    f"; filament_diameter = {FILAMENT_MM}",
    f"; layer_height = {HEIGHT_MM}",
    "M140 S60",
    "M104 S215",
    "M190 S60",
    "M109 S215",
    "M107",
    "G28",
    "G21",
    "G90",
    "M83",
    "M900 K0.06",
    "G92 E0",
    "G1 Z5 F600",
    "G1 E8 F150",
    f"G1 E-{RETRACT_MM} F2100",
]
for layer in range(LAYERS):
    z_mm = HEIGHT_MM * (layer + 1)
    speed_mm_s = SPEED_MM_S if layer else FIRST_SPEED_MM_S
    lines += [";LAYER_CHANGE", f";Z:{z_mm:.2f}", f";HEIGHT:{HEIGHT_MM}", *CHANGES.get(layer, [])]
    for loop in range(LOOPS):
        low_mm = 80.0 + loop * WIDTH_MM
        high_mm = 80.0 + SIDE_MM - loop * WIDTH_MM
        corners = [(low_mm, low_mm), (high_mm, low_mm), (high_mm, high_mm), (low_mm, high_mm), (low_mm, low_mm)]
        kind = "External perimeter" if loop == 0 else "Perimeter"
        lines += [
            f"G1 X{low_mm:.2f} Y{low_mm:.2f} Z{z_mm:.2f} F9000",
            f"G1 E{RETRACT_MM} F2100",
            f";TYPE:{kind}",
            f";WIDTH:{WIDTH_MM}",
            f"G1 F{60 * speed_mm_s:.0f}",
        ]
        pairs = list(zip(corners, corners[1:]))
        for (x0, y0), (x1, y1) in pairs:
            # Pieces of 10 mm, so that a host that attaches trims to moves can do so.
            pieces = math.ceil(math.hypot(x1 - x0, y1 - y0) / 10.0)
            for piece in range(1, pieces + 1):
                x, y = x0 + (x1 - x0) * piece / pieces, y0 + (y1 - y0) * piece / pieces
                way_mm = math.hypot(x1 - x0, y1 - y0) / pieces
                lines.append(f"G1 X{x:.3f} Y{y:.3f} E{feed * way_mm:.5f}")
        lines.append(f"G1 E-{RETRACT_MM} F2100")
lines += ["G1 Z30 F600", "M107", "M104 S0", "M140 S0", ""]
pathlib.Path(__file__).with_suffix(".gcode").write_text("\n".join(lines))
