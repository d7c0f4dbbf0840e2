"""What `moraine stability` is asked for, and what cannot be."""
import dataclasses
from typing import Any, List, Mapping, Optional, Sequence

from .errors import Error
from .levels import refuse_tables


@dataclasses.dataclass(frozen=True)
class Wanted:
    """What is asked for beside the scene."""

    tolerance: float
    cell: Optional[float]
    levels: int
    settle: float
    height: Optional[float]
    way: float
    keep: Sequence[str]
    softening: bool


def refuse(wanted: Wanted, scene: Mapping[str, Any]) -> None:
    """Raises Error for words and scenes that have no factor of safety."""
    if not 0 < wanted.tolerance <= 0.5:
        raise Error(f"--tolerance {wanted.tolerance:g} (the width of the bracket, above 0 and at most 0.5). Try 0.01?")
    if wanted.levels not in (1, 2):
        raise Error(f"--levels {wanted.levels} (one cell, or two for an error bar). Try 2?")
    if not 0 < wanted.settle <= 20:
        raise Error(f"--settle {wanted.settle:g} (the factor at which the slope settles, above 0). Try 1?")
    if not 0 < wanted.way <= 1:
        raise Error(f"--way {wanted.way:g} (a share of the height, above 0 and at most 1). Try 0.05?")
    for name in ("cell", "height"):
        value = getattr(wanted, name)
        if value is not None and not value > 0:
            raise Error(f"--{name} {value:g} (it is longer than 0 m). Leave it out?")
    if "cell" not in scene.get("domain", {}):
        raise Error("the scene has no domain.cell (it is needed). Is it a scene?")
    if not any(scene.get("gravity", [0.0])):
        raise Error("the scene has no gravity (nothing slides without). Set gravity = [0.0, -9.81]?")
    for what in ("release", "inflow"):
        if scene.get(what):
            raise Error(f"the scene has [[{what}]] (it is no slope that rests). Take bodies?")
    if scene.get("water"):
        raise Error("the scene has [water] (it settles with damping, which is for dry soil). Give the soil its buoyant density instead?")
    for what in ("stage", "table"):
        if scene.get(what):
            raise Error(f"the scene has [[{what}]] (it settles at F = 1, and nothing but strengths changes then). Take it out?")
    refuse_tables(scene)


def remarks_of(scene: Mapping[str, Any]) -> List[str]:
    """What of the laws a reader should know."""
    found = []
    for item in scene.get("material", []):
        if item.get("rate_log", 0) > 0 or item.get("rate_power", 0) > 0:
            found.append(f"material.{item.get('name', '')} is stronger at a rate: the factor is that of a slope which already moves a little")
        if item.get("sensitivity", 1) > 1:
            found.append(f"material.{item.get('name', '')} softens: the factor DEPENDS ON THE CELL, and the error bar does not hold it")
    return found
