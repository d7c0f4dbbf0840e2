#!/usr/bin/env python3
"""Which mode grows in a bar adrift: the linear step of one cell's particles (1-D, h = c = rho = 1), over one cell's way.

    benchmarks/stability/adrift_modes.py [--drift U] [--steps N] [--particles P]

State by particle: velocity, C and stress, of a wave exp(i theta n) over the cells n. The product of the N steps in which the particles
move by one cell has eigenvalues: how each mode grows (Floquet). Largest growth of the energy in a period of 64 cells, over all waves from 2 to
64 cells long, and of the mode that grows: how much of its stress alternates from particle to particle inside a cell. Needs numpy.
"""
import argparse

import numpy


def quadratic(x):
    """Value and slope of the spline at x."""
    a = abs(x)
    if a < 0.5:
        return 0.75 - a * a, -2 * x
    return (0.5 * (1.5 - a)**2, -(1.5 - a) * numpy.sign(x)) if a < 1.5 else (0.0, 0.0)


def cubic(x):
    a, s = abs(x), numpy.sign(x)
    if a < 1:
        return 2 / 3 - a * a + a**3 / 2, s * (1.5 * a * a - 2 * a)
    return ((2 - a)**3 / 6, -0.5 * s * (2 - a)**2) if a < 2 else (0.0, 0.0)


SHAPES = {quadratic: 1 / 4, cubic: 1 / 3}  # D of APIC
METHODS = {"AFLIP USL": (0.95, True, quadratic, False, 0), "all of FLIP, AFLIP USL": (1, True, quadratic, False, 0), "APIC USL": (0, True, quadratic, False, 0), "FLIP USL": (1, False, quadratic, False, 0),
           "AFLIP USF": (0.95, True, quadratic, True, 0), "APIC USF": (0, True, quadratic, True, 0), "FLIP USF": (1, False, quadratic, True, 0), "cubic AFLIP USL": (0.95, True, cubic, False, 0),
           "AFLIP USL, half of FLIP": (0.5, True, quadratic, False, 0), "AFLIP USL, stress at x + U dt / 2": (0.95, True, quadratic, False, 0.5),
           "AFLIP USL, 1 % of the stress from the grid": (0.95, True, quadratic, False, -0.01)}


def stencil(x, shape):
    return {i: shape(x - i) for i in range(int(numpy.floor(x)) - 2, int(numpy.floor(x)) + 4) if shape(x - i)[0] > 0}


def one_step(theta, x, dt, drift, method):
    flip, affine, shape, first, extra = method
    count = len(x)
    near = [stencil(place, shape) for place in x]
    mass = sum(w for nodes in near for w, _ in nodes.values()) / count
    momentum, force = numpy.zeros((2, 3 * count), complex)
    for p, nodes in enumerate(near):
        for i, (w, slope) in nodes.items():
            phase = numpy.exp(-1j * theta * i) / count
            momentum[3 * p] += w * phase
            momentum[3 * p + 1] += affine * w * phase * (i - x[p])
            force[3 * p + 2] -= slope * phase

    def rate(p, place):
        """grad v at a place, over the velocity of node 0."""
        return sum(slope * numpy.exp(1j * theta * i) for i, (_, slope) in stencil(place, shape).items())

    strained = numpy.eye(3 * count, dtype=complex)
    for p in range(count if first else 0):
        strained[3 * p + 2] += dt * rate(p, x[p]) * momentum / mass
    gain = dt * (force @ strained) / mass
    speed = momentum / mass + gain
    step = strained.copy()
    for p, nodes in enumerate(near):
        value = sum(w * numpy.exp(1j * theta * i) for i, (w, _) in nodes.items())
        arm = sum(w * numpy.exp(1j * theta * i) * (i - x[p]) for i, (w, _) in nodes.items())
        step[3 * p] = flip * value * gain + (1 - flip) * value * speed
        step[3 * p, 3 * p] += flip
        step[3 * p + 1] = affine * arm / SHAPES[shape] * speed
        if not first:
            step[3 * p + 2] += dt * rate(p, x[p] + max(extra, 0) * drift * dt) * speed
    return evened(theta, near, mass, -extra) @ step if extra < 0 else step


def evened(theta, near, mass, share):
    """Takes a share of the stress from the grid's mean."""
    count = len(near)
    mean = numpy.zeros(3 * count, complex)
    for p, nodes in enumerate(near):
        mean[3 * p + 2] = sum(w * numpy.exp(-1j * theta * i) for i, (w, _) in nodes.items()) / (count * mass)
    even = numpy.eye(3 * count, dtype=complex)
    for p, nodes in enumerate(near):
        even[3 * p + 2] = (1 - share) * even[3 * p + 2] + share * sum(w * numpy.exp(1j * theta * i) for i, (w, _) in nodes.items()) * mean
    return even


def grow(cells, steps, drift, particles, method):
    """(growth of the energy in a period of 64 cells, share of the stress's energy that alternates inside a cell) of the mode that grows most."""
    theta, dt = 2 * numpy.pi / cells, 1 / (drift * steps)
    start = (numpy.arange(particles) + 0.5) / particles
    product = numpy.eye(3 * particles, dtype=complex)
    for k in range(steps):
        product = one_step(theta, start + k / steps, dt, drift, method) @ product
    values, modes = numpy.linalg.eig(product)
    largest = numpy.abs(values).argmax()
    stress = modes[2::3, largest] * numpy.exp(-1j * theta * start)
    smooth = abs(stress.mean())**2 / numpy.mean(abs(stress)**2)
    return 2 * numpy.log(abs(values[largest])) * 64 / (dt * steps), 1 - smooth


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drift", type=float, default=0.05, metavar="U", help="over c")
    parser.add_argument("--steps", type=int, default=35, metavar="N", help="in which the particles move by a cell; dt c / h = 1 / (N U)")
    parser.add_argument("--particles", type=int, default=2, metavar="P", help="in a cell")
    args = parser.parse_args()
    print(f"U = {args.drift:g} c, dt c / h = {1 / (args.drift * args.steps):.3f}, {args.particles} particles in a cell")
    for name, method in METHODS.items():
        (growth, alternating), cells = max((grow(64 / k, args.steps, args.drift, args.particles, method), 64 / k) for k in range(1, 33))
        of_wave = grow(64, args.steps, args.drift, args.particles, method)[0]
        print(f"{name}: {growth:+.4f} in a period, wave of {cells:.1f} cells, {100 * alternating:.0f} % of its stress alternates; a wave of 64 cells {of_wave:+.4f}")


if __name__ == "__main__":
    main()
