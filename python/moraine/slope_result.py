"""What `moraine stability` finds: the bracket of each cell, and the factor with its error bar."""
import dataclasses
import pathlib
from typing import Any, Dict, List, Optional

from .slope_job import Trial


@dataclasses.dataclass
class SlopeResult:
    """One cell [m]: the highest factor that stands and the lowest that fails, height [m], how far it had moved when it had settled [m], particles, remarks, trials."""

    cell: float
    stands: float
    fails: float
    height: float
    settled_way: float
    particles: int
    uneven: bool
    remarks: List[str]
    trials: List[Trial]
    folder: str
    picture: str = ""

    @property
    def middle(self) -> float:
        return (self.stands + self.fails) / 2


@dataclasses.dataclass
class FactorOfSafety:
    """What was found: the levels, and a factor with its error bar once there are two of them."""

    path: pathlib.Path
    scene: str
    levels: List[SlopeResult] = dataclasses.field(default_factory=list)
    remarks: List[str] = dataclasses.field(default_factory=list)

    @property
    def factor(self) -> Optional[float]:
        """The middle of the bracket on the finest cell."""
        return self.levels[-1].middle if self.levels else None

    @property
    def error(self) -> Optional[float]:
        """|FS_h - FS_h/2| + the bracket; None of one cell alone."""
        if len(self.levels) < 2:
            return None
        coarse, fine = self.levels[-2:]
        return abs(coarse.middle - fine.middle) + (fine.fails - fine.stands)


def as_json(found: FactorOfSafety) -> Dict[str, Any]:
    """The answer as stability.json has it."""
    brackets = [{"cell_m": r.cell, "stands": r.stands, "fails": r.fails, "height_m": r.height, "settled_way_m": r.settled_way, "particles": r.particles,
                 "uneven": r.uneven, "remarks": r.remarks, "picture": r.picture} for r in found.levels]
    return {"scene": found.scene, "factor_of_safety": found.factor, "error": found.error, "remarks": found.remarks, "brackets": brackets}
