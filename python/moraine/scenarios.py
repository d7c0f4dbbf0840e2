"""`moraine.run_study`: one scene with many values of its parameters, and what that does to quantities and maps."""
import dataclasses
import pathlib
import shutil
import tempfile
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Union

from .convergence import converge, parse_budget
from .errors import Error
from .fleet import Fleet, Member, Orders, jobs_of
from .parameters import sets_of
from .program import check, run, words_of_check
from .results import Run
from .sampling import METHODS, design, shares_of
from .scenario_data import Scenarios, write_tables
from .scenario_file import RUN, ScenarioFile, fields_of, require_runs, open_folder, read_file, save_json, whole_number
from .scenario_maps import map_statistics
from .scene import Path, read_scene, with_sets
from .sensitivity import influences

FILE = "study.json"
SECTIONS = {"sampling": ("method", "runs", "seed"), "cells": ("levels", "coarsest", "ratio")}


def _method(file: ScenarioFile) -> Dict[str, Any]:
    sampling = file.given.get("sampling", {})
    method = sampling.get("method", "sobol")
    if method not in METHODS:
        raise Error(f"sampling.method = {method} (it is none of {', '.join(METHODS)}). Is it sobol?")
    return {"method": method, "runs": whole_number(sampling, "runs", 16, 2), "seed": whole_number(sampling, "seed", 1, 0)}


def exceedances(file: ScenarioFile) -> Dict[str, List[float]]:
    """Of each map the values whose probability is asked for. Raises Error."""
    found = {}
    for name, levels in (file.given.get("exceed") or {}).items():
        levels = levels if isinstance(levels, list) else [levels]
        if not all(isinstance(x, (int, float)) and not isinstance(x, bool) for x in levels):
            raise Error(f"exceed.{name} = {levels} (numbers in the unit of the map). Is it [0.5, 1.0]?")
        found[name] = [float(x) for x in levels]
    return found


def _refuse(file: ScenarioFile, members: Sequence[Member], orders: Orders) -> None:
    """The scene, all values and all quantities are looked at before anything is computed."""
    ends = [members[0], members[-1]] + [min(members, key=lambda m: str(m.sets.get(p.key))) for p in file.parameters]
    for member in {m.name: m for m in ends}.values():
        check(file.scene, {**orders.sets, **member.sets}, orders.program, orders.ranks or 1, words_of_check(orders.options))
    scene = with_sets(read_scene(file.scene), file.sets)
    with tempfile.TemporaryDirectory(prefix="moraine-") as folder:
        tried = run(file.scene, pathlib.Path(folder) / "start", {**orders.sets, **members[0].sets, "time.end": 0.0}, options=orders.options, progress=False,
                    program=orders.program)
        for quantity in file.quantities:
            quantity.check(tried, scene)
        there = list(tried.maps)
    for name in exceedances(file):
        if name not in there:
            raise Error(f"exceed.{name} (the maps are {', '.join(there) or 'none'}). Does hazard.maps of the scene name it?")


def run_study(given: Union[Path, Mapping[str, Any]], output: Optional[Path] = None, jobs: Optional[int] = None, ranks: Optional[int] = None,
              threads: int = 1, options: Sequence[str] = (), budget: Union[float, str, None] = None, overwrite: bool = False,
              told: Callable[[str], None] = print, program: Optional[Path] = None) -> Scenarios:
    """Runs the scenarios of a file (or a dict of its keys) into `output` (default: runs/study-NAME), and returns what came of them.

    The keys are in docs/scenarios.md. jobs: runs at a time (default: what the cores allow); budget: wall time [s] or "2h" that no run is begun
    beyond; the same call goes on where it was. Others as in `run`. Raises Error for what cannot be.
    """
    file = read_file(given, ["quantities", "exceed"], SECTIONS)
    if not file.quantities:
        raise Error("the file names no quantities (what is to be known of each run). Add quantities = [\"front\"]?")
    sampling = _method(file)
    points = design(file.parameters, **sampling)
    name = "study" if isinstance(given, Mapping) else pathlib.Path(given).stem
    path = pathlib.Path(output or f"runs/study-{name}")
    identity = file.identity([sampling, [q.text for q in file.quantities if q.fields is not None]])
    known = open_folder(path, FILE, identity, overwrite, require_runs)
    wide = len(str(len(points)))
    members = [Member(f"run-{k + 1:0{wide}d}", point) for k, point in enumerate(points)]
    if not known and path.exists():
        for old in path.iterdir():
            if RUN.fullmatch(old.name) and not old.is_symlink():
                shutil.rmtree(old)
    for member in members:
        before = known.get("runs", {}).get(member.name, {})
        member.code, member.problem, member.wall_s = before.get("code"), before.get("problem", ""), before.get("wall_s", 0.0)
    fields, particles = fields_of(file.quantities, with_sets(read_scene(file.scene), file.sets))
    sets = {**file.sets, **({"output.fields": fields} if particles else {})}
    orders = Orders(file.scene, sets, ranks, threads, [*options, *([] if particles else ["--no-particles"])], program)
    found = Scenarios(file, path, members)
    if not known:
        _refuse(file, members, orders)
    _compute(found, orders, jobs_of(jobs, ranks, threads), parse_budget(budget) if isinstance(budget, str) else budget, identity, told)
    finish(found, sampling, orders, told)
    return found


def _compute(found: Scenarios, orders: Orders, jobs: int, budget_s: Optional[float], identity: str, told: Callable[[str], None]) -> None:
    end, cell = found.file.end, float(with_sets(read_scene(found.file.scene), found.file.sets)["domain"]["cell"])

    def save() -> None:
        runs = {m.name: {"sets": m.sets, "code": m.code, "problem": m.problem, "wall_s": m.wall_s, "values": found.values.get(m.name)} for m in found.members}
        save_json(found.path / FILE, {"identity": identity, "scene": str(found.file.scene), "quantities": [q.text for q in found.file.quantities],
                                      "parameters": [dataclasses.asdict(p) for p in found.file.parameters], "runs": runs})

    def ended(member: Member) -> None:
        if member.code == 0:
            done = Run(found.path / member.name)
            found.values[member.name] = {q.text: q.read(done, end, cell) for q in found.file.quantities}
        save()
    save()
    told(f"{len(found.members)} runs, {jobs} at a time, into {found.path}")
    fleet = Fleet(found.path, orders, jobs, told, budget_s)
    fleet.run(found.members, ended)
    found.stopped_by_budget = fleet.stopped_by_budget


def finish(found: Scenarios, sampling: Mapping[str, Any], orders: Orders, told: Callable[[str], None]) -> None:
    """Cells, indices, maps and tables of the runs that ended."""
    cells = found.file.given.get("cells")
    if cells and len(found.finished) == len(found.members) - len(found.failed):
        middle = sets_of(found.file.parameters, [0.5] * len(found.file.parameters))
        told("the same on other cells, in the middle of the parameters:")
        found.cells = converge(found.file.scene, ",".join(q.text for q in found.file.quantities), found.path / "cells", levels=cells.get("levels"),
                               coarsest=cells.get("coarsest"), ratio=str(cells.get("ratio", "2:3:4")), sets={**found.file.sets, **middle}, ranks=orders.ranks,
                               threads=orders.threads, options=[word for word in orders.options if word != "--no-particles"], told=told, program=orders.program)
    if len(found.finished) > 1:
        shares = None
        if sampling["method"] in ("saltelli", "morris") and len(found.finished) == len(found.members):
            shares = shares_of(found.file.parameters, **sampling)
        found.influences = [each for q in found.file.quantities for each in influences(found.file.parameters, [found.inputs(p) for p in found.file.parameters],
                                                                                       q.text, found.column(q), str(sampling["method"]), shares)]
        found.maps = map_statistics([found.path / member.name for member in found.finished], exceedances(found.file), found.path / "maps")
    write_tables(found)
