"""Records of a run: tables (history.csv, balance.csv, structures.csv) and the summary."""
import csv
import json
import pathlib
from typing import Any, Dict, List, Union

import numpy
from numpy.typing import NDArray

from .errors import Error

Table = Dict[str, NDArray[Any]]
"""Columns by name, all of one length (rows,): numbers as float arrays, words as arrays of str."""


def _column(values: List[str]) -> NDArray[Any]:
    try:
        return numpy.array(values, dtype=float)
    except ValueError:
        return numpy.array(values, dtype=str)


def read_table(path: Union[str, pathlib.Path]) -> Table:
    """Columns of a CSV, each of shape (rows,); a unit is the end of its column's name (`front_m`: metres).

    A last line that a stopped run left half written is left out. Raises Error if there is no such file, or it is empty.

    >>> import tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "history.csv"
    >>> _ = file.write_text("time_s,front_m,reason\\n0,10,start\\n1,12.5,end\\n2,1")
    >>> table = read_table(file)
    >>> table["front_m"], table["reason"]
    (array([10. , 12.5]), array(['start', 'end'], dtype='<U5'))
    """
    path = pathlib.Path(path)
    if not path.is_file():
        raise Error(f"{path} cannot be read (no such file). Is {path.parent} the directory of a run that wrote it?")
    try:
        with open(path, newline="", encoding="utf-8") as file:
            text = file.read()
        rows = list(csv.reader(text[: text.rfind("\n") + 1].splitlines()))
    except (ValueError, csv.Error) as wrong:
        raise Error(f"{path} is damaged ({wrong}). Run it again?") from None
    if not rows:
        raise Error(f"{path} is empty (it has no line with names). Did the run end before its first output?")
    names, rows = rows[0], [row for row in rows[1:] if len(row) == len(rows[0])]
    return {name: _column([row[k] for row in rows]) for k, name in enumerate(names)}


def rows_where(table: Table, column: str, value: Any) -> Table:
    """The rows of a table in which a column has that value; the column itself stays.

    >>> rows_where({"structure": numpy.array(["pipe", "rod"]), "force_x_N": numpy.array([1.0, 2.0])}, "structure", "rod")
    {'structure': array(['rod'], dtype='<U4'), 'force_x_N': array([2.])}
    """
    chosen = table[column] == value
    return {name: values[chosen] for name, values in table.items()}


def read_summary(path: Union[str, pathlib.Path]) -> Dict[str, Any]:
    """summary.json as a dict. Raises Error if it is not there (it is written when a run ends) or torn."""
    path = pathlib.Path(path)
    if not path.is_file():
        raise Error(f"{path} cannot be read (no such file). Has the run ended?")
    try:
        found: Dict[str, Any] = json.loads(path.read_text())
        return found
    except ValueError as wrong:
        raise Error(f"{path} cannot be read ({wrong}). Was the run stopped while it wrote it?") from None
