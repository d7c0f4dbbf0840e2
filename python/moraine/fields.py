"""Quantities that pictures show, one number a particle."""
import dataclasses
import difflib
from typing import Any, Callable, Dict, List, Optional

import numpy
from numpy.typing import NDArray

from .columns import depth_at
from .errors import Error
from .particles import Particles


@dataclasses.dataclass
class Field:
    """label with unit; colour map of matplotlib; the share of particles [%] that may lie below and above the scale, below None
    where it begins at 0: a few extreme pressures would leave one colour for all others; fields of the run that it needs."""

    label: str
    colours: str
    below: Optional[float]
    above: float
    needs: List[str]
    value: Callable[[Particles, float, float], NDArray[Any]]


FIELDS: Dict[str, Field] = {
    "speed": Field("speed [m/s]", "viridis", None, 0.2, ["velocity"], lambda p, width, between: p.speed()),
    "pressure": Field("pressure [kPa]", "plasma", 2, 2, ["pressure"], lambda p, width, between: p["pressure"] / 1e3),
    "plastic_shear_strain": Field("plastic shear strain [-]", "magma", None, 1, ["plastic_shear_strain"], lambda p, width, between: p["plastic_shear_strain"]),
    "depth": Field("depth of the flow [m]", "cividis", None, 0, [], lambda p, width, between: depth_at(p.position, width, between)),
    "rank": Field("rank", "ranks", None, 0, ["rank"], lambda p, width, between: p["rank"].astype(float)),
}


def field_of(name: str) -> Field:
    """The field of that name. Raises Error, with the nearest name, where there is none.

    >>> field_of("sped")
    Traceback (most recent call last):
    ...
    moraine.errors.Error: 'sped' cannot be drawn (it is not one of speed, pressure, plastic_shear_strain, depth, rank). Did you mean speed?
    """
    if name not in FIELDS:
        near = difflib.get_close_matches(name, FIELDS, 1, 0.4) or ["speed"]
        raise Error(f"{name!r} cannot be drawn (it is not one of {', '.join(FIELDS)}). Did you mean {near[0]}?")
    return FIELDS[name]


def finite(particles: Particles) -> Particles:
    """The particles that are somewhere: a run that ended by a fault may have written positions that are no numbers."""
    there = numpy.isfinite(particles.position).all(axis=1)
    if there.all():
        return particles
    fields = {name: values[there] for name, values in particles.fields.items()}
    return dataclasses.replace(particles, position=particles.position[there], fields=fields)
