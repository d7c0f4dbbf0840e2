"""Axes in map coordinates: numbers with many digits are counted from a round place, which the axis' title names."""
import math
from typing import Any

DIGITS = 10000.0  # coordinates below are shown as they are


def offset_of(low: float, high: float) -> float:
    """A round place to count from, 0 where numbers are short.

    >>> offset_of(600010.0, 600420.0), offset_of(5204120.0, 5204890.0), offset_of(0.0, 260.0), offset_of(-12000.0, 12000.0)
    (600000.0, 5204000.0, 0.0, 0.0)
    """
    if max(abs(low), abs(high)) < DIGITS or not high > low or low < 0 < high:
        return 0.0
    step = 10.0 ** math.ceil(math.log10(high - low))
    return math.floor(low / step) * step


def axis_title(name: str, offset: float) -> str:
    """
    >>> axis_title("x", 5204000.0), axis_title("y", 0.0)
    ('x - 5 204 000 [m]', 'y [m]')
    """
    if not offset:
        return f"{name} [m]"
    sign = "-" if offset > 0 else "+"
    return f"{name} {sign} {abs(offset):,.0f} [m]".replace(",", " ")


def label_axis(axis: Any, name: str, low: float, high: float) -> None:
    """Title and numbers of an axis of matplotlib, between two coordinates."""
    offset = offset_of(low, high)
    axis.set_label_text(axis_title(name, offset))
    if offset:
        axis.set_major_formatter(lambda value, _: f"{value - offset:g}")
