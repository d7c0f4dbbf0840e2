"""Moraine from Python: read runs, draw them, write and check scenes, run and wait.

    run = moraine.run("inputs/slurry_runout.toml", "runs/slurry", sets={"time.end": 2.0})
    run.history["front_m"]                  # (outputs,) [m]
    last = run.particles[-1]                # one output time
    last.position, last["pressure"]         # (N, 2) [m], (N,) [Pa]

All lengths are in m, times in s, masses in kg (per metre of thickness in plane strain). docs/python.md has more.
"""
from .calibration import calibrate
from .calibration_data import Calibration
from .columns import depth_at, depth_profile, spacing
from .convergence import converge
from .errors import Error
from .factor_of_safety import stability
from .particles import Particles, ParticleSeries
from .program import Check, check, find_program, run
from .records import Table, read_summary, read_table
from .results import Run
from .richardson import Estimate, estimate
from .scenario_data import Scenarios
from .scenarios import run_study
from .scene import read_scene, write_scene
from .slope_result import FactorOfSafety
from .study import Study
from .toml_text import to_toml
from .vtk import to_pyvista
from .waiting import Progress

__all__ = ["Calibration", "Check", "Error", "Estimate", "FactorOfSafety", "Particles", "ParticleSeries", "Progress", "Run", "Scenarios", "Study", "Table", "calibrate", "check", "converge",
           "depth_at", "depth_profile", "estimate", "find_program", "read_scene", "read_summary", "read_table", "run", "run_study", "spacing", "stability", "to_pyvista",
           "to_toml", "write_scene"]
