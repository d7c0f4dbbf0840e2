"""A slope on one cell: the state from which all factors begin, and the words that start a run of one of them."""
import dataclasses
import json
import math
import pathlib
import shutil
import tempfile
from typing import Any, Dict, List, Mapping, Optional, Sequence

import numpy

from .columns import spacing
from .errors import Error
from .fleet import Orders
from .levels import Level
from .program import command_of, run
from .results import Run
from .scene import with_sets
from .strengths import Strength, reduced
from .verdict import LOOKS, WAY, Rule, Ways, rule_of

DAMPING = 0.7    # numerics.damping while it settles
SETTLES = 60.0   # in sqrt(H/g): in which it must have settled


@dataclasses.dataclass(frozen=True)
class Settled:
    """The last checkpoint of the settled run, its output of the same step, its time [s], how far the slope has moved until then [m], and particles."""

    checkpoint: pathlib.Path
    output: int
    time: float
    way: float
    particles: int


class SlopeLevel:
    """In `folder` (settle/, F-1.37/ and so on); `scene` are all keys, `orders` how runs are started."""

    def __init__(self, folder: pathlib.Path, scene: Mapping[str, Any], level: Level, strengths: Sequence[Strength], settle: float, orders: Orders,
                 height: Optional[float], way: float = WAY) -> None:
        self.folder, self.level, self.strengths, self.settle_factor, self.orders = folder, level, strengths, settle, orders
        self.scene = with_sets(scene, level.sets)
        self.height, self.way, self.rule = height, way, None  # type: Optional[float], float, Optional[Rule]

    @property
    def periodic(self) -> List[float]:
        """Lengths of periodic axes [m], 0 of others."""
        domain = self.scene["domain"]
        axes = domain.get("periodic", [])
        return [float(domain["max"][a] - domain["min"][a]) if "xyz"[a] in axes else 0.0 for a in range(self.scene["dimensions"])]

    def _sets(self) -> Dict[str, Any]:
        output = self.scene.get("output", {})
        law_has = {"drucker-prager", "tresca", "von-mises", "mu-i"} & {item.get("law") for item in self.scene.get("material", [])}
        fields = list(dict.fromkeys([*output.get("fields", []), "velocity", *(["plastic_shear_strain"] if law_has else [])]))
        labels = list(dict.fromkeys([*output.get("labels", []), "id"]))
        sets = {**self.orders.sets, **self.level.sets, "output.fields": fields, "output.labels": labels, "output.fields_on": "particles"}
        if self.scene.get("numerics", {}).get("sleep", "off") != "off":
            sets["numerics.sleep"] = "off"
        return sets

    def prepare(self) -> Rule:
        """The rule, by the height of the soil at the start along gravity; the program refuses here what is wrong with the scene. Raises Error."""
        if self.height is None:
            with tempfile.TemporaryDirectory(prefix="moraine-") as folder:
                start = run(self.orders.scene, pathlib.Path(folder) / "start", {**self._sets(), **reduced(self.strengths, self.settle_factor), "time.end": 0.0},
                            options=[*self.orders.options, "--quiet"], progress=False, program=self.orders.program)
                with start.particles as series:
                    position = series.read(0, []).position
                    place = position @ (numpy.array(self.scene["gravity"]) / math.hypot(*self.scene["gravity"]))
            if len(place) == 0 or place.max() == place.min():
                raise Error("the scene has no soil at its start (no height is seen). Give --height?")
            self.height = float(place.max() - place.min() + spacing(position))  # of particles as large as what is between them
        self.rule = rule_of(self.scene, self.level.cell, self.height, self.way)
        return self.rule

    def _command(self, directory: pathlib.Path, sets: Mapping[str, Any], begins: bool, more: Sequence[str]) -> List[str]:
        assert self.rule
        all_sets = {**self._sets(), **self.rule.rest_sets(), "output.interval": self.rule.look, **sets}
        return command_of(self.orders.scene, directory, all_sets, self.orders.ranks, self.orders.threads, begins, [*self.orders.options, *more], self.orders.program)

    def settle_command(self) -> List[str]:
        """Begins it, or goes on with it."""
        assert self.rule
        directory = self.folder / "settle"
        sets = {**reduced(self.strengths, self.settle_factor), "numerics.damping": DAMPING, "time.end": SETTLES * self.rule.unit,
                "output.checkpoint_interval": self.rule.look}
        there = sorted(directory.glob("checkpoint-*.h5"))
        return self._command(directory, sets, not there, ["--restart", str(there[-1])] if there else [])

    def settled(self) -> Optional[Settled]:
        """None where it is still to be made. Raises Error where it does not come to rest."""
        directory = self.folder / "settle"
        try:
            ended = json.loads((directory / "summary.json").read_text())["ended_by"]
        except (OSError, ValueError, LookupError, TypeError):
            return None
        if ended not in ("rest", "end"):
            return None
        if ended == "end":
            raise self.unsettled()
        found = Run(directory)
        if not found.checkpoints:
            return None
        step = int(found.checkpoints[-1].stem.rpartition("-")[2])
        rows = numpy.flatnonzero(found.history.get("step", numpy.zeros(0)) == step)
        if len(rows) == 0:
            raise Error(f"{directory / 'history.csv'} is damaged (it has no row of step {step}). --overwrite?")
        assert self.rule
        output = int(rows[-1])
        with found.particles as series:
            way = Ways(series, 0, self.periodic, self.rule.mass)
            way.look(series, output)
            time, count = float(series.times[output]), len(series.read(output, []))
        return Settled(found.checkpoints[-1], output, time, way.ways[-1], count)

    def unsettled(self, said: str = "") -> Error:
        """What is said of a slope that slides while it is to settle; said: by the program."""
        more = f"; the run ended so: {said}" if said else ""
        return Error(f"the slope does not come to rest at F = {self.settle_factor:g}, with damping (its factor of safety is below, or it still settles{more}). "
                     f"Try --settle {self.settle_factor / 2:g} --overwrite?", 3)

    def trial_command(self, directory: pathlib.Path, factor: float, part: int, settled: Settled) -> List[str]:
        """Part 1, 2, ... of a factor's run, each CALM long: the first from the settled state, others from the one before."""
        assert self.rule
        first = math.floor(settled.time / self.rule.look)
        sets = {**reduced(self.strengths, factor), "numerics.damping": 0.0, "time.end": (first + LOOKS * part) * self.rule.look,
                "output.checkpoint_interval": self.rule.look}
        there = sorted(directory.glob("checkpoint-*.h5"))
        if there:
            return self._command(directory, sets, False, ["--restart", str(there[-1])])
        changed = [word for key in [*(s.key for s in self.strengths), "numerics.damping"] for word in ("--allow-change", key)]
        return self._command(directory, sets, True, ["--restart", str(settled.checkpoint), *changed])

    def ways_of(self, directory: pathlib.Path, settled: Settled) -> Ways:
        """Of a trial's outputs so far."""
        assert self.rule
        with Run(self.folder / "settle").particles as series:
            ways = Ways(series, settled.output, self.periodic, self.rule.mass)
        with Run(directory).particles as series:
            ways.look(series)
        return ways

    @staticmethod
    def drop(directory: pathlib.Path) -> None:
        """Removes a run of this study's."""
        if directory.is_dir() and not directory.is_symlink():
            shutil.rmtree(directory, ignore_errors=True)
