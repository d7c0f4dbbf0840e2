"""`moraine.stability`: the factor of safety of a slope by reduction of its strengths, on a cell and on half of it."""
import dataclasses
import hashlib
import json
import math
import pathlib
import re
from typing import Any, Callable, Dict, Mapping, Optional, Sequence

from .errors import Error
from .factor_search import bracket, factor_of, is_uneven
from .fleet import Orders, jobs_of
from .levels import fit
from .scenario_file import is_number, open_folder, save_json
from .scene import Path, Scene, as_file, read_scene, with_sets
from .slope_job import trial_of
from .slope_level import SlopeLevel
from .slope_result import FactorOfSafety, SlopeResult, as_json
from .slope_trials import SlopeTrials
from .slope_wanted import Wanted, refuse, remarks_of
from .strengths import strengths_of
from .verdict import WAY

FILE = "stability.json"
FIRST, NARROW = 0.2, 0.02  # steps of the search on the first cell and on the second, in F
CELL = re.compile(r"cell-[0-9.e+-]+")


class _Record:
    """stability.json: what is known from call to call."""

    def __init__(self, path: pathlib.Path, identity: str, tolerance: float, overwrite: bool) -> None:
        self.path, self.identity = path, identity

        def look(known: Mapping[str, Any]) -> None:
            for level in known["levels"].values():
                if level["height"] is not None and not (is_number(level["height"]) and 0 < level["height"] < math.inf):
                    raise ValueError(f"no slope is {level['height']} m high")
                for key, trial in level["trials"].items():
                    trial_of(key, trial, tolerance)
        self.known = open_folder(path, FILE, identity, overwrite, look) or {"levels": {}}
        if overwrite and path.is_dir():
            for old in path.iterdir():
                if CELL.fullmatch(old.name):
                    SlopeLevel.drop(old)

    def level(self, name: str) -> Dict[str, Any]:
        found: Dict[str, Any] = self.known["levels"].setdefault(name, {"height": None, "trials": {}})
        return found

    def save(self, more: Mapping[str, Any]) -> None:
        self.known.update({"identity": self.identity, **more})
        save_json(self.path / FILE, self.known)


def _search(record: _Record, level: SlopeLevel, wanted: Wanted, jobs: int, near: Optional[SlopeResult], told: Callable[[str], None]) -> SlopeResult:
    """The bracket on one cell; near: that of the cell before."""
    name = level.folder.name
    known = record.level(name)
    level.height = wanted.height or known["height"]
    rule = level.prepare()
    known["height"] = level.height

    def save() -> None:
        known["trials"] = {str(k): dataclasses.asdict(trial) for k, trial in trials.trials.items()}
        record.save({})
    trials = SlopeTrials(level, wanted.tolerance, jobs, told, save)
    trials.trials = {int(k): trial_of(k, trial, wanted.tolerance) for k, trial in known["trials"].items()}
    save()
    settled = trials.settle()
    told(f"cell {level.level.cell:.6g} m: settled at F = {wanted.settle:g} after {settled.time:.3g} s, way {settled.way:.3g} m of a height of {rule.height:.4g} m")
    base = max(1, round(wanted.settle / wanted.tolerance))
    if near is None:
        trials.search(base, max(1, round(FIRST / wanted.tolerance)), base)
    else:
        trials.search(round(near.stands / wanted.tolerance), max(1, round(NARROW / wanted.tolerance)))
    stands, fails = bracket(trials.verdicts)
    if stands is None or fails is None:
        raise Error(f"the slope stands at no factor, down to {wanted.tolerance:g} (it slides whatever its strength). Is its base or a wall missing?", 3)
    remarks = list(level.level.remarks)
    if settled.way > 0.05 * rule.height:
        remarks.append(f"it had moved {settled.way:.3g} m when it had settled (more than 0.05 of its height): begin with its stress (geostatic), or a higher young")
    return SlopeResult(level.level.cell, factor_of(stands, wanted.tolerance), factor_of(fails, wanted.tolerance), rule.height, settled.way,
                       settled.particles, is_uneven(trials.verdicts), remarks, [trials.trials[k] for k in sorted(trials.trials)], name)


def _identity(scene: Mapping[str, Any], wanted: Wanted) -> str:
    asked = [wanted.tolerance, wanted.settle, wanted.height, wanted.way, sorted(wanted.keep), wanted.softening]
    return hashlib.sha256(json.dumps([scene, asked], sort_keys=True, default=str).encode()).hexdigest()[:16]


def stability(scene: Scene, output: Optional[Path] = None, tolerance: float = 0.01, cell: Optional[float] = None, levels: int = 2, settle: float = 1.0,
              height: Optional[float] = None, way: float = WAY, keep: Sequence[str] = (), softening: bool = False, sets: Mapping[str, Any] = {}, jobs: Optional[int] = None,
              ranks: Optional[int] = None, threads: int = 1, options: Sequence[str] = (), overwrite: bool = False, told: Callable[[str], None] = print,
              program: Optional[Path] = None) -> FactorOfSafety:
    """The factor of safety of a scene (a file or a dict), into `output` (default: runs/stability-NAME), which is gone on with where it is there.

    tolerance: width of the bracket in F; cell [m] of the first level (default: the scene's), the second has half of it; levels: 1 gives no error bar;
    settle: the factor at which the slope comes to rest first, below 1 for one that fails at 1; height [m] of the slope, by which times and ways are
    measured (default: that of the soil along gravity); way: the share of it beyond which a slope that still slides has failed; keep: materials that stay as they are; softening: take clay that softens, too; jobs: runs
    at a time. Others as in `run`. Raises Error for what cannot be.
    """
    wanted = Wanted(tolerance, cell, levels, settle, height, way, tuple(keep), softening)
    keys = with_sets(scene if isinstance(scene, Mapping) else read_scene(scene), sets)
    refuse(wanted, keys)
    strengths = strengths_of(keys, keep, softening)
    name = "scene" if isinstance(scene, Mapping) else pathlib.Path(scene).stem
    path = pathlib.Path(output or f"runs/stability-{name}")
    record = _Record(path, _identity(keys, wanted), tolerance, overwrite)
    found = FactorOfSafety(path, str(keys.get("title") or name), remarks=remarks_of(keys))
    first = float(cell or keys["domain"]["cell"])
    with as_file(scene) as file:
        orders = Orders(file, dict(sets), ranks, threads, list(options), program)
        for wish in [first / 2 ** k for k in range(levels)]:
            fitted = fit(keys, wish)
            level = SlopeLevel(path / f"cell-{fitted.cell:.6g}", keys, fitted, strengths, settle, orders, height, way)
            near = found.levels[-1] if found.levels else None
            found.levels.append(_search(record, level, wanted, jobs_of(jobs, ranks, threads), near, told))
            record.save(as_json(found))
    return found
