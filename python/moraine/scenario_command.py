"""moraine study STUDY.toml [options]: one scene with many values of its parameters."""
import argparse
import os
import signal
import sys
from typing import Any, List, Optional, Sequence

from .command_line import Parser, exit_code
from .converge_command import STOPPED
from .errors import Error
from .scenario_text import summary
from .scenarios import run_study


def common_options(words: Parser) -> None:
    """Of study and calibrate."""
    words.add_argument("--output", metavar="DIR", help="where results go, and what is gone on with (default: runs/ and the file's name)")
    words.add_argument("--overwrite", action="store_true", help="begin again")
    words.add_argument("--budget", metavar="TIME", help="begin no run that would end beyond this wall time, as 30min or 2h")
    words.add_argument("--jobs", type=int, metavar="N", help="runs at a time (default: what the cores allow)")
    words.add_argument("--ranks", type=int, metavar="N", help="start mpirun with so many ranks for each run")
    words.add_argument("--threads", type=int, default=1, metavar="N", help="of each rank (default: 1)")
    for name in ("device", "transport", "partitioner"):
        words.add_argument(f"--{name}", metavar="NAME", help="as in moraine run")
    words.add_argument("--allow-code", action="store_true", help="as in moraine run")
    words.add_argument("--quiet", action="store_true", help="no progress")


def check_options(given: argparse.Namespace, command: str) -> List[str]:
    """Words for the program. Raises Error."""
    if int(os.environ.get("OMPI_COMM_WORLD_SIZE", os.environ.get("PMI_SIZE", "1"))) > 1:
        raise Error(f"moraine {command} under mpirun (it starts its runs itself). Leave mpirun out, and say --ranks N?")
    for name in ("ranks", "threads", "jobs"):
        if getattr(given, name) is not None and getattr(given, name) < 1:
            raise Error(f"--{name} {getattr(given, name)} (must be at least 1). Did you mean 1?")
    options = [word for name in ("device", "transport", "partitioner") if getattr(given, name) for word in (f"--{name}", getattr(given, name))]
    return [*options, *(["--allow-code"] if given.allow_code else [])]


def parser(prog: str = "moraine study") -> argparse.ArgumentParser:
    words = Parser("moraine study inputs/studies/valley_study.toml --device cpu", prog=prog,
                   description="Runs a scene with many values of its parameters: envelope, quantiles and probabilities of maps, and what matters most.")
    words.add_argument("study", metavar="STUDY.toml", help="scene, parameters, sampling and quantities (docs/scenarios.md)")
    common_options(words)
    return words


def _run(given: argparse.Namespace) -> int:
    options = check_options(given, "study")
    found = run_study(given.study, given.output, given.jobs, given.ranks, given.threads, options, given.budget, given.overwrite,
                      lambda line: None if given.quiet else print(line, file=sys.stderr, flush=True))
    from .scenario_page import write_page
    page = write_page(found)
    print(f"{summary(found)}\nResults are in {found.path}: {page.name}, study.csv, sensitivity.csv" + (f", maps/ ({len(found.maps)} maps)" if found.maps else ""))
    return 0 if found.finished else max((member.code or 0 for member in found.failed), default=0)


def stopped_by(command: str, main: Any, scene: str) -> int:
    """Runs it; SIGTERM and Ctrl-C end it with the code of a run that was stopped."""
    def stop(number: int, frame: Any) -> None:
        raise KeyboardInterrupt
    signal.signal(signal.SIGTERM, stop)
    try:
        return exit_code(main, scene)
    except KeyboardInterrupt:
        print(f"moraine: {command} was stopped (by a signal; runs under way have checkpoints). Go on by the same command?", file=sys.stderr)
        return STOPPED


def main(words: Optional[Sequence[str]] = None) -> int:
    given = parser().parse_args(words)
    return stopped_by("study", lambda: _run(given), given.study)


if __name__ == "__main__":
    sys.exit(main())
