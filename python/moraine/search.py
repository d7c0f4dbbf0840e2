"""The rounds of a calibration: first an even design, then where the surfaces through the values of runs say that it may be."""
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence

import numpy
from numpy.typing import NDArray

from .calibration_data import Calibration
from .errors import Error
from .fleet import Fleet, Member, Orders
from .parameters import sets_of
from .posterior import Surfaces, sample
from .results import Run
from .sampling import unit_points
from .scenario_file import save_json, whole_number
from .scene import read_scene, with_sets

FILE = "calibration.json"
NEAR = 0.01  # of the range: a new run is further than that from those that are there


class Search:
    """The rounds of a calibration."""

    def __init__(self, found: Calibration, orders: Orders, identity: str, known: Mapping[str, Any], jobs: int, budget_s: Optional[float],
                 told: Callable[[str], None]) -> None:
        self.found, self.orders, self.identity, self.told, self.jobs = found, orders, identity, told, jobs
        search = found.file.given.get("search", {})
        dimensions = len(found.file.parameters)
        self.seed = whole_number(search, "seed", 1, 0)
        self.first = whole_number(search, "first", max(8, 4 * dimensions), dimensions + 3)
        self.runs = whole_number(search, "runs", 2 * self.first, self.first)
        self.round = whole_number(search, "round", 4, 1)  # not by the cores: one answer on all machines
        self.fleet = Fleet(found.path, orders, jobs, told, budget_s)
        scene = with_sets(read_scene(found.file.scene), found.file.sets)
        self.end, self.cell = float(scene["time"]["end"]), float(scene["domain"]["cell"])
        for name, before in known.get("runs", {}).items():
            self._add(name, before["point"], before.get("code"), before.get("wall_s", 0.0), before.get("problem", ""))

    def _add(self, name: str, point: Sequence[float], code: Optional[int] = None, wall_s: float = 0.0, problem: str = "") -> None:
        self.found.members.append(Member(name, sets_of(self.found.file.parameters, point), code, problem, wall_s))
        self.found.points[name] = list(point)

    def save(self) -> None:
        found = self.found
        runs = {m.name: {"point": found.points[m.name], "sets": m.sets, "code": m.code, "problem": m.problem, "wall_s": m.wall_s, "values": found.values.get(m.name)}
                for m in found.members}
        said: Dict[str, Any] = {}
        if found.posterior is not None:
            said = {p.key: {"median": found.interval(k)[1], "interval_90": [found.interval(k)[0], found.interval(k)[2]], "width_of_prior": found.width(k)}
                    for k, p in enumerate(found.file.parameters)}
        save_json(found.path / FILE, {"identity": self.identity, "scene": str(found.file.scene), "targets": [t.name for t in found.targets], "runs": runs, "posterior": said,
                                      "surface_errors": found.surface_errors})

    def ended(self, member: Member) -> None:
        if member.code == 0:
            done = Run(self.found.path / member.name)
            self.found.values[member.name] = [target.read(done, self.end, self.cell) for target in self.found.targets]
        self.save()

    def search(self) -> None:
        found = self.found
        design = unit_points(len(found.file.parameters), "sobol", self.first, self.seed)
        for k in range(len(found.members), self.first):
            self._add(f"run-{k + 1:03d}", design[k])
        self.save()
        self.fleet.run(found.members, self.ended)
        while not self.fleet.stopped_by_budget and len(found.members) < self.runs:
            self.fit()
            for point in self.next_points(min(self.round, self.runs - len(found.members))):
                self._add(f"run-{len(found.members) + 1:03d}", point)
            self.save()
            self.fleet.run([m for m in found.members if m.name not in found.values], self.ended)
        found.stopped_by_budget = self.fleet.stopped_by_budget
        self.fit()
        self.save()

    def fit(self) -> None:
        """The posterior of the runs that are there."""
        found = self.found
        points = numpy.array([found.points[m.name] for m in found.finished])
        if len(points) < len(found.file.parameters) + 3:
            raise Error(f"{len(points)} runs ended ({len(found.failed)} failed: too few to fit). Look at {found.path / FILE}?")
        surfaces = Surfaces(points, numpy.array([found.values[m.name] for m in found.finished]))
        found.surface_errors = [float(x) for x in surfaces.errors]
        found.posterior = sample(surfaces, [t.value for t in found.targets], [t.error for t in found.targets], self.seed)

    def next_points(self, count: int) -> List[List[float]]:
        """The most likely point, and others of the posterior that are furthest from all runs."""
        posterior = self.found.posterior
        assert posterior is not None
        there = [numpy.array(point) for point in self.found.points.values()]
        state = numpy.random.RandomState(self.seed + len(there))
        chosen: List[NDArray[Any]] = []
        if min(numpy.abs(posterior.best - point).max() for point in there) > NEAR:
            chosen.append(posterior.best)
        while len(chosen) < count:
            some = posterior.samples[state.randint(0, len(posterior.samples), 64)]
            away = [min(float(numpy.abs(one - point).max()) for point in [*there, *chosen]) for one in some]
            chosen.append(some[int(numpy.argmax(away))])
        return [[float(f"{x:.12g}") for x in point] for point in chosen]
