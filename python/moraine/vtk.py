"""Particles for PyVista."""
from typing import Any

import numpy

from .errors import Error
from .particles import Particles


def to_pyvista(particles: Particles) -> Any:
    """A pyvista.PolyData of N points [m] with the particles' fields; 2-D particles lie at z = 0.

    Raises Error where PyVista is not installed.
    """
    try:
        import pyvista
    except ImportError as missing:
        raise Error(f"there is no PyVista ({missing}). pip install pyvista?") from None
    points = numpy.zeros((len(particles), 3))
    points[:, : particles.dimensions] = particles.position
    cloud = pyvista.PolyData(points)
    for name, values in particles.fields.items():
        if values.ndim == 2 and values.shape[1] == 2:  # VTK takes an array of two columns for no vector
            values = numpy.column_stack([values, numpy.zeros(len(values))])
        cloud.point_data[name] = values
    cloud.field_data["time_s"] = numpy.array([particles.time])
    return cloud
