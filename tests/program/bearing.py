"""The load of a smooth strip footing on weightless undrained soil of strength su0 + k z, by the method of stress characteristics.

Davis and Booker 1973, The effect of increasing strength with depth on the bearing capacity of clays, Géotechnique 23. With the mean
pressure p and the angle t of the largest pressure from x, z down and s = su0 + k z, along the two characteristics

    t + pi/4:  dp + 2 s dt - k dx = 0        t - pi/4:  dp - 2 s dt + k dx = 0

from the free surface (p = su0, t = 0) through the fan at the edge to the footing (t = pi/2, pressure p + su0). k = 0 gives 2 + pi exactly.
"""
import math


def crossing(a, b, su0, k):
    """Where the characteristic t - pi/4 through a meets t + pi/4 through b; points are (x, z, p, t)."""
    x, z, _, t = (0.5 * (u + v) for u, v in zip(a, b))
    for _ in range(60):
        down, up = 0.5 * (a[3] + t) - math.pi / 4, 0.5 * (b[3] + t) + math.pi / 4
        determinant = math.cos(down) * math.sin(up) - math.sin(down) * math.cos(up)
        way = ((b[0] - a[0]) * math.sin(up) - (b[1] - a[1]) * math.cos(up)) / determinant
        before, x, z = (x, z, t), a[0] + way * math.cos(down), a[1] + way * math.sin(down)
        of_a, of_b = su0 + k * (a[1] + z) / 2, su0 + k * (b[1] + z) / 2
        along_a = a[2] - 2 * of_a * a[3] - k * (x - a[0])
        along_b = b[2] + 2 * of_b * b[3] + k * (x - b[0])
        t = (along_b - along_a) / (2 * (of_a + of_b))
        if sum(abs(u - v) for u, v in zip(before, (x, z, t))) < 1e-13:
            break
    return x, z, along_a + 2 * of_a * t, t


def bearing_pressure(su0, k, width, n=40):
    """Mean pressure under the footing at collapse; n characteristics on the surface and in the fan."""
    surface, footing = [], []  # last points of the lines t + pi/4 that begin there
    fan = [(0.0, 0.0, su0 * (1 + math.pi * j / n), 0.5 * math.pi * j / n) for j in range(n + 1)]
    edge, load, x, pressure = 0.5 * width, 0.0, 0.0, su0 * (2 + math.pi)
    while x > -edge:
        start = at = (width / n * (len(surface) + 1), 0.0, su0, 0.0)
        for lines in (surface, fan, footing):
            for c in range(len(lines)) if lines is not surface else reversed(range(len(lines))):
                at = lines[c] = crossing(at, lines[c], su0, k)
        to = at[0] - at[1] / math.tan(0.5 * (at[3] + math.pi / 2) - math.pi / 4)
        mean = at[2] + (2 * su0 + k * at[1]) * (math.pi / 2 - at[3]) - k * (to - at[0])
        part = min(1.0, (x + edge) / (x - to))
        load += part * (x - to) * (pressure + 0.5 * part * (mean + su0 - pressure))
        surface.append(start), footing.append((to, 0.0, mean, math.pi / 2))
        x, pressure = to, mean + su0
    return load / edge
