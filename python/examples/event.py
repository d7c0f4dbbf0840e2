"""How much of the area that an event reached is reached by a run, and how sure that is: from a folder with what is known of the event.

    python3 python/examples/event.py FOLDER --cell METRES [--thickness METRES] [--friction MU] [--xi XI] [--end SECONDS] [--levels N]

FOLDER has the heights (dem.tif or .asc), what broke loose (release.geojson, .gpkg or .csv, with a thickness for each polygon or --thickness) and what was
reached (outline.geojson, .gpkg or .csv, in the system of the heights). Friction and xi are those of Hungr and Evans (1996) for rock avalanches, if none are
given: they are not fitted. The scene, the runs on --levels sizes of cells and overlap.csv go to FOLDER/event, and moraine calibrate may go on from there.
"""
import argparse
import csv
import pathlib
import sys
import tempfile

import moraine
from moraine.number_text import digits, two_digits
from moraine.overlap import Overlap, read_seen

ENDINGS = {"dem": ("tif", "asc"), "release": ("geojson", "gpkg", "csv"), "outline": ("geojson", "gpkg", "csv")}


def file_of(folder, name):
    found = [folder / f"{name}.{ending}" for ending in ENDINGS[name] if (folder / f"{name}.{ending}").is_file()]
    if not found:
        raise moraine.Error(f"{folder} has no {name} (it needs {name}.{', .'.join(ENDINGS[name])}). Is it the right folder?")
    return found[0].resolve()


def scene_of(folder, given):
    """Debris that slides over the model's heights until it rests; maps of which no cell is finer than the coarsest level's."""
    release = {"name": "scar", "material": "debris", "area": str(file_of(folder, "release")), **({"thickness": given.thickness} if given.thickness else {})}
    return {"title": folder.resolve().name, "dimensions": 3, "gravity": [0.0, 0.0, -9.81], "domain": {"cell": given.cell},
            "time": {"end": given.end, "stop": "rest"}, "output": {"interval": given.end / 10},
            "terrain": {"dem": str(file_of(folder, "dem")), "contact": {"law": "voellmy", "friction": given.friction, "xi": given.xi}},
            "hazard": {"cell": 2 * given.cell, "threshold": given.threshold}, "release": [release],
            "material": [{"name": "debris", "law": "drucker-prager", "density": 1900.0, "young": 5.0e6, "poisson": 0.3, "friction_angle": 32.0}]}


def rows_of(study, seen):
    """(cell, Overlap) of each level."""
    return [(level.cell, Overlap(moraine.Run(study.path / level.directory), seen)) for level in study.variants[0].levels]


def told_of(rows):
    """The overlap with its error bar, in words."""
    cells, shares = [cell for cell, _ in rows], [found.share for _, found in rows]
    bar = moraine.estimate(cells, shares)
    if bar.error is None:
        return f"overlap = {shares[-1]:.3f}, {two_digits(abs(shares[-1] - shares[-2]))} from the level before: no error bar ({bar.verdict} on these levels)"
    return f"overlap = {digits(shares[-1], bar.error)} +- {two_digits(bar.error)}, of the cells alone"


def main():
    parser = argparse.ArgumentParser(description="Overlap of a run with the outline of an event.")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--cell", type=float, required=True, help="[m] of the third level: a quarter of the release's thickness or less")
    parser.add_argument("--thickness", type=float, help="of the release [m], where its polygons have none")
    parser.add_argument("--friction", type=float, default=0.1)
    parser.add_argument("--xi", type=float, default=500.0, help="[m/s2]")
    parser.add_argument("--threshold", type=float, default=0.2, help="depth from which a place counts as reached [m]")
    parser.add_argument("--end", type=float, default=300.0, help="[s], if it does not rest before")
    parser.add_argument("--levels", type=int, default=3)
    parser.add_argument("--overwrite", action="store_true", help="begin again, as with another friction")
    given = parser.parse_args()
    output = given.folder / "event"
    try:
        seen, scene = read_seen(file_of(given.folder, "outline")), scene_of(given.folder, given)
        output.mkdir(exist_ok=True)
        moraine.write_scene(scene, output / "scene.toml")
        with tempfile.TemporaryDirectory(prefix="moraine-") as place:  # whether both lie together, before anything is computed
            sets = {"time.end": 0.0, "domain.cell": 2 * given.cell}
            Overlap(moraine.run(output / "scene.toml", pathlib.Path(place) / "start", sets, options=["--device", "cpu", "--no-particles"], progress=False), seen)
        study = moraine.converge(output / "scene.toml", "front,maps.area,maps.max_depth", output / "cells", levels=given.levels, options=["--device", "cpu"],
                                 overwrite=given.overwrite)
        rows = rows_of(study, seen)
        if not rows:
            raise moraine.Error(f"no level of {study.path} has ended (its messages say why). Correct the scene?", study.variants[0].failed or 2)
    except moraine.Error as problem:
        sys.stderr.write(f"event: {problem}\n")
        return problem.code
    with open(output / "overlap.csv", "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(("cell_m", "seen_m2", "computed_m2", "common_m2", "overlap"))
        table.writerows((cell, found.seen, found.computed, found.common, found.share) for cell, found in rows)
    print("cell [m]  seen [m2]  computed [m2]  common [m2]  overlap")
    for cell, found in rows:
        print(f"{cell:8g} {found.seen:10.6g} {found.computed:14.6g} {found.common:12.6g} {found.share:8.3f}")
    print(f"{told_of(rows)}\nResults are in {output}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
