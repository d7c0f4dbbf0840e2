"""Levels of a refinement study: cells in a ratio, and what else of the scene follows them. Walls, bodies and structures stay."""
import dataclasses
import math
from typing import Any, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple

from .errors import Error

CLOSED = ("no-slip", "free-slip", "friction", "undrained", "voellmy")  # kinds of walls that stay where they are
WHOLE = 1e-9    # of a number of cells, as moraine check has it
NEAR = 1.13     # a cell that fits may be so many times larger or smaller than the wanted one
FEW_CELLS = 4   # over the least side of a body


def parse_ratio(text: str) -> List[int]:
    """Rising whole numbers of cells over one length.

    >>> parse_ratio("2:3:4")
    [2, 3, 4]
    """
    try:
        ratio = [int(word) for word in text.split(":")]
    except ValueError:
        ratio = []
    if len(ratio) < 2 or ratio[0] < 1 or any(b <= a for a, b in zip(ratio, ratio[1:])):
        raise Error(f"--ratio {text} (it must be rising whole numbers). Try 2:3:4, or 1:2 for halving?")
    return ratio


def cell_sizes(ratio: Sequence[int], coarsest: float) -> Iterator[float]:
    """Cells [m] from the coarsest on; where the ratio ends it begins again, 2:3:4 is followed by 6:8:12.

    >>> from itertools import islice
    >>> [round(12 / h) for h in islice(cell_sizes([2, 3, 4], 6.0), 6)]
    [2, 3, 4, 6, 8, 12]
    """
    cell = coarsest
    yield cell
    while True:
        for before, after in zip(ratio, ratio[1:]):
            cell *= before / after
            yield cell


def coarsest_of(ratio: Sequence[int], cell: float) -> float:
    """The coarsest cell of a study whose third level has the scene's cell.

    >>> coarsest_of([2, 3, 4], 0.1), coarsest_of([1, 2], 0.1)
    (0.2, 0.4)
    """
    sizes = cell_sizes(ratio, 1.0)
    return float(f"{cell / [next(sizes) for _ in range(3)][2]:.12g}")


@dataclasses.dataclass(frozen=True)
class Level:
    """One level: its cell [m], the keys of the scene that it changes, and what of the scene does not fit it."""

    cell: float
    sets: Dict[str, Any]
    remarks: Tuple[str, ...]


def _is_whole(cells: float) -> bool:
    return abs(cells - round(cells)) <= WHOLE * max(1.0, abs(cells))


def _fixed_ends(scene: Mapping[str, Any], axis: int) -> Tuple[bool, bool]:
    """Whether the domain's lower and upper end of an axis must stay where they are."""
    if "xyz"[axis] in scene["domain"].get("periodic", []):
        return True, True
    kinds = {wall["face"]: wall["kind"] for wall in scene.get("wall", [])}
    low, high = (kinds.get(f"{'xyz'[axis]}-{end}") in CLOSED for end in ("min", "max"))
    return low, high


def _fitting_cell(wanted: float, lengths: Sequence[float]) -> Optional[float]:
    """The cell next to the wanted one that divides all lengths; None if there is none near."""
    if not lengths:
        return wanted
    found: List[float] = []
    for count in range(math.ceil(lengths[0] / (NEAR * wanted)), math.floor(NEAR * lengths[0] / wanted) + 1):
        cell = lengths[0] / max(count, 1)
        if count > 0 and all(_is_whole(length / cell) for length in lengths):
            found.append(cell)
    return min(found, key=lambda near: abs(math.log(near / wanted))) if found else None


def _bodies_that_do_not_fit(scene: Mapping[str, Any], low: Sequence[float], cell: float) -> Iterator[str]:
    for what in ("body", "structure"):
        for item in scene.get(what, []):
            if item.get("shape") != "box":
                continue
            sides = [(upper - lower) / cell for lower, upper in zip(item["min"], item["max"])]
            off = [f"{'xyz'[a]} = {at:g} m" for end in ("min", "max") for a, at in enumerate(item[end]) if not _is_whole((at - low[a]) / cell)]
            if off:
                yield f"{what}.{item.get('name', '')} ends between nodes at {', '.join(off)}"
            if what == "body" and min(sides) < FEW_CELLS * (1 - WHOLE):
                yield f"{what}.{item.get('name', '')} is {min(sides):.3g} cells over its least side (fewer than {FEW_CELLS})"


def fit(scene: Mapping[str, Any], wanted: float) -> Level:
    """The level of a scene (a dict) with a cell of about the wanted size [m].

    Closed walls and periodic axes stay where they are, so the cell is the nearest that divides what is between them. Where an axis
    has an open end, that end moves outwards to the next node. A fixed step follows the cell.

    >>> found = fit({"dimensions": 2, "domain": {"min": [0, 0], "max": [4, 1], "cell": 0.25}}, 0.3)
    >>> found.sets["domain.max"], found.remarks[0]
    ([4.2, 1.2], 'domain.max moves to [4.2, 1.2] m, a whole number of cells')
    """
    domain, dimensions = scene["domain"], scene["dimensions"]
    if "min" not in domain:  # over terrain: the program lays it, in whole cells
        sets: Dict[str, Any] = {"domain.cell": wanted}
        if "dt" in scene.get("time", {}):
            sets["time.dt"] = scene["time"]["dt"] * wanted / domain["cell"]
        return Level(wanted, sets, ())
    low, high = list(map(float, domain["min"])), list(map(float, domain["max"]))
    ends = [_fixed_ends(scene, axis) for axis in range(dimensions)]
    periodic = [4 if "xyz"[axis] in domain.get("periodic", []) else 1 for axis in range(dimensions)]
    fixed = [(high[a] - low[a]) / periodic[a] for a in range(dimensions) if all(ends[a])]
    cell = _fitting_cell(wanted, fixed)
    if cell is None:
        raise Error(f"no cell near {wanted:.6g} m fits the domain (between closed walls there must be whole cells, on a periodic axis "
                    f"whole blocks of 4). Try --ratio 1:2 --coarsest {domain['cell']:g}?")
    remarks: List[str] = [] if abs(cell - wanted) <= WHOLE * wanted else [f"the cell is {cell:.6g} instead of {wanted:.6g} m: that fits between the walls"]
    sets = {"domain.cell": cell}
    for a in range(dimensions):
        count = (high[a] - low[a]) / cell
        if _is_whole(count):
            continue
        place, end = (low, "min") if ends[a][1] else (high, "max")
        place[a] = float(f"{(high[a] - math.ceil(count) * cell if end == 'min' else low[a] + math.ceil(count) * cell):.15g}")
        sets[f"domain.{end}"] = place
    remarks += [f"domain.{end} moves to [{', '.join(f'{x:g}' for x in sets[f'domain.{end}'])}] m, a whole number of cells"
                for end in ("min", "max") if f"domain.{end}" in sets]
    if "dt" in scene.get("time", {}):
        sets["time.dt"] = scene["time"]["dt"] * cell / domain["cell"]
        remarks.append(f"the fixed step follows: time.dt = {sets['time.dt']:.6g} s")
    return Level(cell, sets, tuple(remarks + list(_bodies_that_do_not_fit(scene, low, cell))))


def refuse_tables(scene: Mapping[str, Any]) -> None:
    """Raises Error for bodies whose particles are given one by one, which no cell changes."""
    for body in scene.get("body", []):
        if body.get("shape") == "table":
            raise Error(f"body.{body.get('name', '')} is a table of particles (they do not follow the cells). Study a scene of boxes, polygons or spheres?")
