"""Maps over the runs of a study: envelope, mean, quantiles, and the probability that a value is exceeded."""
import pathlib
from typing import Any, Dict, List, Mapping, Sequence, Tuple

import numpy
from numpy.typing import NDArray

from .grids import Grid
from .map_values import laid_on, named_map, one_grid
from .maps import UNITS, map_files
from .results import Run
from .tiff import write_like

QUANTILES = (5, 50, 95)  # [%]


def _statistics(name: str, stack: NDArray[Any], exceed: Sequence[float]) -> Dict[str, Tuple[NDArray[Any], str]]:
    """Maps by the ends of their names, with units. A cell that a run did not reach counts 0 there; of times of arrival what never came is left out."""
    found: Dict[str, Tuple[NDArray[Any], str]] = {}
    unit = UNITS.get(name, "")
    if name == "arrival":
        never = numpy.isnan(stack).all(axis=0)
        first = numpy.where(never, numpy.nan, numpy.nanmin(numpy.where(numpy.isnan(stack), numpy.inf, stack), axis=0))
        share = numpy.isfinite(stack).mean(axis=0)
        return {"earliest": (first, unit), "probability": (numpy.where(share > 0, share, numpy.nan), "")}
    came = (stack > 0).any(axis=0)
    found["envelope"] = stack.max(axis=0), unit
    found["mean"] = stack.mean(axis=0), unit
    for percent in QUANTILES:
        found[f"q{percent:02d}"] = numpy.percentile(stack, percent, axis=0), unit
    for level in exceed:
        found[f"exceeds-{level:g}"] = (stack > level).mean(axis=0), ""
    return {kind: (numpy.where(came & (values > 0), values, numpy.nan), unit) for kind, (values, unit) in found.items()}


def map_statistics(directories: Sequence[pathlib.Path], exceed: Mapping[str, Sequence[float]], folder: pathlib.Path) -> List[Dict[str, Any]]:
    """Writes folder/MAP-KIND.tif of all maps that all runs have; name, kind, file and unit of each. Cells of no value are no-data."""
    runs = [Run(directory) for directory in directories]
    written: List[Dict[str, Any]] = []
    for name, like in map_files(runs[0].path).items():
        if not all(name in map_files(run.path) for run in runs):
            continue
        grids = tuple(named_map(run, name) for run in runs)
        stack = numpy.stack(one_grid(grids))
        if name != "arrival":
            stack = numpy.nan_to_num(stack, nan=0.0)
        for kind, (values, unit) in _statistics(name, stack, exceed.get(name, ())).items():
            tags = {"runs": str(len(runs)), "what": f"{name}: {kind}"}
            file = write_like(folder, f"{name}-{kind}", Grid(values, laid_on(grids), grids[0].cell), unit, like, tags)
            written.append({"map": name, "kind": kind, "file": file.name, "unit": unit})
    return written
