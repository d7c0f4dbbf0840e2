"""What a calibration fits: values of quantities, an outline, or a map, each with the error to which it is known."""
import dataclasses
import pathlib
from typing import Any, List, Mapping, Optional

import numpy

from .errors import Error
from .grids import Grid, read_grid
from .map_values import named_map, one_grid
from .overlap import Overlap, Seen, read_seen
from .quantity import Quantity, parse_quantities
from .results import Run

KINDS = {"quantity": ("value",), "outline": (), "map": ("file",)}


@dataclasses.dataclass(frozen=True)
class Target:
    """name; error (one standard deviation); of a quantity the value seen, of an outline and of a map their files' contents.

    Compared are: the quantity's value with `value`; 1 - overlap of the outlines with 0; the root mean square of the map's differences, over the
    cells with a value in one of the two, with 0.
    """

    name: str
    error: float
    quantity: Optional[Quantity] = None
    value: float = 0.0
    seen: Optional[Seen] = None
    map_name: str = ""
    grid: Optional[Grid] = None

    def read(self, run: Run, end: float, cell: float) -> float:
        """What a run has there."""
        if self.quantity is not None:
            return self.quantity.read(run, end, cell)
        if self.seen is not None:
            return 1 - Overlap(run, self.seen).share
        assert self.grid is not None
        ours, seen = (numpy.nan_to_num(values) for values in one_grid((named_map(run, self.map_name), self.grid)))
        there = (ours != 0) | (seen != 0)
        return float(numpy.sqrt(((ours - seen)[there] ** 2).mean())) if there.any() else 0.0

    def check(self, run: Run, scene: Mapping[str, Any]) -> None:
        """Raises Error where the scene has it not, by a run of no steps."""
        if self.quantity is not None:
            self.quantity.check(run, scene)
        else:
            self.read(run, 0.0, 1.0)


def parse_target(given: Mapping[str, Any], number: int, folder: pathlib.Path) -> Target:
    """A [[target]] of a file. Raises Error."""
    kinds = [kind for kind in KINDS if kind in given]
    where = f"target {number}"
    if len(kinds) != 1:
        raise Error(f"{where} names {' and '.join(kinds) or 'nothing'} (it is of one of quantity, outline and map). Is it quantity = \"front\"?")
    kind = kinds[0]
    for name in given:
        if name not in (kind, "error", *KINDS[kind]):
            raise Error(f"{where}, {kind}: {name} is not known (it may have error{''.join(f', {key}' for key in KINDS[kind])}). Remove it?")
    error = given.get("error")
    if not isinstance(error, (int, float)) or isinstance(error, bool) or not error > 0:
        raise Error(f"{where}, {kind} has no error above 0 (to how much it is known, one standard deviation). Add error = ...?")
    for name in KINDS[kind]:
        if name not in given:
            raise Error(f"{where}, {kind} has no {name} (what was seen). Add {name} = ...?")
    if kind == "quantity":
        value = given["value"]
        if not isinstance(value, (int, float)) or isinstance(value, bool):
            raise Error(f"{where}: value = {value} (a number is needed). Correct it?")
        found = parse_quantities(str(given["quantity"]))
        if len(found) != 1:
            raise Error(f"{where}: {given['quantity']} is {len(found)} values (one is needed). Is it {found[0].name}?")
        return Target(found[0].text, float(error), found[0], float(value))
    if kind == "outline":
        return Target("outline", float(error), seen=read_seen(folder / str(given["outline"])))
    return Target(f"map {given['map']}", float(error), map_name=str(given["map"]), grid=read_grid(folder / str(given["file"])))


def parse_targets(given: Any, folder: pathlib.Path) -> List[Target]:
    """All [[target]] of a file. Raises Error."""
    if not isinstance(given, list) or not given or not all(isinstance(item, Mapping) for item in given):
        raise Error("the file has no [[target]] (what was seen is needed). Add one with quantity, value and error?")
    found = [parse_target(item, k + 1, folder) for k, item in enumerate(given)]
    if len({target.name for target in found}) < len(found):
        raise Error("two targets are of one thing (each counts once). Remove one?")
    return found
