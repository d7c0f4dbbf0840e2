"""moraine picture RUN_DIR [options]: pictures of a run, and of its maps."""
import argparse
import pathlib
import sys
from typing import List, Optional, Sequence

from .command_line import Parser, exit_code
from .curve_plot import write_curve
from .curves import band_of, parse_curve, read_data
from .errors import Error
from .drawing import draw
from .results import Run


def _numbers(text: str) -> List[float]:
    return [float(word) for word in text.split(",")]


def parser(prog: str = "moraine picture") -> argparse.ArgumentParser:
    words = Parser("moraine picture runs/slurry_runout --times 0,1", prog=prog,
                   description="Pictures of a run: PNG at chosen times, GIF, MP4 where ffmpeg is, and its hazard maps over the shaded ground.")
    words.add_argument("run", metavar="RUN_DIR", help="what moraine run wrote; it may be under way")
    words.add_argument("--field", "--quantity", metavar="NAME",
                       help="speed, pressure, plastic_shear_strain, depth or rank of particles, or a map: max_depth, arrival, ...; maps: all maps (default: speed, and all maps)")
    words.add_argument("--times", "--time", type=_numbers, metavar="T,T,...", help="[s] (default: five, from start to end)")
    words.add_argument("--line", type=_numbers, metavar="X,X", help="profile of the depth between two x, in 3-D along X,Y,X,Y [m] (default: along x)")
    words.add_argument("--curve", metavar="structure.NAME.Y/X", help="instead: a column of a structure over another, as force_y/displacement_y, as SVG and CSV")
    words.add_argument("--with", dest="data", metavar="FILE.csv", help="a curve of your own beside it: a header and rows of x,y")
    words.add_argument("--sheet", action="store_true", help="all times in one picture")
    words.add_argument("--scene", metavar="FILE", help="walls and structures, for a run that has no scene.json")
    words.add_argument("--terrain", metavar="FILE", help="model of the ground under maps, where that of the scene is not found")
    words.add_argument("--output", metavar="DIR", help="default: RUN_DIR/pictures")
    words.add_argument("--no-animation", action="store_true", help="no GIF and MP4")
    return words


def _curve(given: argparse.Namespace) -> int:
    run, name = Run(given.run), parse_curve(given.curve)
    folder = pathlib.Path(given.output) if given.output else run.path / "pictures"
    for file in write_curve(folder, name, band_of([run], [1.0], name), read_data(pathlib.Path(given.data)) if given.data else None):
        print(file, file=sys.stderr)
    return 0


def main(words: Optional[Sequence[str]] = None) -> int:
    given = parser().parse_args(words)

    def work() -> int:
        if given.data and not given.curve:
            raise Error("--with beside no curve (it is laid over one). Add --curve structure.NAME.force_y/displacement_y?")
        if given.curve:
            return _curve(given)
        draw(given.run, given.field, given.times, given.scene, given.output, not given.no_animation,
             lambda line: print(line, file=sys.stderr, flush=True), given.line, given.sheet, given.terrain)
        return 0

    return exit_code(work, given.run)


if __name__ == "__main__":
    sys.exit(main())
