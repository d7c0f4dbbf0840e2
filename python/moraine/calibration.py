"""`moraine.calibrate`: parameters with which a scene gives what was seen, and how well that tells them.

Runs are made in rounds: first an even design, then where the surfaces through their values say that it may be. The posterior is that of the
last round's surfaces.
"""
import pathlib
import shutil
import tempfile
from typing import Any, Callable, Mapping, Optional, Sequence, Union

import numpy

from .calibration_data import Calibration, write_tables
from .convergence import parse_budget
from .errors import Error
from .fleet import Orders, jobs_of
from .parameters import sets_of
from .posterior import Surfaces
from .program import check, run, words_of_check
from .sampling import unit_points
from .scenario_file import RUN, fields_of, is_number, require_runs, open_folder, read_file
from .scene import Path, read_scene, with_sets
from .search import FILE, Search
from .targets import parse_targets

SECTIONS = {"search": ("first", "runs", "seed", "round")}


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
    seen = [(t.name, t.value, t.error, t.seen.polygons if t.seen else None, t.grid.values.tolist() if t.grid else None) for t in targets]
    identity = file.identity([search, seen])

    def look(known: Mapping[str, Any]) -> None:
        require_runs(known)
        for name, each in known["runs"].items():
            if len(each["point"]) != len(file.parameters) or not all(is_number(x) and 0 <= x <= 1 for x in each["point"]):
                raise ValueError(f"{name} is at no point")
    known = open_folder(path, FILE, identity, overwrite, look)
    if not known and path.exists():
        for old in path.iterdir():
            if RUN.fullmatch(old.name) and not old.is_symlink():
                shutil.rmtree(old)
    quantities = [t.quantity for t in targets if t.quantity is not None]
    fields, particles = fields_of(quantities, with_sets(read_scene(file.scene), file.sets))
    sets = {**file.sets, **({"output.fields": fields} if particles else {})}
    orders = Orders(file.scene, sets, ranks, threads, [*options, *([] if particles else ["--no-particles"])], program)
    found = Calibration(file, path, targets)
    work = Search(found, orders, identity, known, jobs_of(jobs, ranks, threads), parse_budget(budget) if isinstance(budget, str) else budget, told)
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
        check(found.file.scene, {**orders.sets, **sets_of(found.file.parameters, [share] * count)}, orders.program, orders.ranks or 1, words_of_check(orders.options))
    with tempfile.TemporaryDirectory(prefix="moraine-") as folder:
        sets = {**orders.sets, **sets_of(found.file.parameters, [0.5] * count), "time.end": 0.0}
        tried = run(found.file.scene, pathlib.Path(folder) / "start", sets, options=orders.options, progress=False, program=orders.program)
        for target in found.targets:
            target.check(tried, with_sets(read_scene(found.file.scene), found.file.sets))
