"""A job of the program: its words as they come, and its end."""
import dataclasses
import re
import signal
import subprocess
from typing import Callable, List, Optional

_LINE = re.compile(r"step (\d+) +t (\S+) of (\S+) s")


@dataclasses.dataclass(frozen=True)
class Progress:
    """How far a run is: steps, simulated time [s], the time at which it will end [s], the program's own line."""

    step: int
    time: float
    end: float
    line: str

    @property
    def share(self) -> float:
        """Part of the simulated time that is done, 0 to 1."""
        return min(1.0, self.time / self.end) if self.end > 0 else 1.0


def parse_progress(line: str) -> Optional[Progress]:
    """The progress that a line of the program tells, None if it tells none.

    >>> parse_progress("step 1695  t 3 of 6 s (50 %)  ETA 0:00:09  5.68 M particle-steps/s  imbalance 1.000").share
    0.5
    """
    found = _LINE.search(line)
    return Progress(int(found[1]), float(found[2]), float(found[3]), line) if found else None


@dataclasses.dataclass(frozen=True)
class Ended:
    """Exit code of a job and all that it said on stderr."""

    code: int
    lines: List[str]


def wait_for(command: List[str], stop: signal.Signals, told: Callable[[str], None]) -> Ended:
    """Starts the command and gives every line of its stderr to `told` until it ends.

    When Python is interrupted (Ctrl-C), or `told` raises, the job gets the signal `stop`, on which it writes a checkpoint, and
    what was raised goes on when the job has ended; after a minute it is killed.
    """
    # Apart from the terminal: Ctrl-C reaches Python alone, and the job is told once.
    job = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                           errors="replace", start_new_session=True)
    assert job.stderr
    lines: List[str] = []
    try:
        for line in job.stderr:
            lines.append(line.rstrip())
            told(lines[-1])
        return Ended(job.wait(), lines)
    except BaseException:
        job.send_signal(stop)
        try:
            job.communicate(timeout=60)
        except subprocess.TimeoutExpired:
            job.kill()
            job.wait()
        raise
    finally:
        job.stderr.close()
