"""A calibration: its runs, its posterior, and its tables."""
import csv
import dataclasses
import pathlib
from typing import Any, Dict, List, Optional

from .fleet import Member
from .posterior import Posterior
from .scenario_file import ScenarioFile
from .targets import Target


@dataclasses.dataclass
class Calibration:
    """A calibration: its runs with their points of the unit cube and values of targets, and the posterior, None before there are enough runs."""

    file: ScenarioFile
    path: pathlib.Path
    targets: List[Target]
    members: List[Member] = dataclasses.field(default_factory=list)
    points: Dict[str, List[float]] = dataclasses.field(default_factory=dict)
    values: Dict[str, List[float]] = dataclasses.field(default_factory=dict)
    posterior: Optional[Posterior] = None
    surface_errors: List[float] = dataclasses.field(default_factory=list)
    stopped_by_budget: bool = False

    @property
    def finished(self) -> List[Member]:
        return [member for member in self.members if member.name in self.values]

    @property
    def failed(self) -> List[Member]:
        return [member for member in self.members if member.code not in (None, 0, 5)]

    def chi2(self, member: Member) -> float:
        """Of a run, by the errors of the targets alone."""
        return sum(((value - target.value) / target.error)**2 for value, target in zip(self.values[member.name], self.targets))

    @property
    def best(self) -> Member:
        """The run that fits best."""
        return min(self.finished, key=self.chi2)

    def interval(self, number: int, percent: float = 90) -> List[Any]:
        """Lower end, median and upper end of the middle `percent` of the posterior of a parameter, as values of its key."""
        assert self.posterior is not None
        parameter = self.file.parameters[number]
        return [parameter.at(self.posterior.quantile(number, share)) for share in (50 - percent / 2, 50, 50 + percent / 2)]

    def width(self, number: int) -> float:
        """Standard deviation of the posterior over that of the prior; near 1: what was seen does not tell the parameter."""
        assert self.posterior is not None
        return float(self.posterior.samples[:, number].std()) / self.file.parameters[number].deviation


def write_tables(found: Calibration) -> None:
    """calibration.csv, a row per run, and posterior.csv, a row per sample."""
    keys = [p.key for p in found.file.parameters]
    with open(found.path / "calibration.csv", "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["run", *keys, *(t.name for t in found.targets), "chi2", "exit_code", "wall_s"])
        for m in found.members:
            values: List[Any] = [*found.values[m.name], found.chi2(m)] if m.name in found.values else [""] * (len(found.targets) + 1)
            rows.writerow([m.name, *(m.sets[key] for key in keys), *values, "" if m.code is None else m.code, f"{m.wall_s:.3f}"])
    assert found.posterior is not None
    with open(found.path / "posterior.csv", "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(keys)
        for point in found.posterior.samples[:: max(1, len(found.posterior.samples) // 2000)]:
            rows.writerow([p.at(float(share)) for p, share in zip(found.file.parameters, point)])
