"""`moraine.converge`: a refinement study from Python, and the words that name its errors and budgets."""
import pathlib
import re
from typing import Any, Callable, Mapping, Optional, Sequence, Union

from .converge_files import refuse_curves, write_curves, write_files
from .converge_text import after_level, before_level
from .curves import parse_curve, read_data
from .errors import Error
from .level_run import Plan
from .levels import parse_ratio, refuse_tables
from .quantity import parse_quantities
from .refine import refine, variants_of
from .scene import Path, Scene
from .study import Study, Variant

LEVELS, MOST_LEVELS = 3, 6  # without and with a wanted error
SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0}


def parse_error(text: str) -> float:
    """A wanted error as a share of the value.

    >>> parse_error("1%"), parse_error("0.02")
    (0.01, 0.02)
    """
    found = re.fullmatch(r"([0-9.]+)\s*(%?)", text.strip())
    try:
        error = float(found[1]) / (100 if found[2] else 1) if found else 0.0
    except ValueError:
        error = 0.0
    if not 0 < error < 1:
        raise Error(f"--error {text} (it must be a share of the value, between 0 and 100 %). Try 1%?")
    return error


def parse_budget(text: str) -> float:
    """Wall time in seconds.

    >>> parse_budget("30min"), parse_budget("1.5 h")
    (1800.0, 5400.0)
    """
    found = re.fullmatch(r"(\d+\.?\d*|\.\d+)\s*(s|min|h|d)", text.strip())
    if not found or float(found[1]) <= 0:
        raise Error(f"--budget {text} (it must be a time with s, min, h or d). Try 30min?")
    return float(found[1]) * SECONDS[found[2]]


def converge(scene: Scene, quantity: str = "front", output: Optional[Path] = None, error: Union[float, str, None] = None,
             levels: Optional[int] = None, ratio: str = "2:3:4", coarsest: Optional[float] = None, budget: Union[float, str, None] = None,
             sets: Mapping[str, Any] = {}, set_each: Mapping[str, Sequence[Any]] = {}, ranks: Optional[int] = None, threads: int = 1,
             options: Sequence[str] = (), overwrite: bool = False, told: Callable[[str], None] = print,
             progress: Callable[[str], None] = lambda line: None, program: Optional[Path] = None, curves: Sequence[str] = (), data: Optional[Path] = None) -> Study:
    """Runs a scene on finer and finer cells and returns what its values are known to.

    quantity: names with commas between (`Quantity`); error: the wanted error as a share (0.01 or "1%"), which four levels or more must show, else `levels` are computed;
    budget: wall time [s] or "30min" that no level is begun beyond; ratio: cells over one length, level by level; coarsest: cell [m] of
    the first level (default: the third has the scene's cell); sets: changed keys; set_each: keys with the values to compare; told: called
    with the text after each level; output (default: runs/converge-NAME) is gone on with where it is there. Others as in `run`.

    curves: as "structure.NAME.force_y/displacement_y", of which curve-*.csv and .svg have a band over the range; data: a .csv that is laid
    beside them. Raises Error for what cannot be, as `run` does.
    """
    error = parse_error(error) if isinstance(error, str) else error
    if levels is None:
        levels = LEVELS if error is None else MOST_LEVELS
    if levels < LEVELS:
        raise Error(f"--levels {levels} (an order is seen on three). Try --levels 3?")
    if coarsest is not None and not coarsest > 0:
        raise Error(f"--coarsest {coarsest:g} (a cell is longer than 0 m). Leave it out?")
    plan = Plan(levels, error, parse_budget(budget) if isinstance(budget, str) else budget, parse_ratio(ratio), coarsest, ranks, threads,
                options, program)
    name = "scene" if isinstance(scene, Mapping) else pathlib.Path(scene).stem
    study = Study(scene, pathlib.Path(output or f"runs/converge-{name}"), sets, parse_quantities(quantity), variants_of(set_each), overwrite)
    if "cell" not in study.keys.get("domain", {}) or "end" not in study.keys.get("time", {}):
        raise Error(f"{name} has no domain.cell or no time.end (both are needed). Is it a scene?")
    refuse_tables(study.keys)
    wanted, own = [parse_curve(text) for text in curves], read_data(pathlib.Path(data)) if data else None
    refuse_curves(wanted, own, study.keys)

    def before(variant: Variant) -> None:
        told(before_level(variant))

    def after(_: Study, variant: Variant) -> None:
        told(after_level(study, variant))
    refine(study, plan, before, after, progress)
    write_files(study)
    for line in write_curves(study, wanted, own):
        told(line)
    return study
