"""One number of a run, by a name: of its records, its maps, or its particles; at the end, at a time, or over time."""
import dataclasses
from typing import Any, Dict, List, Mapping, Optional, Tuple

import numpy
from numpy.typing import NDArray

from .errors import Error
from .map_values import MAP_VALUES, map_value
from .record_columns import RECORDS, column_of, names_of
from .records import read_table
from .results import Run
from .runout import OF_PARTICLES, Runout, value_of

OVER_TIME = {"max": numpy.max, "min": numpy.min}
COUNTED = {"front_m": 0.5}  # of a cell: to what a column is known that is counted in cells
#: places, whose errors are shares of the way gone since the start
PLACES = ("front", "front_m", "max_x_m", "centre_x_m", "centre_y_m", "centre_z_m", "max_x", "centre_x", "centre_y", "centre_z")


@dataclasses.dataclass(frozen=True)
class Quantity:
    """`text` as the user wrote it: NAME or NAME@WHEN. NAME: a column of history.csv, structure.NAME.COLUMN, gauges.NAME.COLUMN,
    sections.NAME.COLUMN, maps.NAME.max or .mean, maps.area, front, runout, drop, travel_ratio, travel_angle or depth (runout.py).
    WHEN: end (the default), max, min, mean over time, or a time [s].
    """

    text: str
    name: str
    when: str

    @property
    def kind(self) -> str:
        """structure, gauges, sections, maps, particles or history."""
        first = self.name.split(".")[0]
        return first if first in (*RECORDS, "maps") else "particles" if self.name in OF_PARTICLES else "history"

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
        if self.name == "max_depth":
            raise Error("--quantity max_depth (it is two things). maps.max_depth of the hazard maps, or depth of the columns of particles?")
        if self.kind in RECORDS:
            self._check_record(run, scene)
        elif self.kind == "maps":
            if self.when != "end":
                raise Error(f"--quantity {self.text} (maps are of the whole run). Did you mean {self.name}?")
            map_value(run, self.name)
        elif self.kind == "history":
            column_of(run.history, self.name, "history.csv")

    def _check_record(self, run: Run, scene: Mapping[str, Any]) -> None:
        parts, names = self.name.split("."), names_of(run, scene, self.kind)
        kind = {"structure": "structure", "gauges": "gauge", "sections": "section"}[self.kind]
        column = {"structure": "force_y", "gauges": "depth", "sections": "volume"}[self.kind]
        if len(parts) != 3 or parts[1] not in names:
            said = f"the {kind}s are {', '.join(names)}" if names else f"the scene has no {kind}"
            raise Error(f"--quantity {self.name} is not there ({said}). Did you mean {f'{self.kind}.{names[0]}.{column}' if names else 'front'}?")
        if self.kind == "structure":  # which has no rows yet
            column_of(read_table(run.path / RECORDS[self.kind]), parts[2], RECORDS[self.kind])
        else:
            self._record(run)

    def _record(self, run: Run) -> Tuple[NDArray[Any], NDArray[Any]]:
        _, name, column = self.name.split(".")
        if self.kind == "structure":
            table = run.structures[name]
            return table["time_s"], column_of(table, column, "structures.csv")
        table = run.gauges if self.kind == "gauges" else run.sections
        return table["time_s"], column_of(table, column, RECORDS[self.kind], name + "_")

    def read(self, run: Run, end: float, cell: float) -> float:
        """The value of a run that was to end at `end` [s], with cells of `cell` [m]. Raises Error where the run has it not.

        Rows are of the first step at or past their time, which is another one on each level: values at a time lie on the line
        between the rows around it.
        """
        if self.kind == "maps":
            return map_value(run, self.name)
        times, values = self._series(run, cell)
        if self.when in OVER_TIME:
            return float(OVER_TIME[self.when](values))
        if self.when == "mean":
            length = float(times[-1] - times[0])
            return float(((values[1:] + values[:-1]) / 2 * numpy.diff(times)).sum()) / length if length > 0 else float(values[-1])
        return float(numpy.interp(end if self.when == "end" else float(self.when), times, values))

    def origin(self, run: Run, cell: float) -> float:
        """What its error is a share of the distance from: of a place where it was at the start, else 0."""
        if self.name not in PLACES:
            return 0.0
        if self.kind == "history":
            return float(column_of(run.history, self.name, "history.csv")[0])
        runout = Runout(run, cell)
        return value_of(runout, self.name, run.particles.read(0, self.fields))

    def _series(self, run: Run, cell: float) -> Tuple[NDArray[Any], NDArray[Any]]:
        if self.kind == "particles":
            series, runout = run.particles, Runout(run, cell)
            last = [len(series) - 1] if self.when == "end" else range(len(series))
            return series.times[last], numpy.array([value_of(runout, self.name, series.read(k, self.fields)) for k in last])
        if self.kind == "history":
            return run.history["time_s"], column_of(run.history, self.name, "history.csv")
        return self._record(run)


def parse_quantities(text: str) -> List[Quantity]:
    """Quantities with commas between; maps.NAME stands for the largest value of that map, its mean, and the area that was reached.

    >>> [(q.name, q.when) for q in parse_quantities("front_m,structure.pipe.force_y@max,kinetic_J@1.5")]
    [('front_m', 'end'), ('structure.pipe.force_y', 'max'), ('kinetic_J', '1.5')]
    >>> [q.name for q in parse_quantities("maps.deposit,maps.max_depth.max")]
    ['maps.deposit.max', 'maps.deposit.mean', 'maps.area', 'maps.max_depth.max']
    """
    found: Dict[str, Quantity] = {}
    given = [word.strip() for word in text.split(",") if word.strip()]
    for word in given:
        name, at, when = word.partition("@")
        try:
            known = when in ("end", "max", "min", "mean") or float(when) >= 0
        except ValueError:
            known = not at
        if not name or not known:
            raise Error(f"--quantity {word} (after @ comes end, max, min, mean or a time in s). Did you mean {name or 'front'}@end?")
        parts = name.split(".")
        whole = parts[0] == "maps" and len(parts) == 2 and parts[1] != "area"
        for full in [f"{name}.{value}" for value in MAP_VALUES] + ["maps.area"] if whole else [name]:
            found.setdefault(full + at + when, Quantity(full + at + when, full, when or "end"))
    if not given or len(set(given)) < len(given):
        raise Error(f"--quantity {text} (it names {'one twice' if given else 'nothing'}). Try front?")
    return list(found.values())


def maps_of(quantities: List[Quantity]) -> List[str]:
    """Names of the maps of which largest value and mean are asked for, in order."""
    return list(dict.fromkeys(q.name.split(".")[1] for q in quantities if q.kind == "maps" and q.name != "maps.area"))
