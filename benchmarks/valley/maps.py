"""Maps of a run or of a peer as rows of numbers, and how two of them agree. Python's standard library alone."""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tests" / "program"))
import geotiff  # noqa: E402


def read_grid(path):
    """Rows of an ESRI ASCII grid from north to south, and its header in lower case."""
    header, rows = {}, []
    for line in pathlib.Path(path).read_text().splitlines():
        words = line.split()
        if words and words[0][0].isalpha() and words[0].lower() != "nan":
            header[words[0].lower()] = float(words[1])
        elif words:
            rows.append([float(word) for word in words])
    return rows, header


def write_grid(path, rows, side, corner=(0.0, 0.0)):
    """An ESRI ASCII grid whose first cell's lower corner is `corner` [m]; rows from north to south."""
    lines = [f"ncols {len(rows[0])}", f"nrows {len(rows)}", f"xllcorner {corner[0]:.10g}",
             f"yllcorner {corner[1]:.10g}", f"cellsize {side:.10g}", "NODATA_value -9999"]
    pathlib.Path(path).write_text("\n".join(lines + [" ".join(f"{z:.6g}" for z in row) for row in rows]) + "\n")


def read_map(run, name):
    """Rows of a map of a run, from north to south."""
    folder = pathlib.Path(run) / "maps"
    if (folder / f"{name}.tif").exists():
        return geotiff.read(folder / f"{name}.tif")[0]
    return read_grid(folder / f"{name}.asc")[0]


def largest(rows):
    return max(max(row) for row in rows)


def overlap(one, other):
    """Cells that both have over those that one of them has; one, other: sets."""
    return len(one & other) / len(one | other) if one | other else 1.0
