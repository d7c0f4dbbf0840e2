"""A study of scenarios: its runs and their values, and its tables."""
import csv
import dataclasses
import pathlib
from typing import Any, Dict, List, Optional

import numpy
from numpy.typing import NDArray

from .fleet import Member
from .parameters import Parameter
from .quantity import Quantity
from .scenario_file import ScenarioFile
from .sensitivity import Influence
from .study import Study


@dataclasses.dataclass
class Scenarios:
    """A study: its file, its folder, a Member of each run, and values (runs, quantities), NaN where a run failed or is not there."""

    file: ScenarioFile
    path: pathlib.Path
    members: List[Member]
    values: Dict[str, Dict[str, float]] = dataclasses.field(default_factory=dict)  # by run and quantity
    influences: List[Influence] = dataclasses.field(default_factory=list)
    cells: Optional[Study] = None
    maps: List[Dict[str, Any]] = dataclasses.field(default_factory=list)
    stopped_by_budget: bool = False

    @property
    def finished(self) -> List[Member]:
        return [member for member in self.members if member.name in self.values]

    @property
    def failed(self) -> List[Member]:
        return [member for member in self.members if member.code not in (None, 0, 5)]

    def column(self, quantity: Quantity) -> NDArray[Any]:
        """Its values of the runs that ended (runs,)."""
        return numpy.array([self.values[member.name][quantity.text] for member in self.finished])

    def inputs(self, parameter: Parameter) -> List[Any]:
        return [member.sets[parameter.key] for member in self.finished]

    def cell_error(self, quantity: Quantity) -> Optional[float]:
        """Error bar of the cells in the middle of the parameters; None where it is not asked for, or none is seen."""
        return self.cells.variants[0].estimate(quantity).error if self.cells and self.cells.variants[0].levels else None


def write_tables(found: Scenarios) -> None:
    """study.csv, a row per run, and sensitivity.csv, a row per quantity and parameter."""
    keys, names = [p.key for p in found.file.parameters], [q.text for q in found.file.quantities]
    with open(found.path / "study.csv", "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["run", *keys, *names, "exit_code", "wall_s"])
        for m in found.members:
            values = found.values.get(m.name, {})
            rows.writerow([m.name, *(m.sets[key] for key in keys), *(values.get(name, "") for name in names), "" if m.code is None else m.code, f"{m.wall_s:.3f}"])
    with open(found.path / "sensitivity.csv", "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["quantity", "parameter", "measure", "value", "error"])
        for each in found.influences:
            rows.writerow([each.quantity, each.parameter, each.measure, each.value, "" if each.error is None else each.error])
