"""Pictures of a run: PNG at chosen times and an animated GIF.

    python -m moraine.picture RUN_DIR [--field speed|pressure|depth] [--times 0,2,8] [--scene FILE] [--output DIR]
"""
import argparse
import pathlib
import sys
from typing import Any, Callable, List, Mapping, Optional, Sequence

import numpy

from .errors import Error
from .results import Run
from .scene import Path, read_scene

MOST_FRAMES = 60  # of an animation: a longer one is a large file that says no more


def _chosen(run: Run, times: Optional[Sequence[float]]) -> List[int]:
    """Outputs nearest to the times [s]; without times five, evenly from start to end."""
    there = run.particles.times
    wanted = numpy.linspace(there[0], there[-1], 5) if times is None else times
    for time in wanted:
        if not there[0] - 1e-9 <= time <= there[-1] * (1 + 1e-9):
            raise Error(f"time {time:g} s cannot be drawn (the run's outputs are from {there[0]:g} to {there[-1]:g} s). "
                        "Choose times between?")
    return sorted({run.particles.nearest(time) for time in wanted})


def draw(directory: Path, field: str = "speed", times: Optional[Sequence[float]] = None, scene: Optional[Path] = None,
         output: Optional[Path] = None, animate: bool = True, told: Callable[[str], None] = lambda line: None) -> List[pathlib.Path]:
    """Draws a run into `output` (default: `directory`/pictures) and returns the files: FIELD-0.png, ... and FIELD.gif.

    field: speed, pressure or depth; times [s] (default: five from start to end), of each the nearest output is drawn, and the
    animation has the outputs between the first and the last, at most 60; scene: the run's scene file, for walls and
    structures, which are not drawn without it; told: called with a line after each file.

    Raises Error where there is no matplotlib, the run has not the field, or a time is not of the run.
    """
    try:
        from matplotlib.animation import PillowWriter
        from .frames import FIELDS, NEEDS, Frames
    except ImportError as missing:
        raise Error(f"pictures cannot be drawn ({missing}). pip install matplotlib?") from None
    from .surroundings import Surroundings
    run = Run(directory)
    if field not in FIELDS:
        raise Error(f"field {field!r} cannot be drawn (it is not one of {', '.join(FIELDS)}). Did you mean speed?")
    if len(run.particles) == 0:
        raise Error(f"{directory} has no output yet (its particles.vtkhdf is empty). Wait for the first?")
    run.particles.read(0, NEEDS[field])  # a missing field is said before anything is drawn
    around: Optional[Mapping[str, Any]] = read_scene(scene) if scene else None
    chosen = _chosen(run, times)
    every = list(range(chosen[0], chosen[-1] + 1))
    moving = sorted({every[int(k)] for k in numpy.linspace(0, len(every) - 1, min(len(every), MOST_FRAMES))})
    animate = animate and len(moving) > 1
    told(f"{directory}: {len(chosen)} pictures" + (f", {len(moving)} frames" if animate else ""))
    title = (run.summary.get("title") or run.summary["scene"]) if (run.path / "summary.json").exists() else ""
    frames = Frames(run, sorted({*chosen, *(moving if animate else [])}), field, Surroundings(run, around), title)
    folder = pathlib.Path(output) if output else run.path / "pictures"
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for k, number in enumerate(chosen):
        files.append(folder / f"{field}-{k}.png")
        frames.figure(number).savefig(files[-1], dpi=100)
        told(f"{files[-1]}  t = {run.particles.times[number]:.2f} s")
    if animate:
        files.append(folder / f"{field}.gif")
        _animate(frames, moving, files[-1], PillowWriter, told)
    return files


def _animate(frames: Any, ks: Sequence[int], path: pathlib.Path, pillow: Any, told: Callable[[str], None]) -> None:
    """Each output is a frame for 1/8 s; the last stays for a second."""
    writer = pillow(fps=8)
    shown = [*ks, *[ks[-1]] * 8]
    for done, k in enumerate(shown):
        if done == 0 or k != shown[done - 1]:
            figure = frames.figure(k)
            figure.set_dpi(80)
        if done == 0:
            writer.setup(figure, str(path), dpi=80)
        writer.fig = figure
        writer.grab_frame()
        if (done + 1) % 10 == 0 and done + 1 < len(ks):
            told(f"{path}  frame {done + 1} of {len(ks)}")
    writer.finish()
    told(f"{path}  {len(ks)} frames")


def _times(text: str) -> List[float]:
    return [float(word) for word in text.split(",")]


def main(words: Optional[Sequence[str]] = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m moraine.picture", description="Pictures of a run, PNG and GIF.")
    parser.add_argument("run", metavar="RUN_DIR")
    parser.add_argument("--field", default="speed", metavar="NAME", help="speed, pressure or depth (default: speed)")
    parser.add_argument("--times", type=_times, metavar="T,T,...", help="[s] (default: five, from start to end)")
    parser.add_argument("--scene", metavar="FILE", help="the run's scene: draws walls and structures")
    parser.add_argument("--output", metavar="DIR", help="default: RUN_DIR/pictures")
    parser.add_argument("--no-animation", action="store_true", help="no GIF")
    given = parser.parse_args(words)
    try:
        draw(given.run, given.field, given.times, given.scene, given.output, not given.no_animation,
             lambda line: print(line, file=sys.stderr, flush=True))
    except Error as wrong:
        print(f"moraine: {wrong}", file=sys.stderr)
        return wrong.code
    return 0


if __name__ == "__main__":
    sys.exit(main())
