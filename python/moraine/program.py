"""Calls the program: check a scene, run it and wait."""
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Optional, Sequence, Union

from .errors import Error
from .results import Run
from .scene import Path, Scene, as_file, set_words
from .waiting import Progress, parse_progress, wait_for

UNITS = {"s": 1.0, "min": 60.0, "h": 3600.0, "days": 86400.0}  # of the time that check says


def find_program(program: Optional[Path] = None) -> str:
    """The program: the argument, else the environment's MORAINE_PROGRAM, `moraine` on the path, or build/release/moraine.

    Raises Error if it is none of these.
    """
    named = program or os.environ.get("MORAINE_PROGRAM")
    if named:
        found = shutil.which(str(named))
        if not found:
            raise Error(f"{named} cannot be started (no such program). Is the path right?")
        return os.path.abspath(found)
    built = pathlib.Path("build/release/moraine").absolute()
    found = shutil.which("moraine") or (str(built) if os.access(built, os.X_OK) else None)
    if not found:
        raise Error("the program moraine was not found (neither on the path nor as build/release/moraine). "
                    "Build it with scripts/run, and set MORAINE_PROGRAM to where it is?")
    return found


class Check(NamedTuple):
    """What `moraine check` said: its text, and its lines by their first word (`Check.values["blocks"]`)."""

    text: str
    values: Dict[str, List[str]]

    @property
    def particles(self) -> int:
        """How many there are at the start."""
        return int(self.values["particles"][0].split()[0])

    @property
    def steps(self) -> int:
        """How many it takes to time.end, by the step at the start."""
        return int(self.values["steps"][0].split()[0])

    @property
    def seconds(self) -> Optional[float]:
        """Wall time of the run [s] on the machine that its line `time` names, without outputs; None where it says none.

        >>> Check("", {"time": ["about 12 min on one core"]}).seconds
        720.0
        """
        found = re.match(r"about (\S+) (s|min|h|days) ", " ".join(self.values.get("time", [])))
        return float(found[1]) * UNITS[found[2]] if found else None


def problem_of(lines: Sequence[str], code: int) -> Error:
    said = [line for line in lines if line.startswith("moraine: ")]
    message = said[0][len("moraine: "):] if said else "\n".join(list(lines)[-10:])
    return Error(message or f"the program failed (exit code {code}, no message). Is it one for this machine?", code)


def check(scene: Scene, sets: Mapping[str, Any] = {}, program: Optional[Path] = None, ranks: int = 1, options: Sequence[str] = ()) -> Check:
    """Asks the program whether a scene (a file or a dict) is right, and how big it is. `sets` changes keys of it; memory and
    time are those of each of `ranks` ranks; `options` are more words for the program, as ["--device", "cpu"].

    Raises Error with the program's message, which names line and remedy, where it is wrong. Writes nothing.
    """
    with as_file(scene) as file:
        done = subprocess.run([find_program(program), "check", str(file), "--ranks", str(ranks), *set_words(sets), *options], capture_output=True, text=True,
                              stdin=subprocess.DEVNULL)
    if done.returncode != 0:
        raise problem_of(done.stderr.splitlines(), done.returncode)
    values: Dict[str, List[str]] = {}
    name = "scene"
    for line in done.stdout.splitlines()[1:]:  # the first says that all is good
        name = line.split()[0] if line[:1].strip() else name
        values.setdefault(name, []).append(line[len(name):].strip() if line[:1].strip() else line.strip())
    return Check(done.stdout, values)


def words_of_check(options: Sequence[str]) -> List[str]:
    """Of the words for a run those that its check wants, too.

    >>> words_of_check(["--device", "cpu", "--allow-code"])
    ['--allow-code']
    """
    return [word for word in options if word == "--allow-code"]


def command_of(file: Path, output: Path, sets: Mapping[str, Any], ranks: Optional[int], threads: int, overwrite: bool, options: Sequence[str],
               program: Optional[Path]) -> List[str]:
    """The words that start a run of a scene's file."""
    mpirun = shlex.split(os.environ.get("MORAINE_MPIEXEC", "mpirun --oversubscribe --bind-to none -n"))
    start = ["env", f"OMP_NUM_THREADS={threads}", *([] if ranks is None else [mpirun[0], "-q", *mpirun[1:], str(ranks)])]
    return [*start, find_program(program), "run", str(file), "--output", str(output), *set_words(sets), *(["--overwrite"] if overwrite else []), *options]


def run(scene: Scene, output: Path, sets: Mapping[str, Any] = {}, ranks: Optional[int] = None, threads: int = 1,
        progress: Union[bool, Callable[[Progress], None]] = True, overwrite: bool = False, options: Sequence[str] = (),
        program: Optional[Path] = None) -> Run:
    """Runs a scene (a file or a dict) into the directory `output`, waits, and returns the run.

    `sets` changes keys of the scene; `ranks` starts mpirun (the environment's MORAINE_MPIEXEC instead, if set), each
    rank with `threads` threads; `progress` is True (lines on stderr), False, or called with a Progress at every 5 % of the run
    (at most each 5 s) and at the end;
    `options` are more words for the program, as ["--restart", FILE].

    Raises Error with the program's message and exit code. Ctrl-C makes the program write a checkpoint and end.
    """
    def told(line: str) -> None:
        known = parse_progress(line)
        if callable(progress):
            if known:
                progress(known)
        elif progress:
            print(line, file=sys.stderr)

    with as_file(scene) as file:
        command = command_of(file, output, sets, ranks, threads, overwrite, options, program)
        # mpirun kills its ranks soon after a SIGTERM, and hands a SIGUSR1 on to them.
        ended = wait_for(command, signal.SIGTERM if ranks is None else signal.SIGUSR1, told)
    if ended.code != 0:
        raise problem_of(ended.lines, ended.code)
    return Run(output)
