"""Which factors to try next: the bracket [stands, fails] on a lattice of factors, by galloping and then by halving.

Factors are whole multiples k of the tolerance, so that the bracket that is found does not depend on how many trials run at a time.
"""
from typing import List, Mapping, Optional, Tuple

from .verdict import FAILS, STANDS

MOST = 20.0    # a factor of safety beyond has no meaning


def bracket(found: Mapping[int, str]) -> Tuple[Optional[int], Optional[int]]:
    """The highest that stands below all that fail, and the lowest that fails.

    >>> bracket({100: "stands", 120: "undecided", 130: "fails", 160: "fails", 140: "stands"})
    (100, 130)
    """
    fails = min((k for k, verdict in found.items() if verdict == FAILS), default=None)
    stands = max((k for k, verdict in found.items() if verdict == STANDS and (fails is None or k < fails)), default=None)
    return stands, fails


def is_uneven(found: Mapping[int, str]) -> bool:
    """Whether a factor stands above one that fails: the bracket is that below."""
    _, fails = bracket(found)
    return fails is not None and any(verdict == STANDS and k > fails for k, verdict in found.items())


def _between(low: int, high: int, count: int) -> List[int]:
    """Up to `count` factors that divide what is between.

    >>> _between(100, 120, 1), _between(100, 103, 2), _between(100, 101, 2)
    ([110], [101, 102], [])
    """
    inside = high - low - 1
    return sorted({low + (high - low) * (j + 1) // (count + 1) for j in range(count)} - {low, high}) if inside > 0 else []


def _gallop(first: int, last: int, step: int, count: int) -> List[int]:
    """Factors beyond the last one that was tried, each twice as far from the first as the one before, and a step.

    >>> _gallop(100, 100, 20, 2), _gallop(100, 120, 20, 1), _gallop(100, 98, -2, 2)
    ([120, 160], [160], [94, 86])
    """
    found = []
    for _ in range(count):
        last = first + 2 * (last - first) + step
        found.append(last)
    return found


def next_factors(found: Mapping[int, str], first: int, step: int, count: int) -> List[int]:
    """Up to `count` factors to try, none where the bracket is known; `first` is tried first, others are `step` and more away from it.

    >>> next_factors({}, 100, 20, 2), next_factors({100: "stands"}, 100, 20, 2), next_factors({100: "stands", 120: "fails"}, 100, 20, 1)
    ([100, 120], [120, 160], [110])
    >>> next_factors({100: "fails"}, 100, 2, 1), next_factors({100: "stands", 101: "undecided", 104: "fails"}, 100, 2, 2)
    ([98], [102])
    """
    stands, fails = bracket(found)
    if first not in found and (fails is None or first < fails):
        return [k for k in [first, *_gallop(first, first, step, count - 1)] if k not in found]
    if fails is None:
        return _gallop(first, max(found), step, count)
    if stands is None:
        return list(dict.fromkeys(max(1, k) for k in _gallop(first, min(found), -step, count) if max(1, k) not in found))
    doubtful = [k for k in found if stands < k < fails]  # neither
    if not doubtful:
        return _between(stands, fails, count)
    return (_between(stands, min(doubtful), 1) + _between(max(doubtful), fails, 1))[:count]


def factor_of(k: int, tolerance: float) -> float:
    """
    >>> factor_of(137, 0.01)
    1.37
    """
    return float(f"{k * tolerance:.10g}")
