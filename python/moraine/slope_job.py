"""A process of a search, and what is known of the factor that it runs."""
import dataclasses
import pathlib
import subprocess
import time
from typing import Any, List, Mapping, Optional

from .errors import Error
from .factor_search import factor_of
from .fleet import LOG
from .program import problem_of
from .scenario_file import is_number
from .verdict import FAILS, STANDS, UNDECIDED
from .waiting import parse_progress


@dataclasses.dataclass
class Trial:
    """One factor: its verdict ("" while it goes on), the times since strengths were reduced [s] and the ways [m] of its looks, and what it took [s]."""

    factor: float
    verdict: str = ""
    times: List[float] = dataclasses.field(default_factory=list)
    ways: List[float] = dataclasses.field(default_factory=list)
    wall_s: float = 0.0
    part: int = 0


def trial_of(key: str, kept: Mapping[str, Any], tolerance: float) -> Trial:
    """One of stability.json. Fails where none is written so: ways may be infinite, of who has left the domain."""
    trial = Trial(**kept)
    numbers = [trial.factor, trial.wall_s, *trial.times, *trial.ways]
    if not all(map(is_number, numbers)) or len(trial.times) != len(trial.ways) or type(trial.part) is not int or trial.part < 0 \
            or trial.verdict not in ("", STANDS, FAILS, UNDECIDED) or trial.factor != factor_of(int(key), tolerance):
        raise ValueError(f"no trial is as {key[:40]!a}")
    return trial


class Job:
    """A process whose words go to a file beside its directory."""

    def __init__(self, command: List[str], directory: pathlib.Path) -> None:
        directory.parent.mkdir(parents=True, exist_ok=True)
        self.log, self.began = directory.parent / f"{directory.name}.{LOG}", time.monotonic()
        with open(self.log, "wb") as log:
            self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=log, start_new_session=True)

    def end(self) -> Optional[Error]:
        """Of one that has ended: what went wrong. Its words are removed."""
        lines = self.log.read_text(encoding="utf-8", errors="replace").splitlines()
        self.log.unlink()
        code = self.process.returncode
        return None if code == 0 else problem_of([line for line in lines if not parse_progress(line)], code if code > 0 else 128 - code)
