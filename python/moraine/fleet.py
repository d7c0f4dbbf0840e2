"""Many runs of one scene, several at a time, in directories of their own; what is there is taken, what was interrupted goes on."""
import dataclasses
import json
import os
import pathlib
import signal
import subprocess
import time
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence

from .program import command_of, problem_of
from .scene import Path
from .waiting import parse_progress

CHECKPOINTS_S = 600.0  # wall time between checkpoints, from which an interrupted run goes on
LOG = "stderr.txt"     # in the directory beside those of runs, while it goes on
LAST_S = 60.0          # that a stopped run has for its checkpoint


@dataclasses.dataclass
class Member:
    """One run: its directory, the keys that it changes, its exit code (None: not yet) and what failed, and what it took [s]."""

    name: str
    sets: Dict[str, Any]
    code: Optional[int] = None
    problem: str = ""
    wall_s: float = 0.0


@dataclasses.dataclass(frozen=True)
class Orders:
    """How to start runs: the scene's file, keys that all change, and the words of the program."""

    scene: Path
    sets: Mapping[str, Any]
    ranks: Optional[int]
    threads: int
    options: Sequence[str]
    program: Optional[Path]


def jobs_of(jobs: Optional[int], ranks: Optional[int], threads: int) -> int:
    """How many runs at a time: as many as there are cores for, unless it is said."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return jobs or max(1, cores // ((ranks or 1) * threads))


def is_done(directory: pathlib.Path) -> bool:
    """Whether a run came to its end there."""
    try:
        return json.loads((directory / "summary.json").read_text())["ended_by"] in ("end", "rest")
    except (OSError, ValueError, LookupError, TypeError):
        return False


def stop_jobs(jobs: Sequence["subprocess.Popen[bytes]"], ranks: Optional[int]) -> None:
    """The program writes a checkpoint on SIGTERM; mpirun hands SIGUSR1 on to it."""
    for job in jobs:
        job.send_signal(signal.SIGTERM if ranks is None else signal.SIGUSR1)
    last = time.monotonic() + LAST_S
    for job in jobs:
        try:
            job.wait(max(0.1, last - time.monotonic()))
        except subprocess.TimeoutExpired:
            job.kill()
            job.wait()


class Fleet:
    """Runs members in `folder`. `told` is called with a line when one ends."""

    def __init__(self, folder: pathlib.Path, orders: Orders, jobs: int, told: Callable[[str], None], budget_s: Optional[float] = None) -> None:
        self.folder, self.orders, self.jobs, self.told, self.budget_s = folder, orders, jobs, told, budget_s
        self.started = time.monotonic()
        self.stopped_by_budget = False

    def run(self, members: Sequence[Member], ended: Callable[[Member], None]) -> None:
        """All that are not done, in order; `ended` is called after each. On an interruption those under way write checkpoints."""
        waiting, going = [], {}  # type: ignore[var-annotated]
        for member in members:
            if is_done(self.folder / member.name):
                member.code, member.problem = 0, ""
                ended(member)
            elif member.code in (None, 5):
                waiting.append(member)
        took: List[float] = [m.wall_s for m in members if m.wall_s]
        try:
            while waiting or going:
                while waiting and len(going) < self.jobs and self._may_begin(took):
                    member = waiting.pop(0)
                    going[member.name] = member, self._start(member), time.monotonic()
                if not going:
                    break
                time.sleep(0.02)
                for name, (member, job, begun) in list(going.items()):
                    if job.poll() is not None:
                        del going[name]
                        member.wall_s += time.monotonic() - begun
                        took.append(member.wall_s)
                        self._end(member, job)
                        ended(member)
        finally:
            stop_jobs([job for _, job, _ in going.values()], self.orders.ranks)

    def _may_begin(self, took: List[float]) -> bool:
        mean = sum(took) / len(took) if took else 0.0
        good = self.budget_s is None or time.monotonic() - self.started + mean <= self.budget_s
        self.stopped_by_budget |= not good
        return good

    def _start(self, member: Member) -> "subprocess.Popen[bytes]":
        directory = self.folder / member.name
        there = sorted(directory.glob("checkpoint-*.h5"))
        sets = {"output.checkpoint_wall_interval": CHECKPOINTS_S, **self.orders.sets, **member.sets}
        options = [*self.orders.options, *(["--restart", str(there[-1])] if there else [])]
        command = command_of(self.orders.scene, directory, sets, self.orders.ranks, self.orders.threads, not there, options, self.orders.program)
        self.folder.mkdir(parents=True, exist_ok=True)
        with open(self._log(member), "wb") as log:
            return subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=log, start_new_session=True)

    def _log(self, member: Member) -> pathlib.Path:
        return self.folder / f"{member.name}.{LOG}"

    def _end(self, member: Member, job: "subprocess.Popen[bytes]") -> None:
        lines = self._log(member).read_text(encoding="utf-8", errors="replace").splitlines()
        self._log(member).unlink()
        member.code = job.returncode if job.returncode >= 0 else 128 - job.returncode
        member.problem = "" if member.code == 0 else str(problem_of([line for line in lines if not parse_progress(line)], member.code))
        if member.code == 0:
            for path in (self.folder / member.name).glob("checkpoint-*.h5"):
                path.unlink()
        self.told(f"{member.name}: {f'{member.wall_s:.3g} s' if member.code == 0 else f'FAILED ({member.code}): {member.problem}'}")
