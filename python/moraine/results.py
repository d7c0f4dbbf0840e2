"""A run that was made: its directory, read piece by piece when it is asked for."""
import functools
import pathlib
from typing import Any, Dict, List, Union

from .errors import Error
from .grids import Grid, read_grid
from .maps import map_files
from .particles import ParticleSeries
from .records import Table, read_summary, read_table, rows_where


class Run:
    """The results in `directory`. Nothing is read before it is asked for, and then once.

    Raises Error if there is no run. A run that still goes on can be read: what it has not written yet raises Error.
    """

    def __init__(self, directory: Union[str, pathlib.Path]) -> None:
        self.path = pathlib.Path(directory)
        if not self.path.is_dir():
            raise Error(f"{directory} is not a run (no such directory). Is the path right?")
        if not (self.path / "history.csv").is_file():
            raise Error(f"{directory} is not a run (it has no history.csv). Name the directory that --output named?")

    def __repr__(self) -> str:
        return f"moraine.Run({str(self.path)!r})"

    @functools.cached_property
    def summary(self) -> Dict[str, Any]:
        """Totals of the run: times, energies, front, `state_hash` ...; there when the run has ended."""
        return read_summary(self.path / "summary.json")

    @functools.cached_property
    def history(self) -> Table:
        """A row per output time: mass, momentum, energies, front, speeds; each column (outputs,)."""
        return read_table(self.path / "history.csv")

    @functools.cached_property
    def balance(self) -> Table:
        """A row per imbalance check: load, halo, migration and seconds by phase; each column (checks,)."""
        return read_table(self.path / "balance.csv")

    @functools.cached_property
    def structures(self) -> Dict[str, Table]:
        """What each structure felt and did, by its name: force [N], moment [N m], displacement [m] and so on.

        Empty where the scene has no structures.
        """
        path = self.path / "structures.csv"
        if not path.is_file():
            return {}
        table = read_table(path)
        names = dict.fromkeys(table["structure"].tolist())  # in the order of the scene
        return {name: rows_where(table, "structure", name) for name in names}

    @functools.cached_property
    def maps(self) -> Dict[str, Grid]:
        """Hazard maps by their names: values (rows, columns) from the south and west on, in the units of docs/terrain.md.

        Empty where the scene has no [hazard]. GeoTIFF wants Pillow.
        """
        return {name: read_grid(file) for name, file in map_files(self.path).items()}

    @functools.cached_property
    def gauges(self) -> Table:
        """A row per sample of the maps: NAME_depth_m, NAME_speed_m_s, NAME_pressure_Pa of each gauge; each column (samples,)."""
        return read_table(self.path / "gauges.csv")

    @functools.cached_property
    def sections(self) -> Table:
        """A row per sample: discharge [m3/s], volume [m3] and mass [kg] that passed each section; each column (samples,)."""
        return read_table(self.path / "sections.csv")

    @functools.cached_property
    def dimensions(self) -> int:
        """2 (plane strain, y is up) or 3 (z is up)."""
        return 3 if "centre_z_m" in self.history else 2

    @functools.cached_property
    def particles(self) -> ParticleSeries:
        """The particles at the output times. Raises Error where the run had --no-particles."""
        return ParticleSeries(self.path / "particles.vtkhdf", self.dimensions)

    @functools.cached_property
    def cells(self) -> ParticleSeries:
        """Means over the particles of each cell, where the run had output.fields_on = "cells": read like particles."""
        return ParticleSeries(self.path / "cells.vtkhdf", self.dimensions)

    @property
    def checkpoints(self) -> List[pathlib.Path]:
        """Checkpoints in the order of their steps."""
        return sorted(self.path.glob("checkpoint-*.h5"))
