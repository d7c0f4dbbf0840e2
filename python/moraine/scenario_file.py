"""Files of studies and calibrations: TOML with a scene, parameters, and what is asked; and the folder that a study is kept in."""
import dataclasses
import hashlib
import json
import math
import pathlib
import re
from typing import Any, Callable, Dict, List, Mapping, Sequence, Tuple, Union

from .errors import Error
from .parameters import Parameter, parse_parameters
from .quantity import Quantity, parse_quantities
from .scene import Path, read_scene, with_sets

RUN = re.compile(r"run-\d+")  # the folder of a run


@dataclasses.dataclass(frozen=True)
class ScenarioFile:
    """What both kinds of file have: the scene's file, parameters, quantities, keys that all runs change; and the whole file."""

    scene: pathlib.Path
    parameters: List[Parameter]
    quantities: List[Quantity]
    sets: Dict[str, Any]
    given: Mapping[str, Any]
    folder: pathlib.Path

    @property
    def end(self) -> float:
        """time.end of the scene [s]."""
        return float(with_sets(read_scene(self.scene), self.sets)["time"]["end"])

    def identity(self, more: Any) -> str:
        """A hash of the scene's keys, its parameters and `more`: what a folder must be of to be gone on with."""
        text = json.dumps([with_sets(read_scene(self.scene), self.sets), [dataclasses.asdict(p) for p in self.parameters], more], sort_keys=True, default=str)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


def read_file(given: Union[Path, Mapping[str, Any]], keys: Sequence[str], sections: Mapping[str, Sequence[str]]) -> ScenarioFile:
    """A file, or a dict of its keys; `keys` and `sections` are those that it may have besides scene, set and parameter. Raises Error."""
    folder = pathlib.Path() if isinstance(given, Mapping) else pathlib.Path(given).parent
    found = given if isinstance(given, Mapping) else read_scene(given)
    allowed = ["scene", "set", "parameter", *keys, *sections]
    for name in found:
        if name not in allowed:
            raise Error(f"{name} is not known (the file may have {', '.join(allowed)}). Remove it?")
    for section, names in sections.items():
        inside = found.get(section, {})
        if not isinstance(inside, Mapping):
            raise Error(f"{section} is no table (write [{section}]). Correct it?")
        for name in inside:
            if name not in names:
                raise Error(f"{section}.{name} is not known (it may have {', '.join(names)}). Remove it?")
    if not isinstance(found.get("scene"), (str, pathlib.Path)):
        raise Error("the file names no scene (its runs are of one). Add scene = \"valley.toml\"?")
    scene = folder / found["scene"]
    read_scene(scene)
    words = found.get("quantities", [])
    if not isinstance(words, list) or not all(isinstance(word, str) for word in words):
        raise Error("quantities is no list of names (as converge has them). Is it quantities = [\"front\"]?")
    return ScenarioFile(scene, parse_parameters(found.get("parameter")), parse_quantities(",".join(words)) if words else [],
                        dict(found.get("set", {})), found, folder)


def whole_number(table: Mapping[str, Any], name: str, standard: int, least: int) -> int:
    """A key of a section. Raises Error."""
    value = table.get(name, standard)
    if not isinstance(value, int) or isinstance(value, bool) or value < least:
        raise Error(f"{name} = {value} (a whole number from {least} on). Is it {max(standard, least)}?")
    return value


def open_folder(path: pathlib.Path, file: str, identity: str, overwrite: bool, look: Callable[[Dict[str, Any]], None]) -> Dict[str, Any]:
    """What is known in the folder of a study: {} of a new one. Raises Error where another is there.

    look: called with what is to be gone on with; fails where no study has written such: the file may be damaged, or anybody's.
    """
    if not path.exists() or not any(path.iterdir()):
        return {}
    try:
        known = json.loads((path / file).read_text(encoding="utf-8"))
        same = known["identity"] == identity
        if same and not overwrite:
            look(known)
    except OSError:
        raise Error(f"{path} is taken (there is no {file} in it). Another --output?") from None
    except (ValueError, LookupError, TypeError, AttributeError, ArithmeticError) as wrong:
        if overwrite:
            return {}
        raise Error(f"{path / file} is damaged ({' '.join(str(wrong).split()) or type(wrong).__name__}). Another --output, or --overwrite?") from None
    if not same and not overwrite:
        raise Error(f"{path} has another study (of another scene, other parameters or sampling). Another --output, or --overwrite?")
    return dict(known) if same and not overwrite else {}


def is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and not math.isnan(value)


def require_runs(known: Mapping[str, Any]) -> None:
    """Fails where the runs of a study or a calibration are not as they are written. Their names are those of folders in its own."""
    for name, each in known["runs"].items():
        code, problem, wall_s = each["code"], each["problem"], each["wall_s"]
        if not RUN.fullmatch(name) or not (code is None or type(code) is int) or not isinstance(problem, str) or not is_number(wall_s):
            raise ValueError(f"no run is as {name[:40]!a}")


def save_json(path: pathlib.Path, what: Mapping[str, Any]) -> None:
    """A reader never sees half of it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(path.name + ".partial")
    part.write_text(json.dumps(what, indent=1, default=str) + "\n", encoding="utf-8")
    part.replace(path)


def fields_of(quantities: Sequence[Quantity], scene: Mapping[str, Any]) -> Tuple[List[str], bool]:
    """Fields of particles that runs must write besides those of the scene, and whether they must write particles at all."""
    there = list(scene.get("output", {}).get("fields", ["velocity", "stress"]))
    more = sorted({name for q in quantities for name in q.fields or [] if name not in there})
    return there + more, any(q.fields is not None for q in quantities)
