"""`moraine.calibrate`: parameters with which a scene gives what was seen, and how well that tells them.

Runs are made in rounds: first an even design, then where the surfaces through their values say that it may be. The posterior is that of the
last round's surfaces.
"""
import csv
import dataclasses
import pathlib
import re
import shutil
import tempfile
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Union

import numpy
from numpy.typing import NDArray

from .convergence import parse_budget
from .errors import Error
from .fleet import Fleet, Member, Orders, jobs_of
from .parameters import sets_of
from .posterior import Posterior, Surfaces, sample
from .program import check, run
from .results import Run
from .sampling import unit_points
from .scenario_file import ScenarioFile, fields_of, open_folder, read_file, save_json, whole_number
from .scene import Path, read_scene, with_sets
from .targets import Target, parse_targets

FILE = "calibration.json"
SECTIONS = {"search": ("first", "runs", "seed", "round")}
RUN = re.compile(r"run-\d+")
NEAR = 0.01  # of the range: a new run is further than that from those that are there


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


class _Search:
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


def calibrate(given: Union[Path, Mapping[str, Any]], output: Optional[Path] = None, jobs: Optional[int] = None, ranks: Optional[int] = None,
              threads: int = 1, options: Sequence[str] = (), budget: Union[float, str, None] = None, overwrite: bool = False,
              told: Callable[[str], None] = print, program: Optional[Path] = None) -> Calibration:
    """Fits the parameters of a file (or a dict of its keys) to its targets; the keys are in docs/scenarios.md, others as in `run_study`."""
    file = read_file(given, ["target"], SECTIONS)
    if any(p.kind == "values" for p in file.parameters):
        raise Error("a parameter has values (a calibration needs ranges between which it can go). Give a range?")
    targets = parse_targets(file.given.get("target"), file.folder)
    name = "scene" if isinstance(given, Mapping) else pathlib.Path(given).stem
    path = pathlib.Path(output or f"runs/calibrate-{name}")
    search = {key: value for key, value in dict(file.given.get("search", {})).items() if key != "runs"}  # more may be asked for later
    seen = [(t.name, t.value, t.error, t.rings, t.grid.values.tolist() if t.grid else None) for t in targets]
    identity = file.identity([search, seen])
    known = open_folder(path, FILE, identity, overwrite)
    if not known and path.exists():
        for old in path.iterdir():
            if RUN.fullmatch(old.name) and not old.is_symlink():
                shutil.rmtree(old)
    quantities = [t.quantity for t in targets if t.quantity is not None]
    fields, particles = fields_of(quantities, with_sets(read_scene(file.scene), file.sets))
    sets = {**file.sets, **({"output.fields": fields} if particles else {})}
    orders = Orders(file.scene, sets, ranks, threads, [*options, *([] if particles else ["--no-particles"])], program)
    found = Calibration(file, path, targets)
    work = _Search(found, orders, identity, known, jobs_of(jobs, ranks, threads), parse_budget(budget) if isinstance(budget, str) else budget, told)
    if not known:
        _refuse(found, orders)
    told(f"{work.runs} runs, of which {work.first} first, {work.jobs} at a time, into {path}")
    work.search()
    write_tables(found)
    return found


def _refuse(found: Calibration, orders: Orders) -> None:
    """The scene at both ends of all parameters, the libraries and all targets, before anything is computed."""
    count = len(found.file.parameters)
    unit_points(count, "sobol", 2, 1)
    Surfaces(numpy.array(unit_points(count, "sobol", count + 4, 1)), numpy.arange(float(count + 4))[:, None])
    for share in (0.0, 1.0):
        check(found.file.scene, {**orders.sets, **sets_of(found.file.parameters, [share] * count)}, orders.program, orders.ranks or 1)
    with tempfile.TemporaryDirectory(prefix="moraine-") as folder:
        sets = {**orders.sets, **sets_of(found.file.parameters, [0.5] * count), "time.end": 0.0}
        tried = run(found.file.scene, pathlib.Path(folder) / "start", sets, options=orders.options, progress=False, program=orders.program)
        for target in found.targets:
            target.check(tried, with_sets(read_scene(found.file.scene), found.file.sets))


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
