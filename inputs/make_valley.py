#!/usr/bin/env python3
"""Makes inputs/valley.asc, valley_release.csv, valley_gauges.csv, valley_sections.csv,
valley_path.csv and valley_inflow.csv: a steep head, a channel that bends, and a plain.

    python3 inputs/make_valley.py

Heights are formulas of this file, so the valley is free to use. Two metres between nodes.
"""
import math
import pathlib

SIDE, COLUMNS, ROWS = 2.0, 131, 61  # 260 m x 120 m


def height(x, y):
    """A parabola down to a plain at x = 190 m; a channel of 14 m at the head that opens and shallows downhill."""
    fall = max(0.0, 1 - x / 190)
    bed = 62 * fall * fall + 2
    axis = 60 + 10 * math.sin(x / 28)
    width = 14 + 16 * (1 - fall)
    depth = 14 * min(1.0, 2 * fall)
    return bed + depth * (1 - math.exp(-((y - axis) / width) ** 2))


def main():
    here = pathlib.Path(__file__).resolve().parent
    with open(here / "valley.asc", "w") as file:
        file.write(f"ncols {COLUMNS}\nnrows {ROWS}\nxllcenter 0\nyllcenter 0\ncellsize {SIDE:g}\nNODATA_value -9999\n")
        for j in reversed(range(ROWS)):
            file.write(" ".join(f"{height(SIDE * i, SIDE * j):.2f}" for i in range(COLUMNS)) + "\n")
    corners = [(12, 55), (22, 53), (36, 58), (40, 66), (36, 76), (24, 76), (13, 68)]
    (here / "valley_release.csv").write_text("x,y\n" + "".join(f"{x},{y}\n" for x, y in corners))
    (here / "valley_gauges.csv").write_text("name,x,y\nhead,30,66\nchannel,50,68\n")
    (here / "valley_sections.csv").write_text("name,x,y\nneck,56,85\nneck,56,50\n")
    (here / "valley_path.csv").write_text("name,x,y\n" + "".join(f"channel,{x},{60 + 10 * math.sin(x / 28):.1f}\n" for x in range(10, 260, 8)))
    (here / "valley_inflow.csv").write_text("time,discharge,speed\n0,0,1\n5,64,2\n15,20,1\n")


if __name__ == "__main__":
    main()
