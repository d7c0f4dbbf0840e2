"""Norms that cases share: order, Richardson value and grid convergence index; profiles of depth; noise about a moving average.

Order p = log((f3 - f2) / (f2 - f1)) / log r of the three finest levels with one ratio r; GCI = 1.25 |f1 - f2| / (r^p - 1) (Roache 1994). The
formulas are those of `moraine converge`, python/moraine/richardson.py, whose safety factor is larger.
"""
import math

import numpy
from moraine.richardson import distance, observed_order

SAFETY = 1.25  # Roache's


def three_finest(lines, figure):
    """[(level, value)] of the finest three levels of one ratio, coarse to fine; None: there are none."""
    values = {x["level"]: x["figures"][figure] for x in lines if figure in x.get("figures", {})}
    for fine in sorted(values, reverse=True):
        for middle in sorted((n for n in values if n < fine), reverse=True):
            coarse = middle * middle / fine
            if coarse in values:
                return [(int(coarse), values[int(coarse)]), (middle, values[middle]), (fine, values[fine])]
    return None


class Richardson:
    """What three levels say. p and value are None where they are not monotone."""

    def __init__(self, three):
        self.levels, values = tuple(n for n, _ in three), [value for _, value in three]
        cells = [1 / n for n in self.levels]
        self.finest, self.value = values[-1], None
        self.p = observed_order(cells, values)
        if self.p is not None:
            away = distance(cells, values, self.p)
            self.value, self.gci = self.finest + away, SAFETY * abs(away)

    @property
    def reference(self):
        return self.finest if self.value is None else self.value


def richardson(lines, figure):
    three = three_finest(lines, figure)
    return Richardson(three) if three else None


def depth(x, volume, low, high, width):
    """(middles of bins, depth h(x)) of particles of these volumes [m2 per metre]."""
    edges = low + width * numpy.arange(round((high - low) / width) + 1)
    sums = numpy.histogram(x, edges, weights=numpy.broadcast_to(volume, x.shape))[0]
    return 0.5 * (edges[1:] + edges[:-1]), sums / width


def cell_means(x, values, cell):
    """Mean over the particles of each cell that holds some."""
    key = numpy.unique((x[:, :2] / cell).astype(int), axis=0, return_inverse=True)[1].ravel()
    return numpy.bincount(key, values) / numpy.bincount(key)


def rms(values):
    return math.sqrt(numpy.mean(numpy.square(values)))


def l1(h, exact):
    return float(numpy.abs(h - exact).sum() / numpy.abs(exact).sum())


def moving_average(x, y, width):
    """Mean of y over x - width/2 .. x + width/2, for rows in rising x."""
    sums = numpy.concatenate(([0.0], numpy.cumsum(y)))
    low, high = numpy.searchsorted(x, x - width / 2), numpy.searchsorted(x, x + width / 2, side="right")
    return (sums[high] - sums[low]) / (high - low)
