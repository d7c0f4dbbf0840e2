"""Pictures of a run: PNG at chosen times, an animated GIF, and an MP4 where ffmpeg is.

    moraine picture RUN_DIR [--field speed|pressure|depth|rank] [--times 0,2,8] [--output DIR]    (or python -m moraine.picture)
"""
import argparse
import csv
import pathlib
import sys
from typing import Any, Callable, List, Mapping, Optional, Sequence, Tuple

import numpy

from .errors import Error
from .results import Run
from .scene import Path, read_scene
from .surroundings import Surroundings, surroundings_of

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


def _line(run: Run, line: Optional[Sequence[float]]) -> Optional[Tuple[List[float], List[float]]]:
    """Start and end of a line given as x0, x1 in 2-D and x0, y0, x1, y1 in 3-D."""
    if line is None:
        return None
    half = run.dimensions - 1
    start, end = list(line[:half]), list(line[half:])
    if len(line) != 2 * half or start == end or not numpy.isfinite(line).all():
        raise Error(f"no profile along {','.join(f'{x:g}' for x in line)} (a line in {run.dimensions}-D is "
                    f"{'x0,x1' if half == 1 else 'x0,y0,x1,y1'}, from one place to another). Correct --line?")
    return start, end


def draw(directory: Path, field: str = "speed", times: Optional[Sequence[float]] = None, scene: Optional[Path] = None,
         output: Optional[Path] = None, animate: bool = True, told: Callable[[str], None] = lambda line: None,
         line: Optional[Sequence[float]] = None, sheet: bool = False) -> List[pathlib.Path]:
    """Draws a run into `output` (default: `directory`/pictures) and returns the files: FIELD-0.png, ..., FIELD.gif and FIELD.mp4.

    field: speed, pressure, depth or rank; times [s] (default: five from start to end), of each the nearest output is drawn, and
    the animation has the outputs between the first and the last, at most 60; scene: the scene file, for walls and structures of a
    run that has no scene.json; line: of the profile, x0, x1 or in 3-D x0, y0, x1, y1 [m], which is written as FIELD-profile.csv
    too; sheet: one picture FIELD-sheet.png of all times; told: called with a line after each file.

    Raises Error where there is no matplotlib, the run has not the field, or a time is not of the run.
    """
    try:
        from .frames import Frames
    except ImportError as missing:
        raise Error(f"pictures cannot be drawn ({missing}). pip install matplotlib?") from None
    from .fields import field_of
    run, needs = Run(directory), field_of(field).needs
    if len(run.particles) == 0:
        raise Error(f"{directory} has no output yet (its particles.vtkhdf is empty). Wait for the first?")
    run.particles.read(0, needs)  # a missing field is said before anything is drawn
    around: Optional[Mapping[str, Any]] = read_scene(scene) if scene else surroundings_of(run)
    chosen, along = _chosen(run, times), _line(run, line)
    every = list(range(chosen[0], chosen[-1] + 1))
    moving = sorted({every[int(k)] for k in numpy.linspace(0, len(every) - 1, min(len(every), MOST_FRAMES))})
    animate = animate and not sheet and len(moving) > 1
    told(f"{directory}: {'one picture' if sheet or len(chosen) == 1 else f'{len(chosen)} pictures'}" + (f", {len(moving)} frames" if animate else ""))
    title = (run.summary.get("title") or run.summary.get("scene", "")) if (run.path / "summary.json").exists() else ""
    frames = Frames(run, sorted({*chosen, *(moving if animate else [])}), field, Surroundings(run, around), title, along)
    folder = pathlib.Path(output) if output else run.path / "pictures"
    folder.mkdir(parents=True, exist_ok=True)
    files = _stills(frames, chosen, folder, field, sheet, told)
    if along:
        files.append(_profiles(frames, chosen, folder / f"{field}-profile.csv"))
    if animate:
        from .animation import animate as write
        files += write(frames, moving, folder / field, told)
    return files


def _stills(frames: Any, chosen: List[int], folder: pathlib.Path, field: str, sheet: bool, told: Callable[[str], None]) -> List[pathlib.Path]:
    from .animation import save
    if sheet:
        file = folder / f"{field}-sheet.png"
        save(frames.sheet(chosen), file)
        told(f"{file}  t = " + ", ".join(f"{frames.run.particles.times[k]:.2f}" for k in chosen) + " s")
        return [file]
    files = []
    for place, k in enumerate(chosen):
        files.append(folder / f"{field}-{place}.png")
        save(frames.figure(k), files[-1])
        told(f"{files[-1]}  t = {frames.run.particles.times[k]:.2f} s  ({place + 1} of {len(chosen)})")
    return files


def _profiles(frames: Any, chosen: List[int], path: pathlib.Path) -> pathlib.Path:
    with open(path, "w", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["time_s", "distance_m", "depth_m"])
        for k in chosen:
            particles = frames.read(k, [])
            rows.writerows((particles.time, x, depth) for x, depth in zip(*frames.profile(particles)))
    return path


def _numbers(text: str) -> List[float]:
    return [float(word) for word in text.split(",")]


class Parser(argparse.ArgumentParser):
    def error(self, message: str) -> Any:
        print(f"moraine: {self.prog} ({message}). Try moraine picture runs/slurry_runout --times 0,1?", file=sys.stderr)
        sys.exit(2)


def parser(prog: str = "moraine picture") -> argparse.ArgumentParser:
    words = Parser(prog=prog, description="Pictures of a run: PNG at chosen times, GIF, and MP4 where ffmpeg is.")
    words.add_argument("run", metavar="RUN_DIR", help="what moraine run wrote; it may be under way")
    words.add_argument("--field", "--quantity", default="speed", metavar="NAME", help="speed, pressure, depth or rank (default: speed)")
    words.add_argument("--times", "--time", type=_numbers, metavar="T,T,...", help="[s] (default: five, from start to end)")
    words.add_argument("--line", type=_numbers, metavar="X,X", help="profile of the depth between two x, in 3-D along X,Y,X,Y [m] (default: along x)")
    words.add_argument("--sheet", action="store_true", help="all times in one picture")
    words.add_argument("--scene", metavar="FILE", help="walls and structures, for a run that has no scene.json")
    words.add_argument("--output", metavar="DIR", help="default: RUN_DIR/pictures")
    words.add_argument("--no-animation", action="store_true", help="no GIF and MP4")
    return words


def main(words: Optional[Sequence[str]] = None) -> int:
    given = parser().parse_args(words)
    try:
        draw(given.run, given.field, given.times, given.scene, given.output, not given.no_animation,
             lambda line: print(line, file=sys.stderr, flush=True), given.line, given.sheet)
    except Error as wrong:
        print(f"moraine: {wrong}", file=sys.stderr)
        return wrong.code
    except OSError as wrong:
        print(f"moraine: cannot write or read {wrong.filename or given.run} ({wrong.strerror or wrong}). Is the disk full or read-only?", file=sys.stderr)
        return 4
    return 0


if __name__ == "__main__":
    sys.exit(main())
