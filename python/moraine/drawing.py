"""Pictures of a run: PNG at chosen times, an animated GIF, and an MP4 where ffmpeg is."""
import csv
import pathlib
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


def draw(directory: Path, field: Optional[str] = "speed", times: Optional[Sequence[float]] = None, scene: Optional[Path] = None,
         output: Optional[Path] = None, animate: bool = True, told: Callable[[str], None] = lambda line: None,
         line: Optional[Sequence[float]] = None, sheet: bool = False, terrain: Optional[Path] = None) -> List[pathlib.Path]:
    """Draws a run into `output` (default: `directory`/pictures) and returns the files: FIELD-0.png, ..., FIELD.gif and FIELD.mp4.

    field: speed, pressure, plastic_shear_strain, depth or rank; a map of the run, as max_depth, which becomes map-max_depth.png; "maps", all of these;
    None: speed, and all maps there are. times [s] (default: five from start to end), of each the nearest output is drawn, and
    the animation has the outputs between the first and the last, at most 60; scene: the scene file, for walls and structures of a
    run that has no scene.json; line: of the profile, x0, x1 or in 3-D x0, y0, x1, y1 [m], which is written as FIELD-profile.csv
    too; sheet: one picture FIELD-sheet.png of all times; terrain: the model of the ground under maps, where that of the scene is
    not found; told: called with a line after each file.

    Raises Error where there is no matplotlib, the run has not the field, or a time is not of the run.
    """
    try:
        from .frames import Frames
    except ImportError as missing:
        raise Error(f"pictures cannot be drawn ({missing}). pip install matplotlib?") from None
    from .fields import FIELDS
    run, folder = Run(directory), pathlib.Path(output) if output else pathlib.Path(directory) / "pictures"
    around: Optional[Mapping[str, Any]] = read_scene(scene) if scene else surroundings_of(run)
    title = _title(run, around)
    files = _maps(run, field, folder, terrain, title, told)
    if files and not (field in FIELDS if field else (run.path / "particles.vtkhdf").exists()):
        return files
    field, count = field or "speed", len(run.particles)
    if count == 0:
        raise Error(f"{directory} has no output yet (its particles.vtkhdf is empty). Wait for the first?")
    _check(run, field)
    chosen, along = _chosen(run, times), _line(run, line)
    every = list(range(chosen[0], chosen[-1] + 1))
    moving = sorted({every[int(k)] for k in numpy.linspace(0, len(every) - 1, min(len(every), MOST_FRAMES))})
    animate = animate and not sheet and len(moving) > 1
    told(f"{directory}: {'one picture' if sheet or len(chosen) == 1 else f'{len(chosen)} pictures'}" + (f", {len(moving)} frames" if animate else ""))
    frames = Frames(run, sorted({*chosen, *(moving if animate else [])}), field, Surroundings(run, around), title, along)
    folder.mkdir(parents=True, exist_ok=True)
    files += _stills(frames, chosen, folder, field, sheet, told)
    if along:
        files.append(_profiles(frames, chosen, folder / f"{field}-profile.csv"))
    if animate:
        from .animation import animate as write
        files += write(frames, moving, folder / field, told)
    return files


def _title(run: Run, around: Optional[Mapping[str, Any]]) -> str:
    known: Mapping[str, Any] = run.summary if (run.path / "summary.json").exists() else around or {}
    return str(known.get("title") or known.get("scene", ""))


def _check(run: Run, field: str) -> None:
    """A missing field is said before anything is drawn."""
    from .fields import field_of
    run.particles.read(0, field_of(field).needs)


def _maps(run: Run, field: Optional[str], folder: pathlib.Path, terrain: Optional[Path], title: str, told: Callable[[str], None]) -> List[pathlib.Path]:
    """Files of the maps that a field stands for: those of a run if it is None or "maps", one by its name, else none."""
    from .maps import KINDS, draw_maps, map_files
    there = list(map_files(run.path))
    if field == "maps" and not there:
        raise Error(f"{run.path} has no maps (there is none in its folder maps). Has its scene [hazard], and the run an output?")
    names = there if field in (None, "maps") else [field] if field in KINDS or field in there else []
    return draw_maps(run.path, names, folder, pathlib.Path(terrain) if terrain else None, title, told) if names else []


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
