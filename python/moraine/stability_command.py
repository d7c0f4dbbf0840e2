"""moraine stability SCENE.toml [options]: the factor of safety of a slope, with an error bar."""
import argparse
import json
import sys
from typing import Optional, Sequence

from .command_line import Parser
from .factor_of_safety import FILE, stability
from .scenario_command import check_options, stopped_by
from .scenario_file import save_json
from .scene import parse_set
from .slope_result import as_json
from .stability_text import summary
from .verdict import WAY


def parser(prog: str = "moraine stability") -> argparse.ArgumentParser:
    words = Parser("moraine stability inputs/stability.toml --device cpu", prog=prog,
                   description="Divides the strengths of a slope until it fails: the factor between standing and failing, on a cell and on half of it.")
    words.add_argument("scene", metavar="SCENE.toml")
    words.add_argument("--tolerance", type=float, default=0.01, metavar="F", help="width of the bracket between the factor that stands and the one that fails (default: 0.01)")
    words.add_argument("--cell", type=float, metavar="METRES", help="cell of the first level (default: the scene's); the second has half of it")
    words.add_argument("--levels", type=int, default=2, metavar="N", help="1: on one cell alone, without an error bar (default: 2)")
    words.add_argument("--settle", type=float, default=1.0, metavar="F", help="factor at which it first comes to rest; below 1 for a slope that fails at 1 (default: 1)")
    words.add_argument("--height", type=float, metavar="METRES", help="of the slope, by which times and ways are measured (default: that of the soil along gravity)")
    words.add_argument("--way", type=float, default=WAY, metavar="SHARE", help="of the height, beyond which a slope that still slides has failed (default: 0.05)")
    words.add_argument("--keep", action="append", default=[], metavar="NAME", help="a material whose strength stays; again for more")
    words.add_argument("--softening", action="store_true", help="take clay that softens: its factor depends on the cell")
    words.add_argument("--set", dest="sets", action="append", default=[], metavar="KEY=VALUE", help="change a key of the scene; again for more")
    words.add_argument("--jobs", type=int, metavar="N", help="runs at a time (default: what the cores allow)")
    words.add_argument("--ranks", type=int, metavar="N", help="start mpirun with so many ranks for each run")
    words.add_argument("--threads", type=int, default=1, metavar="N", help="of each rank (default: 1)")
    words.add_argument("--output", metavar="DIR", help="where results go, and what is gone on with (default: runs/stability-SCENE)")
    words.add_argument("--overwrite", action="store_true", help="begin again")
    for name in ("device", "transport", "partitioner"):
        words.add_argument(f"--{name}", metavar="NAME", help="as in moraine run")
    words.add_argument("--allow-code", action="store_true", help="as in moraine run")
    words.add_argument("--quiet", action="store_true", help="no progress")
    return words


def _run(given: argparse.Namespace) -> int:
    options = check_options(given, "stability")
    found = stability(given.scene, given.output, given.tolerance, given.cell, given.levels, given.settle, given.height, given.way, given.keep, given.softening,
                      dict(map(parse_set, given.sets)), given.jobs, given.ranks, given.threads, options, given.overwrite,
                      lambda line: None if given.quiet else print(line, file=sys.stderr, flush=True))
    print(summary(found))
    from .stability_page import write_page, write_pictures
    write_pictures(found)
    page = write_page(found)
    save_json(found.path / FILE, {**json.loads((found.path / FILE).read_text()), **as_json(found)})  # with the names of the pictures
    pictures = [level.picture for level in found.levels if level.picture]
    print(f"Results are in {found.path}: {', '.join([FILE, page.name, *pictures])}")
    return 0


def main(words: Optional[Sequence[str]] = None) -> int:
    given = parser().parse_args(words)
    return stopped_by("stability", lambda: _run(given), given.scene)


if __name__ == "__main__":
    sys.exit(main())
