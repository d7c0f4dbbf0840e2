"""Maps of a run: what [hazard] of a scene writes into RUN_DIR/maps, as pictures over the ground."""
import dataclasses
import json
import pathlib
from typing import Any, Dict, List, Mapping, Optional, Tuple

import numpy
from numpy.typing import NDArray

from .errors import Error
from .grids import Grid, read_grid

#: label and colours of the maps that a run writes; others are drawn under their names. Pressures are drawn in kPa.
KINDS: Dict[str, Tuple[str, str]] = {
    "max_depth": ("largest depth [m]", "YlGnBu"),
    "max_speed": ("largest speed [m/s]", "YlOrRd"),
    "max_pressure": ("largest pressure [kPa]", "YlOrRd"),
    "max_momentum_flux": ("largest momentum flux [m3/s2]", "YlOrRd"),
    "arrival": ("time of arrival [s]", "viridis_r"),
    "deposit": ("depth at the end [m]", "YlOrBr"),
    "max_thickness": ("largest thickness normal to the ground [m]", "YlGnBu"),
    "deposit_thickness": ("thickness at the end, normal to the ground [m]", "YlOrBr"),
}

#: of their values
UNITS = {"max_depth": "m", "max_speed": "m/s", "max_pressure": "Pa", "max_momentum_flux": "m3/s2", "arrival": "s", "deposit": "m",
         "max_thickness": "m", "deposit_thickness": "m"}


def map_files(run: pathlib.Path) -> Dict[str, pathlib.Path]:
    """Maps of a run by name, in the order of KINDS; of two files of a name the .asc."""
    found = {path.stem: path for ending in ("tif", "asc") for path in sorted((run / "maps").glob(f"*.{ending}"))}
    return {name: found[name] for name in [*[k for k in KINDS if k in found], *[k for k in found if k not in KINDS]]}


def ground_of(run: pathlib.Path, given: Optional[pathlib.Path] = None) -> Optional[Grid]:
    """The model of the ground: the file that is given, else that of scene.json, if it is still there."""
    if given:
        return read_grid(given)
    try:
        scene: Mapping[str, Any] = json.loads((run / "scene.json").read_text(encoding="utf-8"))
        named = next(s["file"] for s in scene["structure"] if s.get("shape") == "ground")
    except (OSError, ValueError, LookupError, StopIteration, TypeError, AttributeError):
        return None
    for place in (pathlib.Path(), run, *run.resolve().parents[:3]):
        if (place / named).is_file():
            return read_grid(place / named)
    return None


def reached_by(files: Mapping[str, pathlib.Path], grids: Mapping[str, Grid], name: str) -> NDArray[Any]:
    """Cells that the flow reached: those with a time in the map `arrival` where there is one, else those of the map that are above 0."""
    arrival = grids.get("arrival") or (read_grid(files["arrival"]) if "arrival" in files else None)
    values = grids[name].values
    if arrival is None or arrival.values.shape != values.shape:
        reached: NDArray[Any] = numpy.isfinite(values) & (values > 0)
    else:
        reached = numpy.isfinite(arrival.values)
    return reached


def drawn(name: str, grid: Grid) -> Grid:
    """The map in the unit of its label."""
    return dataclasses.replace(grid, values=grid.values / 1e3) if KINDS.get(name, ("",))[0].endswith("[kPa]") else grid


def draw_maps(run: pathlib.Path, names: List[str], folder: pathlib.Path, terrain: Optional[pathlib.Path], title: str,
              told: Any) -> List[pathlib.Path]:
    """Maps of a run as folder/map-NAME.png; returns the files. `told` is called with a line after each."""
    from .animation import save
    from .map_figure import draw_map
    files = map_files(run)
    folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        if name not in files:
            raise Error(f"{run} has no map {name} (it has {', '.join(files) or 'none'}). Does hazard.maps of the scene name it?")
    ground, written = ground_of(run, terrain), []
    if ground is None:
        told("maps are drawn without the ground: its model was not found; --terrain FILE names it")
    for name in names:
        grid = read_grid(files[name])
        written.append(folder / f"map-{name}.png")
        save(draw_map(*KINDS.get(name, (name, "viridis")), drawn(name, grid), reached_by(files, {name: grid}, name), ground, title), written[-1])
        told(str(written[-1]))
    return written
