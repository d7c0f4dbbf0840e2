"""A refinement study: a scene on finer and finer cells, and what its values are then known to."""
import dataclasses
import hashlib
import json
import pathlib
import re
import shutil
from typing import Any, Dict, List, Mapping, Optional, Sequence

from .errors import Error
from .quantity import Quantity
from .richardson import Estimate, estimate
from .scene import Scene, read_scene, with_sets

FILE = "converge.json"


@dataclasses.dataclass
class LevelRun:
    """A finished level: its cell [m], the keys that it changed, what of the scene did not fit, what it took and its values."""

    cell: float
    directory: str
    sets: Dict[str, Any]
    remarks: List[str]
    particles: int
    steps: int
    wall_s: float
    commit: str
    values: Dict[str, float]
    origins: Dict[str, float] = dataclasses.field(default_factory=dict)  # of the values that are not counted from 0


@dataclasses.dataclass
class Variant:
    """One way of computing the scene: its name ("" where there is only one), the keys that it changes, its levels so far, why it
    stopped, and what is predicted of the level that would come next.
    """

    name: str
    sets: Dict[str, Any]
    levels: List[LevelRun] = dataclasses.field(default_factory=list)
    stopped: str = ""
    reached: bool = False
    failed: int = 0  # exit code of a level
    next_level: Optional[Dict[str, Any]] = None
    maps: List[Dict[str, Any]] = dataclasses.field(default_factory=list)  # MapError of the finest levels

    def estimate(self, quantity: Quantity, upto: Optional[int] = None) -> Estimate:
        """What the finest three levels, or those of the first `upto`, say of a quantity."""
        levels = self.levels[:upto]
        return estimate([level.cell for level in levels], [level.values[quantity.text] for level in levels], quantity.resolution(levels[-1].cell),
                        levels[-1].origins.get(quantity.text, 0.0))

    def is_confirmed(self, quantity: Quantity) -> Optional[bool]:
        """Whether the error bar of the level before holds the finest value; None where there is no such bar. Three levels can
        show an order by chance, which a fourth does not repeat.
        """
        if len(self.levels) < 4:
            return None
        before, now = self.estimate(quantity, len(self.levels) - 1), self.estimate(quantity)
        if before.error is None:
            return None
        return now.verdict == "equal" or abs(now.finest - before.finest) <= before.error


def is_level(path: pathlib.Path) -> bool:
    """Whether a study made this: a folder of a run by the name of its cell, no link to one."""
    return bool(re.fullmatch(r"([\w.,=+-]+-)?cell-[0-9.e+-]+", path.name)) and path.is_dir() and not path.is_symlink()


def _known_of(found: Any) -> Dict[str, Any]:
    """What converge.json holds, or ValueError: it may have been written by anybody."""
    runs = found.get("runs") if isinstance(found, dict) else None
    if not isinstance(runs, dict) or not all(isinstance(s, (int, float)) for s in runs.values()):
        raise ValueError("no study")
    known: Dict[str, Any] = found
    return known


class Study:
    """Levels of each variant in `directory`, which converge.json there remembers from call to call."""

    def __init__(self, scene: Scene, directory: pathlib.Path, sets: Mapping[str, Any], quantities: Sequence[Quantity],
                 variants: Sequence[Variant], overwrite: bool = False) -> None:
        self.scene, self.path, self.sets, self.quantities, self.variants = scene, directory, dict(sets), list(quantities), list(variants)
        given = scene if isinstance(scene, Mapping) else read_scene(scene)
        self.keys = with_sets(given, sets)
        text = json.dumps(self.keys, sort_keys=True, default=lambda value: value.tolist())
        self.identity = hashlib.sha256(text.encode()).hexdigest()[:16]
        self.known: Dict[str, Any] = {"runs": {}}
        if directory.exists():
            self._open(overwrite)

    def _open(self, overwrite: bool) -> None:
        """Goes on with what is there."""
        there = any(self.path.iterdir())
        try:
            self.known = _known_of(json.loads((self.path / FILE).read_text()))
        except OSError:
            if there:
                raise Error(f"{self.path} is taken (it is no refinement study: there is no {FILE}). Another --output?") from None
        except ValueError:
            if not overwrite:
                raise Error(f"{self.path} cannot be continued (its {FILE} is damaged). --overwrite, or another --output?") from None
        if overwrite:
            for level in self.path.iterdir():
                if is_level(level):
                    shutil.rmtree(level, ignore_errors=True)
            self.known = {"runs": {}}
        elif there and self.known.get("identity") != self.identity:
            raise Error(f"{self.path} has another study (of another scene, or other --set). Another --output, or --overwrite?")

    @property
    def spent_s(self) -> float:
        """Wall time of all runs so far, stopped ones too."""
        return float(sum(self.known["runs"].values()))

    def spend(self, directory: str, seconds: float) -> float:
        """Adds to what a level took, and returns that."""
        took: float = self.known["runs"].get(directory, 0.0) + seconds
        self.known["runs"][directory] = took
        return took

    def estimates(self) -> List[Dict[str, Any]]:
        return [{"variant": v.name, "quantity": q.text, **dataclasses.asdict(v.estimate(q)), "relative": v.estimate(q).relative,
                 "confirmed": v.is_confirmed(q)}
                for v in self.variants for q in self.quantities if v.levels]

    def save(self) -> None:
        """Writes converge.json; a reader never sees half of it."""
        self.path.mkdir(parents=True, exist_ok=True)
        self.known.update({
            "identity": self.identity, "scene": str(self.scene) if not isinstance(self.scene, Mapping) else self.keys.get("title", "scene"),
            "sets": self.sets, "quantities": [q.text for q in self.quantities], "spent_s": self.spent_s,
            "variants": [dataclasses.asdict(v) for v in self.variants], "estimates": self.estimates()})
        part = self.path / (FILE + ".partial")
        part.write_text(json.dumps(self.known, indent=1, default=lambda value: value.tolist()) + "\n")
        part.replace(self.path / FILE)

    def is_finished(self, directory: str, end: float) -> bool:
        """Whether a level's run came to its end."""
        try:
            reached = json.loads((self.path / directory / "summary.json").read_text())["simulated_time_s"]
            return bool(reached >= end * (1 - 1e-12))
        except (OSError, ValueError, KeyError):
            return False
