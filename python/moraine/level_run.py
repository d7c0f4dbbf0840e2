"""One level of a refinement study: what it will take, its run, and what is kept of it."""
import dataclasses
import re
import time
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence

from .levels import Level
from .program import Check, run
from .results import Run
from .scene import Path
from .study import LevelRun, Study, Variant

CHECKPOINTS_S = 600.0  # wall time between checkpoints of a level, from which an interrupted study goes on


@dataclasses.dataclass(frozen=True)
class Plan:
    """How to compute and when to stop."""

    levels: int
    error: Optional[float]
    budget_s: Optional[float]
    ratio: List[int]
    coarsest: Optional[float]
    ranks: Optional[int]
    threads: int
    options: Sequence[str]
    program: Optional[Path]


def forecast(variant: Variant, said: Check, on_device: bool) -> Dict[str, Any]:
    """Particles, steps, memory and seconds of a level, by what `moraine check` says and what the level before took; its steps
    and its time are corrected by those of that level, which `said_steps` and `stepping_s` remember.
    """
    memory = said.values["memory"][min(int(on_device), len(said.values["memory"]) - 1)]
    found: Dict[str, Any] = {"particles": said.particles, "steps": said.steps, "said_steps": said.steps, "memory": memory, "seconds": None}
    before = variant.next_level
    if variant.levels and before and before.get("said_steps"):
        last = variant.levels[-1]
        found["steps"] = round(said.steps * last.steps / before["said_steps"])
        grown = said.particles / max(last.particles, 1)
        stepping = before["stepping_s"]
        found["seconds"] = stepping * grown * found["steps"] / max(last.steps, 1) + max(last.wall_s - stepping, 0.0) * grown
    return found


def name_of(variant: Variant, cell: float) -> str:
    return re.sub(r"[^\w.,=+-]+", "_", f"{variant.name}-cell-{cell:.6g}".lstrip("-"))


def _checkpoint_sets(study: Study) -> Dict[str, Any]:
    output = study.keys.get("output", {})
    asked = output.get("checkpoint_interval", 0) or output.get("checkpoint_wall_interval", 0)
    return {} if asked else {"output.checkpoint_wall_interval": CHECKPOINTS_S}


def _field_sets(study: Study) -> Dict[str, Any]:
    """The fields that the quantities need besides those of the scene."""
    fields = list(study.keys.get("output", {}).get("fields", ["velocity", "stress"]))
    more = sorted({name for q in study.quantities for name in q.fields or [] if name not in fields})
    return {"output.fields": fields + more} if more else {}


def _end_sets(study: Study) -> Dict[str, Any]:
    """All levels go on for as long, also where the scene stops at rest, which each level would reach at another time."""
    return {"time.stop": "end"} if study.keys["time"].get("stop", "end") != "end" else {}


def compute(study: Study, plan: Plan, sets: Mapping[str, Any], name: str, told: Callable[[str], None]) -> Run:
    """The run of a level: one that is there is taken, one that was interrupted goes on from its last checkpoint."""
    directory = study.path / name
    end = float(study.keys["time"]["end"])
    if study.is_finished(name, end):
        if not study.known["runs"].get(name):
            study.spend(name, Run(directory).summary["wall_s"])
        told(f"{name} is there")
        return Run(directory)
    options = list(plan.options)
    there = sorted(directory.glob("checkpoint-*.h5"))
    if there:
        options += ["--restart", str(there[-1])]
        told(f"{name} goes on from {there[-1].name}")
    if all(quantity.fields is None for quantity in study.quantities):
        options.append("--no-particles")
    start = time.monotonic()
    study.known["runs"].setdefault(name, 0.0)
    study.save()
    try:
        done = run(study.scene, directory, {**sets, **_checkpoint_sets(study), **_field_sets(study), **_end_sets(study)}, plan.ranks, plan.threads,
                   lambda progress: told(f"{name}: {100 * progress.share:.0f} %  {progress.line}"), not there, options, plan.program)
    finally:
        study.spend(name, time.monotonic() - start)
        study.save()
    if _checkpoint_sets(study):
        for path in done.checkpoints:
            path.unlink()
    return done


def take(study: Study, variant: Variant, level: Level, name: str, done: Run) -> None:
    summary, end = done.summary, float(study.keys["time"]["end"])
    values = {q.text: q.read(done, end, level.cell) for q in study.quantities}
    origins = {q.text: q.origin(done, level.cell) for q in study.quantities}
    took = study.known["runs"][name]  # with what came before an interruption
    variant.levels.append(LevelRun(level.cell, name, dict(level.sets), list(level.remarks), summary["particles"], summary["steps"],
                                   took, summary["commit"], values, origins))
    if variant.next_level:
        variant.next_level["stepping_s"] = min(1.0, summary["stepping_s"] / max(summary["wall_s"], 1e-9)) * took
