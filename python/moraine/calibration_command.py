"""moraine calibrate FILE.toml [options]: parameters with which a scene gives what was seen."""
import argparse
import sys
from typing import Optional, Sequence

from .calibration import calibrate
from .calibration_text import summary, write_page
from .command_line import Parser
from .scenario_command import check_options, common_options, stopped_by


def parser(prog: str = "moraine calibrate") -> argparse.ArgumentParser:
    words = Parser("moraine calibrate inputs/studies/valley_calibration.toml --device cpu", prog=prog,
                   description="Fits parameters of a scene to outlines, deposits, gauges and other values that were seen, and says how well these tell them.")
    words.add_argument("file", metavar="FILE.toml", help="scene, parameters and targets (docs/scenarios.md)")
    common_options(words)
    return words


def _run(given: argparse.Namespace) -> int:
    options = check_options(given, "calibrate")
    found = calibrate(given.file, given.output, given.jobs, given.ranks, given.threads, options, given.budget, given.overwrite,
                      lambda line: None if given.quiet else print(line, file=sys.stderr, flush=True))
    page = write_page(found)
    print(f"{summary(found)}\nResults are in {found.path}: {page.name}, calibration.csv, posterior.csv, calibration.json")
    return 0


def main(words: Optional[Sequence[str]] = None) -> int:
    given = parser().parse_args(words)
    return stopped_by("calibrate", lambda: _run(given), given.file)


if __name__ == "__main__":
    sys.exit(main())
