#!/usr/bin/env python3
"""What the grid's balance takes of the stress at a body's edge: a strip under uniform tension, inclined to the grid, and its nodes free (2-D, h = E = 1, nu = 0).

    benchmarks/stability/edge_stress.py [--particles P] [--places N]

A uniform tension along the strip is in balance in a body. On the grid it is not: a node outside the strip that only some outermost particles reach
has a force from them, and almost no mass. The nodes move to where all forces are zero (but near the ends), which adds to each particle the strain
at its place, as in a step, and moves the particles by the mean of the nodes. Printed is the change of axial strain by layer over the strain that was
there: that of the particles, which their stress follows, and that of their places, from neighbours along the strip. Mean over N places of the strip on
the grid, by the generator of seed 0, 1, ... Needs numpy.
"""
import argparse

import numpy
from adrift_modes import cubic, quadratic

DEPTH, LENGTH = 4, 14  # of the strip [cells]


def gradients(places, shape):
    """Nodes by their place, and rows (particle, node, weight, its slope along x, along y)."""
    nodes, rows = {}, []
    for p, place in enumerate(places):
        (i0, fx), (j0, fy) = ((int(numpy.floor(x)) - 2, [shape(x - int(numpy.floor(x)) + 2 - k) for k in range(6)]) for x in place)
        for i, (wx, gx) in enumerate(fx):
            for j, (wy, gy) in enumerate(fy):
                if wx > 0 and wy > 0:
                    rows.append((p, nodes.setdefault((i0 + i, j0 + j), len(nodes)), wx * wy, gx * wy, wx * gy))
    return nodes, rows


def balance(angle, shape, per_cell, shift):
    """(change of axial strain of the particles, of their places) by layer, from below."""
    along = numpy.array([numpy.cos(angle), numpy.sin(angle)])
    across = numpy.array([-along[1], along[0]])
    layers, columns = DEPTH * per_cell, LENGTH * per_cell
    s, t = ((numpy.arange(n) + 0.5) / per_cell - size / 2 for n, size in ((columns, LENGTH), (layers, DEPTH)))
    places = (s[:, None, None] * along + t[None, :, None] * across).reshape(-1, 2) + shift
    nodes, rows = gradients(places, shape)
    strain, value = numpy.zeros((3 * len(places), 2 * len(nodes))), numpy.zeros((len(places), len(nodes)))  # xx, yy, xy
    for p, k, w, gx, gy in rows:
        value[p, k] = w
        strain[3 * p, 2 * k], strain[3 * p + 1, 2 * k + 1] = gx, gy
        strain[3 * p + 2, 2 * k], strain[3 * p + 2, 2 * k + 1] = gy / 2, gx / 2
    work = strain.T * numpy.tile([1.0, 1.0, 2.0], len(places))
    tension = numpy.tile([along[0]**2, along[1]**2, along[0] * along[1]], len(places))
    free = numpy.repeat(abs((numpy.array(list(nodes)) - shift) @ along) < LENGTH / 2 - 2.5, 2)
    moved = numpy.zeros(2 * len(nodes))
    moved[free] = numpy.linalg.lstsq((work @ strain)[numpy.ix_(free, free)], -(work @ tension)[free], rcond=1e-10)[0]
    change = (strain @ moved).reshape(columns, layers, 3)
    axial = change @ [along[0]**2, along[1]**2, 2 * along[0] * along[1]]
    way = (value @ moved.reshape(-1, 2) @ along).reshape(columns, layers)
    middle = abs(s) < LENGTH / 2 - 4
    return axial[middle].mean(axis=0), ((way[2:] - way[:-2]) * per_cell / 2)[middle[1:-1]].mean(axis=0)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--particles", type=int, default=2, metavar="P", help="per cell and direction")
    parser.add_argument("--places", type=int, default=8, metavar="N")
    args = parser.parse_args()
    for shape in (quadratic, cubic):
        for degrees in (0, 10, 20, 30, 45):
            found = [balance(numpy.radians(degrees), shape, args.particles, numpy.random.default_rng(k).random(2)) for k in range(args.places)]
            kept, places = (100 * numpy.mean(part, axis=0) for part in zip(*found))
            inner = max(abs(kept[1:-1]).max(), abs(places[1:-1]).max())
            print(f"{shape.__name__}, {degrees} degrees: outermost layers {kept[0]:+.1f} and {kept[-1]:+.1f} %, by their places {places[0]:+.1f} and {places[-1]:+.1f} %, others at most {inner:.1f} %", flush=True)


if __name__ == "__main__":
    main()
