"""How much a quantity depends on each parameter: Sobol's indices or Morris' effects by SALib, where the design is theirs, else rank correlations."""
import dataclasses
import warnings
from typing import Any, List, Optional, Sequence

import numpy
from numpy.typing import NDArray

from .parameters import Parameter
from .sampling import LEVELS, cube_of, salib

SEED = 1  # of the bootstrap behind the errors


@dataclasses.dataclass(frozen=True)
class Influence:
    """measure: "first-order" and "total" (Sobol: shares of the variance), "effect" (Morris: mean size of elementary effects, in the unit of
    the quantity over the whole range), or "rank correlation" (Spearman, -1 to 1). error: half a 95 % interval, where the library gives one.
    """

    quantity: str
    parameter: str
    measure: str
    value: float
    error: Optional[float] = None


def ranks(values: NDArray[Any]) -> NDArray[Any]:
    """From 0 on, ties their mean.

    >>> ranks(numpy.array([3.0, 1.0, 3.0, 2.0])).tolist()
    [2.5, 0.0, 2.5, 1.0]
    """
    _, inverse, counts = numpy.unique(values, return_inverse=True, return_counts=True)
    last = numpy.cumsum(counts)
    found: NDArray[Any] = (last - (counts + 1) / 2)[inverse]
    return found


def correlation(x: NDArray[Any], y: NDArray[Any]) -> float:
    """Spearman's; 0 where one does not vary.

    >>> correlation(numpy.array([1.0, 2.0, 5.0]), numpy.array([9.0, 4.0, 1.0]))
    -1.0
    """
    a, b = (ranks(values) - (len(values) - 1) / 2 for values in (x, y))
    size = float(numpy.sqrt((a**2).sum() * (b**2).sum()))
    return round(float((a * b).sum()) / size, 12) if size else 0.0


def _numbers(values: Sequence[Any]) -> NDArray[Any]:
    """Of words their places in the list."""
    try:
        return numpy.array(values, dtype=float)
    except (ValueError, TypeError):
        names = list(dict.fromkeys(map(str, values)))
        return numpy.array([names.index(str(value)) for value in values], dtype=float)


def influences(parameters: Sequence[Parameter], inputs: Sequence[Sequence[Any]], quantity: str, values: NDArray[Any], method: str,
               shares: Optional[Sequence[Sequence[float]]]) -> List[Influence]:
    """Of one quantity. shares: the points of the design where all its runs ended, which indices and effects need."""
    if shares is None:
        return [Influence(quantity, p.key, "rank correlation", correlation(_numbers(column), values)) for p, column in zip(parameters, inputs)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a quantity that does not vary
        if method == "saltelli":
            found = salib().analyze.sobol.analyze(cube_of(parameters), values, calc_second_order=False, seed=SEED)
            kinds = [("first-order", "S1"), ("total", "ST")]
        else:
            found = salib().analyze.morris.analyze(cube_of(parameters), numpy.array(shares), values, num_levels=LEVELS, seed=SEED)
            kinds = [("effect", "mu_star")]
    return [Influence(quantity, p.key, measure, float(found[name][k]), float(found[name + "_conf"][k]))
            for measure, name in kinds for k, p in enumerate(parameters)]
