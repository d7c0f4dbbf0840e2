"""Parameters of a study: a key of the scene, and the values that it may have: a range, a normal distribution, or a list."""
import dataclasses
import math
from typing import Any, Dict, List, Mapping, Sequence, Tuple

from .errors import Error

CUT = 3.0  # deviations beyond which a normal distribution is cut off
KEYS = ("key", "range", "log", "normal", "values", "steps")


def normal_share(z: float) -> float:
    """Of a standard normal distribution below z."""
    return 0.5 * math.erfc(-z / math.sqrt(2))


def normal_place(share: float) -> float:
    """The z below which that share lies, within the cut.

    >>> round(normal_place(0.975), 3)
    1.96
    """
    low, high = -CUT, CUT
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if normal_share(middle) < share else (low, middle)
    return (low + high) / 2


@dataclasses.dataclass(frozen=True)
class Parameter:
    """kind: "range" (low to high, even, or even in the logarithm), "normal" (mean and deviation, cut at three deviations) or "values"."""

    key: str
    kind: str
    low: float = 0.0
    high: float = 0.0
    log: bool = False
    values: Tuple[Any, ...] = ()
    steps: int = 3

    def at(self, share: float) -> Any:
        """The value below which that share, 0 to 1, of all lies.

        >>> Parameter("xi", "range", 300.0, 800.0).at(0.5), Parameter("xi", "range", 100.0, 400.0, True).at(0.5)
        (550.0, 200.0)
        """
        if self.kind == "values":
            return self.values[min(int(share * len(self.values)), len(self.values) - 1)]
        if self.kind == "normal":
            inside = normal_share(-CUT) + share * (1 - 2 * normal_share(-CUT))
            return float(f"{self.low + self.high * normal_place(inside):.10g}")
        if self.log:
            return float(f"{self.low * (self.high / self.low)**share:.10g}")
        return float(f"{self.low + share * (self.high - self.low):.10g}")

    def grid(self) -> List[Any]:
        """All values, or `steps` of them from end to end."""
        if self.kind == "values":
            return list(self.values)
        if self.kind == "normal":
            return [self.at((k + 0.5) / self.steps) for k in range(self.steps)]
        return [self.at(k / (self.steps - 1)) for k in range(self.steps)] if self.steps > 1 else [self.at(0.5)]

    @property
    def deviation(self) -> float:
        """Standard deviation of the shares between 0 and 1 that are drawn evenly."""
        return 1 / math.sqrt(12)


def _numbers(value: Any, count: int) -> bool:
    return isinstance(value, list) and len(value) == count and all(isinstance(x, (int, float)) and not isinstance(x, bool) and math.isfinite(x) for x in value)


def parse_parameter(given: Mapping[str, Any], number: int) -> Parameter:
    """A [[parameter]] of a study. Raises Error."""
    key, where = given.get("key"), f"parameter {number}"
    if not isinstance(key, str) or not key:
        raise Error(f"{where} has no key (it names a key of the scene). Is it key = \"terrain.contact.friction\"?")
    unknown = [name for name in given if name not in KEYS]
    kinds = [kind for kind in ("range", "normal", "values") if kind in given]
    if unknown or len(kinds) != 1:
        why = f"{unknown[0]} is not known" if unknown else "it needs one of range, normal and values"
        raise Error(f"{where}, {key} ({why}). Is it range = [0.1, 0.3]?")
    steps = given.get("steps", 3)
    if not isinstance(steps, int) or isinstance(steps, bool) or steps < 1:
        raise Error(f"{where}, {key} has steps = {steps} (a whole number of values in a grid). Is it 3?")
    if kinds[0] == "values":
        if not isinstance(given["values"], list) or not given["values"]:
            raise Error(f"{where}, {key} has no values (a list is needed). Is it values = [300, 500]?")
        return Parameter(key, "values", values=tuple(given["values"]), steps=len(given["values"]))
    if not _numbers(given[kinds[0]], 2):
        raise Error(f"{where}, {key}: {kinds[0]} = {given[kinds[0]]} (two numbers are needed). Is it range = [0.1, 0.3], or normal = [mean, deviation]?")
    low, high = map(float, given[kinds[0]])
    log = bool(given.get("log", False))
    if kinds[0] == "range" and (not high > low or (log and not low > 0)):
        raise Error(f"{where}, {key}: range = [{low:g}, {high:g}] ({'its logarithm needs numbers above 0' if high > low else 'it does not rise'}). Turn it round?")
    if kinds[0] == "normal" and not high > 0:
        raise Error(f"{where}, {key}: normal = [{low:g}, {high:g}] (the second is the deviation, above 0). Correct it?")
    return Parameter(key, kinds[0], low, high, log, (), steps)


def parse_parameters(given: Any) -> List[Parameter]:
    """All [[parameter]] of a file. Raises Error."""
    if not isinstance(given, list) or not given or not all(isinstance(item, Mapping) for item in given):
        raise Error("the file has no [[parameter]] (what is varied is needed). Add one with key and range?")
    found = [parse_parameter(item, k + 1) for k, item in enumerate(given)]
    if len({p.key for p in found}) < len(found):
        raise Error("two parameters have one key (each is varied by itself). Remove one?")
    return found


def sets_of(parameters: Sequence[Parameter], shares: Sequence[float]) -> Dict[str, Any]:
    """The keys of the scene at a point of the unit cube."""
    return {p.key: p.at(float(share)) for p, share in zip(parameters, shares)}
