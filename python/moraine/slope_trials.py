"""Runs of a slope at many factors, some at a time, until the bracket between the highest that stands and the lowest that fails is known."""
import json
import pathlib
import time
from typing import Any, Callable, Dict, Optional

from .errors import Error
from .factor_search import MOST, bracket, factor_of, next_factors
from .fleet import stop_jobs
from .slope_job import Job, Trial
from .slope_level import Settled, SlopeLevel
from .verdict import STANDS, UNDECIDED, judge


class SlopeTrials:
    """The trials of one level. `told` is called with a line when one has its verdict, `save` whenever there is something to keep."""

    def __init__(self, level: SlopeLevel, tolerance: float, jobs: int, told: Callable[[str], None], save: Callable[[], None]) -> None:
        self.level, self.tolerance, self.jobs, self.told, self.save = level, tolerance, jobs, told, save
        self.trials: Dict[int, Trial] = {}
        self.settled: Optional[Settled] = None

    @property
    def verdicts(self) -> Dict[int, str]:
        return {k: trial.verdict for k, trial in self.trials.items() if trial.verdict}

    def settle(self) -> Settled:
        """The settled state, made where it is not there. Raises Error."""
        found = self.level.settled()
        if found is None:
            job = Job(self.level.settle_command(), self.level.folder / "settle")
            try:
                job.process.wait()
            except BaseException:
                stop_jobs([job.process], self.level.orders.ranks)
                job.end()
                raise
            wrong = job.end()
            if wrong:
                raise self.level.unsettled(str(wrong)) if wrong.code == 3 else wrong
            found = self.level.settled()
            assert found
            for path in sorted((self.level.folder / "settle").glob("checkpoint-*.h5"))[:-1]:
                path.unlink()
        self.settled = found
        return found

    def directory(self, k: int) -> pathlib.Path:
        return self.level.folder / f"F-{factor_of(k, self.tolerance):g}"

    def search(self, first: int, step: int, assumed: Optional[int] = None) -> None:
        """Tries factors until the bracket is known; `assumed` stands without a trial, as long as nothing rests on that alone."""
        self._search(first, step, {assumed: STANDS} if assumed is not None else {})
        if assumed is not None and bracket(self.verdicts)[0] is None:
            self._search(assumed, step, {})

    def _search(self, first: int, step: int, known: Dict[int, str]) -> None:
        going: Dict[int, Job] = {}
        try:
            while True:
                found = {**known, **self.verdicts}
                self._drop_moot(going, found)
                for k in next_factors(found, first, step, self.jobs):
                    if len(going) < self.jobs and k not in going:
                        self._refuse_far(k)
                        going[k] = self._start(k)
                if not going:
                    return
                time.sleep(0.02)
                for k, job in list(going.items()):
                    if job.process.poll() is not None:
                        del going[k]
                        if not self._take(k, job):
                            going[k] = self._start(k)
        finally:
            stop_jobs([job.process for job in going.values()], self.level.orders.ranks)
            for job in going.values():
                job.end()

    def _refuse_far(self, k: int) -> None:
        if k * self.tolerance > MOST:
            raise Error(f"the slope stands at F = {MOST:g} still (it has nothing to slide on, or hardly a slope). Is a strength too high, or --keep one too many?")

    def _drop_moot(self, going: Dict[int, Job], found: Dict[int, str]) -> None:
        """Ends trials that tell nothing more: above one that fails, below one that stands."""
        stands, fails = bracket(found)
        for k in list(going):
            if (fails is not None and k > fails) or (stands is not None and k < stands):
                job = going.pop(k)
                stop_jobs([job.process], self.level.orders.ranks)
                job.end()
                self.trials.pop(k, None)
                self.level.drop(self.directory(k))

    def _start(self, k: int) -> Job:
        trial = self.trials.setdefault(k, Trial(factor_of(k, self.tolerance)))
        directory = self.directory(k)
        assert self.settled
        if trial.part == 0 and not list(directory.glob("checkpoint-*.h5")):
            self.level.drop(directory)
        return Job(self.level.trial_command(directory, trial.factor, trial.part + 1, self.settled), directory)

    def _take(self, k: int, job: Job) -> bool:
        """Whether a trial whose part has ended has its verdict. Raises Error where it failed otherwise."""
        trial, directory, level = self.trials[k], self.directory(k), self.level
        wrong = job.end()
        trial.wall_s += time.monotonic() - job.began
        if wrong and wrong.code != 3:
            raise wrong
        assert self.settled and level.rule
        ways = level.ways_of(directory, self.settled)
        trial.times, trial.ways = [t - ways.times[0] for t in ways.times], ways.ways
        trial.part += 1
        summary: Dict[str, Any] = json.loads((directory / "summary.json").read_text())
        trial.verdict = judge(level.rule, trial.times, trial.ways, summary["ended_by"] == "rest") or ""
        if wrong and not trial.verdict:
            raise wrong
        if not trial.verdict and trial.part >= level.rule.parts:
            trial.verdict = UNDECIDED
        there = sorted(directory.glob("checkpoint-*.h5"))
        for path in there if trial.verdict else there[:-1]:
            path.unlink()
        self.save()
        if trial.verdict:
            self.told(f"cell {level.level.cell:.6g} m, F = {trial.factor:g}: {trial.verdict}, way {trial.ways[-1]:.3g} m after {trial.times[-1]:.3g} s "
                      f"({trial.wall_s:.3g} s)")
        return bool(trial.verdict)
