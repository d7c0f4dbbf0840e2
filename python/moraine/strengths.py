"""Strengths of a scene, and what they are divided by a factor: c/F, tan(phi)/F, su/F (Matsui and San 1992; Griffiths and Lane 1999)."""
import math
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Sequence

from .errors import Error


def _share(value: float, factor: float) -> float:
    return value / factor


def _angle(value: float, factor: float) -> float:
    """An angle [deg] whose tangent is divided.

    >>> round(_angle(45.0, 2.0), 6)
    26.565051
    """
    return math.degrees(math.atan(math.tan(math.radians(value)) / factor))


#: of each law the keys that are reduced, and how
LAWS: Dict[str, Dict[str, Callable[[float, float], float]]] = {
    "drucker-prager": {"cohesion": _share, "friction_angle": _angle, "dilation_angle": _angle},
    "tresca": {"su": _share},
    "von-mises": {"su": _share},
    "mu-i": {"static_friction": _share, "limit_friction": _share},
}
INTERFACES = ("friction", "su")  # of walls and of contact


class Strength(NamedTuple):
    """One key of the scene, its value at F = 1, and how it is reduced."""

    key: str
    value: float
    reduced: Callable[[float, float], float]


def _of_material(item: Mapping[str, Any], softening: bool) -> List[Strength]:
    name, law = item.get("name", ""), item.get("law", "")
    if law not in LAWS:
        raise Error(f"material.{name}: law {law} has no strength to divide (those with one are {', '.join(LAWS)}). "
                    f"Another law, or --keep {name} where it shall stay as it is?")
    if law == "drucker-prager" and item.get("matching", 0) != 0:
        raise Error(f"material.{name}.matching = {item['matching']} (its strength in plane strain is another than that of c and phi). "
                    f"--set material.{name}.matching=0?")
    if item.get("sensitivity", 1) > 1 and not softening:
        raise Error(f"material.{name}.sensitivity = {item['sensitivity']:g} (clay that softens has no factor of safety without a length: it depends "
                    f"on the cell). --set material.{name}.sensitivity=1, or --softening?")
    for key in LAWS[law]:
        if isinstance(item.get(key), dict):
            raise Error(f"material.{name}.{key} is a strength over depth (each particle keeps its own, and no restart changes it). "
                        "Bodies of several materials, each with one number?")
    return [Strength(f"material.{name}.{key}", float(item[key]), how) for key, how in LAWS[law].items() if isinstance(item.get(key), (int, float)) and item[key] > 0]


def _of_interface(place: str, item: Mapping[str, Any]) -> List[Strength]:
    if "voellmy" in (item.get("kind"), item.get("law")):
        raise Error(f"{place} has the law voellmy (its resistance grows with speed, and has no factor). Take friction?")
    found = []
    for key in INTERFACES:
        value = item.get(key)
        if value == "soil":
            continue  # it follows the soil's, which is divided
        if isinstance(value, (dict, str)):
            raise Error(f"{place}.{key} is read from a file (it cannot be divided from run to run). Give one number?")
        if isinstance(value, (int, float)) and value > 0:
            found.append(Strength(f"{place}.{key}", float(value), _share))
    return found


def strengths_of(scene: Mapping[str, Any], keep: Sequence[str] = (), softening: bool = False) -> List[Strength]:
    """What is reduced: of materials, but for those in `keep`, and of walls and contact. Raises Error for laws without a strength and clay that softens.

    >>> sand = {"name": "sand", "law": "drucker-prager", "friction_angle": 45.0, "cohesion": 1e3}
    >>> [s.key for s in strengths_of({"material": [sand]})]
    ['material.sand.cohesion', 'material.sand.friction_angle']
    """
    names = [item.get("name", "") for item in scene.get("material", [])]
    for name in keep:
        if name not in names:
            raise Error(f"--keep {name} (the materials are {', '.join(names) or 'none'}). Correct it?")
    found = [s for item in scene.get("material", []) if item.get("name", "") not in keep for s in _of_material(item, softening)]
    if not found:
        raise Error("no material has a strength to divide (all are kept). Leave --keep out?")
    for item in scene.get("wall", []):
        found += _of_interface(f"wall.{item.get('face', '')}", item)
    for item in scene.get("structure", []):
        found += _of_interface(f"structure.{item.get('name', '')}.contact", item.get("contact", {}))
    return found


def reduced(strengths: Sequence[Strength], factor: float) -> Dict[str, float]:
    """Keys and values of the scene with strengths divided by the factor.

    >>> reduced([Strength("material.clay.su", 10e3, _share)], 1.25)
    {'material.clay.su': 8000.0}
    """
    return {s.key: s.reduced(s.value, factor) for s in strengths}
