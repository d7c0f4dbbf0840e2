"""Columns of a run's tables by name, with a unit or without."""
import difflib
from typing import Any, List, Mapping

from numpy.typing import NDArray

from .errors import Error
from .records import Table
from .results import Run
from .runout import OF_PARTICLES

RECORDS = {"structure": "structures.csv", "gauges": "gauges.csv", "sections": "sections.csv"}
UNITS = ("m", "s", "N", "J", "kg", "Pa", "m_s", "N_m", "N_s", "kg_m_s", "m3", "m3_s", "rad", "rad_s")


def column_of(table: Table, name: str, where: str, ahead: str = "") -> NDArray[Any]:
    """The column of that name, or of it and a unit; `ahead`: what the columns that count begin with."""
    names = [column[len(ahead):] for column in table if column.startswith(ahead)]
    fitting = [name] if name in names else [column for column in names if column.startswith(name + "_") and column[len(name) + 1:] in UNITS]
    if len(fitting) != 1 or table[ahead + fitting[0]].dtype.kind != "f":
        near = difflib.get_close_matches(name, [c for c in names if table[ahead + c].dtype.kind == "f"] + ([] if ahead else list(OF_PARTICLES)), 1, 0.4)
        raise Error(f"--quantity {name} is not there (no such column in {where}). Did you mean {near[0] if near else 'front'}?")
    return table[ahead + fitting[0]]


def names_of(run: Run, scene: Mapping[str, Any], kind: str) -> List[str]:
    """Structures, gauges or sections of a run."""
    if kind == "structure":
        return [item.get("name", "") for item in scene.get("structure", [])]
    if not (run.path / RECORDS[kind]).is_file():
        return []
    end, table = ("_depth_m", run.gauges) if kind == "gauges" else ("_volume_m3", run.sections)
    return [column[: -len(end)] for column in table if column.endswith(end)]
