"""How far a value is from that of infinitely small cells, by values on cells of three sizes: order, Richardson value, GCI.

With cells h1 < h2 < h3, values f1, f2, f3 and ratios r21 = h2 / h1, r32 = h3 / h2, the order p is the root of
    (f3 - f2) / (f2 - f1) = r21^p (r32^p - 1) / (r21^p - 1),
the Richardson value f1 + (f1 - f2) / (r21^p - 1), and the grid convergence index F |f1 - f2| / (r21^p - 1) with a safety
factor F (Roache 1994; Celik et al. 2008). Roache's F = 1.25 holds where p is the order of the method; where it is not, bars
of 1.25 miss more than one value in twenty. F(p) is that of Xing and Stern (2010), made for 95 % of 98 flows with known errors.
Pure Python: benchmarks/validation uses it too.
"""
import dataclasses
import math
from typing import Optional, Sequence

THEORETICAL = 2.0  # order of the method where nothing is rough: quadratic shapes, centred differences in time
LARGEST = 64.0     # of an order: a larger one is that of a value which is the same but for rounding
ROUNDING = 1e-12   # of a value: smaller differences say nothing


def observed_order(cells: Sequence[float], values: Sequence[float]) -> Optional[float]:
    """The order that three values show; `cells` and `values` from coarse to fine. None where they do not converge.

    >>> round(observed_order([0.4, 0.2, 0.1], [1 + 3 * h**1.5 for h in (0.4, 0.2, 0.1)]), 6)
    1.5
    >>> observed_order([4, 2, 1], [3.0, 1.0, 2.0])
    """
    (h3, h2, h1), (f3, f2, f1) = cells, values
    if f2 == f1 or (f3 - f2) / (f2 - f1) <= 0:
        return None
    fine, coarse, change = math.log(h2 / h1), math.log(h3 / h2), math.log((f3 - f2) / (f2 - f1))

    def excess(p: float) -> float:  # rises with p
        return p * fine + math.log(math.expm1(p * coarse) / math.expm1(p * fine)) - change
    low, high = 1e-6, LARGEST
    if excess(low) >= 0:
        return None  # the differences do not shrink
    if excess(high) <= 0:
        return high
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if excess(middle) < 0 else (low, middle)
    return (low + high) / 2


def distance(cells: Sequence[float], values: Sequence[float], order: float) -> float:
    """(f1 - f2) / (r21^p - 1): what the Richardson value adds to the finest value."""
    return (values[-1] - values[-2]) / math.expm1(order * math.log(cells[-2] / cells[-1]))


def safety_factor(order: float) -> float:
    """Xing and Stern's factor for an observed order: 1.6 where it is the theoretical one, up to 2.45 below, more above.

    >>> [round(safety_factor(p), 2) for p in (0.5, 1.0, 2.0, 2.5)]
    [2.24, 2.03, 1.6, 5.7]
    """
    share = order / THEORETICAL
    return 2.45 - 0.85 * share if share <= 1 else 16.4 * share - 14.8


@dataclasses.dataclass(frozen=True)
class Estimate:
    """What the finest three levels say of a value.

    verdict: "converges", "equal" (the same to rounding), "oscillates", "stalls" (the finest two are the same, the
    third is not), "diverges", or "too few" (levels). origin: where the value is counted from, as the place of a front at the start. order, value (that
    of Richardson), safety and error (GCI, in the unit of the value, with `resolution` added) are None without convergence.
    """

    verdict: str
    finest: float
    order: Optional[float] = None
    value: Optional[float] = None
    safety: Optional[float] = None
    error: Optional[float] = None
    origin: float = 0.0

    @property
    def relative(self) -> Optional[float]:
        """The error over the distance of the finest value from its origin, None where there is none."""
        if self.error is None or (self.finest == self.origin and self.error > 0):
            return None
        return self.error / abs(self.finest - self.origin) if self.error else 0.0


def estimate(cells: Sequence[float], values: Sequence[float], resolution: float = 0.0, origin: float = 0.0) -> Estimate:
    """Of values on cells [m] from coarse to fine, of which the last three count. `resolution` is what the value is known to
    beside the cells, half a cell for a front that is counted in cells; `origin`: where it is counted from, of which its share is.

    >>> found = estimate([4, 3, 2], [10 + h**2 for h in (4, 3, 2)])
    >>> found.verdict, round(found.order, 3), round(found.value, 3), round(found.safety, 2), round(found.error, 2)
    ('converges', 2.0, 10.0, 1.6, 6.4)
    >>> estimate([4, 2, 1], [1.0, 2.0, 1.5]).verdict
    'oscillates'
    """
    if len(values) < 3:
        return Estimate("too few", values[-1], origin=origin)
    cells, values = cells[-3:], values[-3:]
    coarse, fine = values[1] - values[0], values[2] - values[1]
    if not all(math.isfinite(value) for value in values):
        return Estimate("diverges", values[-1], origin=origin)
    if max(abs(coarse), abs(fine)) <= ROUNDING * max(abs(value) for value in values):
        return Estimate("equal", values[-1], value=values[-1], error=resolution, origin=origin)
    if fine == 0:
        return Estimate("stalls", values[-1], origin=origin)
    if coarse * fine < 0:
        return Estimate("oscillates", values[-1], origin=origin)
    order = observed_order(cells, values)
    if order is None:
        return Estimate("diverges", values[-1], origin=origin)
    away, safety = distance(cells, values, order), safety_factor(order)
    return Estimate("converges", values[-1], order, values[-1] + away, safety, safety * abs(away) + resolution, origin)
