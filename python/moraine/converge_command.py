"""moraine converge SCENE.toml [options]: how exact a value of a scene is, by runs on finer and finer cells."""
import argparse
import os
import signal
import sys
from typing import Any, Dict, List, Optional, Sequence

from .command_line import Parser, exit_code
from .convergence import converge
from .converge_text import table
from .errors import Error
from .scene import parse_set

STOPPED = 5
EXAMPLE = "moraine converge inputs/slurry_runout.toml --quantity front --error 2%"


def parser(prog: str = "moraine converge") -> argparse.ArgumentParser:
    words = Parser(EXAMPLE, prog=prog, description="Runs a scene from coarse to fine cells: order, Richardson value and grid convergence index of a value.")
    words.add_argument("scene", metavar="SCENE.toml")
    words.add_argument("--quantity", default="front", metavar="NAME,...",
                       help="front, runout, drop, travel_angle, depth, maps.NAME, gauges.NAME.depth, sections.NAME.volume, a column of history.csv, or structure.NAME.force_x; @max, @min, @mean or @TIME instead of at the end (default: front)")
    words.add_argument("--curve", action="append", default=[], metavar="structure.NAME.Y/X", help="a column of a structure over another, as force_y/displacement_y, with a band over its range; again for more")
    words.add_argument("--with", dest="data", metavar="FILE.csv", help="a curve of your own beside them: a header and rows of x,y")
    words.add_argument("--error", metavar="PERCENT", help="go on to finer cells until the error is below, as 1%%, and a further level has confirmed it")
    words.add_argument("--levels", type=int, metavar="N", help="levels at most (default: 3; 6 with --error)")
    words.add_argument("--ratio", default="2:3:4", help="cells over one length, level by level; 1:2 halves (default: 2:3:4)")
    words.add_argument("--coarsest", type=float, metavar="METRES", help="cell of the first level (default: the third level has the scene's)")
    words.add_argument("--budget", metavar="TIME", help="begin no level that would end beyond this wall time in all, as 30min or 2h")
    words.add_argument("--set", dest="sets", action="append", default=[], metavar="KEY=VALUE", help="change a key of the scene; again for more")
    words.add_argument("--set-each", action="append", default=[], metavar="KEY=A,B,...", help="compare values of a key, side by side; again for combinations")
    words.add_argument("--output", metavar="DIR", help="where results go, and what is gone on with (default: runs/converge-SCENE)")
    words.add_argument("--overwrite", action="store_true", help="begin again")
    words.add_argument("--ranks", type=int, metavar="N", help="start mpirun with so many ranks")
    words.add_argument("--threads", type=int, default=1, metavar="N", help="of each rank (default: 1)")
    for name in ("device", "transport", "partitioner"):
        words.add_argument(f"--{name}", metavar="NAME", help="as in moraine run")
    words.add_argument("--allow-code", action="store_true", help="as in moraine run")
    words.add_argument("--quiet", action="store_true", help="no progress")
    return words


def _sides(texts: Sequence[str]) -> Dict[str, List[Any]]:
    """KEY=A,B,... of each text; commas in brackets divide nothing.

    >>> _sides(["numerics.transfer=apic,flip", "gravity=[0, -1],[0, -2]"])
    {'numerics.transfer': ['apic', 'flip'], 'gravity': [[0, -1], [0, -2]]}
    """
    found: Dict[str, List[Any]] = {}
    for text in texts:
        key, _, values = text.partition("=")
        words, depth = [""], 0
        for letter in values:
            depth += (letter in "[{") - (letter in "]}")
            if letter == "," and depth == 0:
                words.append("")
            else:
                words[-1] += letter
        found[key.strip()] = [parse_set(f"{key}={word}")[1] for word in words if word.strip()]
    return found


def _run(given: argparse.Namespace) -> int:
    if int(os.environ.get("OMPI_COMM_WORLD_SIZE", os.environ.get("PMI_SIZE", "1"))) > 1:
        raise Error("moraine converge under mpirun (it starts its runs itself). Leave mpirun out, and say --ranks N?")
    for name in ("ranks", "threads"):
        if getattr(given, name) is not None and getattr(given, name) < 1:
            raise Error(f"--{name} {getattr(given, name)} (must be at least 1). Did you mean 1?")
    options = [word for name in ("device", "transport", "partitioner") if getattr(given, name) for word in (f"--{name}", getattr(given, name))]
    options += ["--allow-code"] if given.allow_code else []
    study = converge(given.scene, given.quantity, given.output, given.error, given.levels, given.ratio, given.coarsest, given.budget,
                     dict(map(parse_set, given.sets)), _sides(given.set_each), given.ranks, given.threads, options, given.overwrite,
                     lambda text: print(text, flush=True),
                     lambda line: None if given.quiet else print(line, file=sys.stderr, flush=True),
                     curves=given.curve, data=given.data)
    print(f"\n{table(study)}\nResults are in {study.path}: converge.json, converge.csv" + "".join(f", {f.name}" for pattern in ("error-*.svg", "curve-*.svg") for f in sorted(study.path.glob(pattern))))
    return max(variant.failed for variant in study.variants)


def _stop(number: int, frame: Any) -> None:
    raise KeyboardInterrupt


def main(words: Optional[Sequence[str]] = None) -> int:
    given = parser().parse_args(words)
    signal.signal(signal.SIGTERM, _stop)
    try:
        return exit_code(lambda: _run(given), given.scene)
    except KeyboardInterrupt:
        print("moraine: converge was stopped (by a signal; a level under way has a checkpoint). Go on by the same command?", file=sys.stderr)
        return STOPPED


if __name__ == "__main__":
    sys.exit(main())
