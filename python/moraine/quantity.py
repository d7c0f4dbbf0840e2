"""One number of a run, by a name: a column of history.csv, of a structure, or the depth; at the end, at a time, or over time."""
import dataclasses
import difflib
from typing import Any, Callable, Dict, List, Mapping, Optional, Tuple

import numpy
from numpy.typing import NDArray

from .columns import depth_profile
from .errors import Error
from .particles import Particles
from .records import Table, read_table
from .results import Run

BEHIND = 0.995              # of the mass is behind the front
OVER_TIME = {"max": numpy.max, "min": numpy.min}
COUNTED = {"front_m": 0.5}  # of a cell: to what a column is known that is counted in cells
COLUMNS_PER_CELL = 2.0      # width of a column of the depth, in cells


def _column(table: Table, name: str, where: str) -> NDArray[Any]:
    """The column of that name, or of it and a unit."""
    fitting = [column for column in table if column == name or column.startswith(name + "_") and _is_unit(column[len(name) + 1:])]
    if name in table:
        fitting = [name]
    if len(fitting) != 1 or table[fitting[0]].dtype.kind != "f":
        near = difflib.get_close_matches(name, [c for c in table if table[c].dtype.kind == "f"], 1, 0.4)
        raise Error(f"--quantity {name} is not there (no such column in {where}). Did you mean {near[0] if near else 'front'}?")
    return table[fitting[0]]


def _is_unit(text: str) -> bool:
    return text in ("m", "s", "N", "J", "kg", "Pa", "m_s", "N_m", "N_s", "kg_m_s")


def _front(particles: Particles, cell: float) -> float:
    """x [m] behind which 99.5 % of the mass are."""
    order = numpy.argsort(particles.position[:, 0], kind="stable")
    behind = numpy.cumsum(particles["mass"][order].astype(float))
    return float(numpy.interp(BEHIND * behind[-1], behind, particles.position[order, 0])) if len(order) else 0.0


def _depth(particles: Particles, cell: float) -> float:
    return float(max(depth_profile(particles.position, width=COLUMNS_PER_CELL * cell)[1], default=0.0))


#: Front and depth, and the fields that they need.
OF_PARTICLES: Dict[str, Tuple[Callable[[Particles, float], float], List[str]]] = {"front": (_front, ["mass"]), "max_depth": (_depth, [])}


@dataclasses.dataclass(frozen=True)
class Quantity:
    """`text` as the user wrote it: NAME or NAME@WHEN. NAME: a column of history.csv, structure.NAME.COLUMN, front (the x [m] behind
    which 99.5 % of the mass are) or max_depth [m]. WHEN: end (the default), max, min, mean over time, or a time [s].
    """

    text: str
    name: str
    when: str

    @property
    def fields(self) -> Optional[List[str]]:
        """Fields of the particles that it needs; None where it needs no particles."""
        return OF_PARTICLES[self.name][1] if self.name in OF_PARTICLES else None

    def resolution(self, cell: float) -> float:
        """To what the value is known beside the error of the cells, in its unit: half a cell where it is counted in cells."""
        return COUNTED.get(self.name, 0.0) * cell

    def check(self, run: Run, scene: Mapping[str, Any]) -> None:
        """Raises Error where the scene has it not, by a run of no steps."""
        end = float(scene.get("time", {}).get("end", 0.0))
        if self.when[0].isdigit() and float(self.when) > end:
            raise Error(f"--quantity {self.text} (the scene ends at {end:g} s). A time before?")
        parts = self.name.split(".")
        if parts[0] == "structure":
            names = [item.get("name", "") for item in scene.get("structure", [])]
            if len(parts) != 3 or parts[1] not in names:
                raise Error(f"--quantity {self.name} is not there ({'the structures are ' + ', '.join(names) if names else 'the scene has no structure'}). "
                            f"Did you mean {f'structure.{names[0]}.force_y' if names else 'front'}?")
            _column(read_table(run.path / "structures.csv"), parts[2], "structures.csv")
        elif self.name not in OF_PARTICLES:
            _column(run.history, self.name, "history.csv")

    def read(self, run: Run, end: float, cell: float) -> float:
        """The value of a run that was to end at `end` [s], with cells of `cell` [m]. Raises Error where the run has it not.

        Rows are of the first step at or past their time, which is another one on each level: values at a time lie on the line
        between the rows around it.
        """
        times, values = self._series(run, cell)
        if self.when in OVER_TIME:
            return float(OVER_TIME[self.when](values))
        if self.when == "mean":
            length = float(times[-1] - times[0])
            return float(((values[1:] + values[:-1]) / 2 * numpy.diff(times)).sum()) / length if length > 0 else float(values[-1])
        return float(numpy.interp(end if self.when == "end" else float(self.when), times, values))

    def _series(self, run: Run, cell: float) -> Tuple[NDArray[Any], NDArray[Any]]:
        if self.name in OF_PARTICLES:
            of, fields = OF_PARTICLES[self.name]
            series = run.particles
            last = [len(series) - 1] if self.when == "end" else range(len(series))
            return series.times[last], numpy.array([of(series.read(k, fields), cell) for k in last])
        parts = self.name.split(".")
        if parts[0] != "structure":
            return run.history["time_s"], _column(run.history, self.name, "history.csv")
        table = run.structures[parts[1]]
        return table["time_s"], _column(table, parts[2], "structures.csv")


def parse_quantities(text: str) -> List[Quantity]:
    """Quantities with commas between.

    >>> [(q.name, q.when) for q in parse_quantities("front_m,structure.pipe.force_y@max,kinetic_J@1.5")]
    [('front_m', 'end'), ('structure.pipe.force_y', 'max'), ('kinetic_J', '1.5')]
    """
    found = []
    for word in filter(None, (word.strip() for word in text.split(","))):
        name, at, when = word.partition("@")
        try:
            known = when in ("end", "max", "min", "mean") or float(when) >= 0
        except ValueError:
            known = not at
        if not name or not known:
            raise Error(f"--quantity {word} (after @ comes end, max, min, mean or a time in s). Did you mean {name or 'front'}@end?")
        found.append(Quantity(word, name, when or "end"))
    if not found or len({q.text for q in found}) < len(found):
        raise Error(f"--quantity {text} (it names {'nothing' if not found else 'one twice'}). Try front?")
    return found
