"""Scenes as dicts: read from TOML, written as TOML, and called by the program."""
import contextlib
import copy
import pathlib
import tempfile
from typing import Any, Dict, Iterator, List, Mapping, Tuple, Union

from .errors import Error
from .toml_text import to_toml, value_text

Path = Union[str, pathlib.Path]
#: A file, or a dict with the keys of inputs/reference.toml.
Scene = Union[str, pathlib.Path, Mapping[str, Any]]
_LABELS = {"material": "name", "body": "name", "structure": "name", "release": "name", "inflow": "name", "wall": "face"}  # by which --set addresses tables of a list


def _toml(text: str) -> Dict[str, Any]:
    try:
        import tomllib
    except ImportError:  # before Python 3.11
        try:
            import tomli as tomllib  # type: ignore[no-redef]
        except ImportError:
            raise Error("TOML cannot be read (no tomllib before Python 3.11, and no tomli). pip install tomli?") from None
    return tomllib.loads(text)


def read_scene(path: Path) -> Dict[str, Any]:
    """The scene in a TOML file as a dict. Raises Error if it cannot be read or is no TOML."""
    try:
        return _toml(pathlib.Path(path).read_text(encoding="utf-8"))
    except OSError as wrong:
        raise Error(f"{path} cannot be read ({wrong.strerror}). Is the path right?") from None
    except ValueError as wrong:
        raise Error(f"{path} is no TOML ({wrong}). Are all strings in quotes?") from None


def write_scene(scene: Mapping[str, Any], path: Path) -> pathlib.Path:
    """Writes the scene as TOML and returns the path. Raises Error for what TOML cannot hold, before it writes.

    >>> file = pathlib.Path(tempfile.mkdtemp()) / "slide.toml"
    >>> write_scene({"time": {"end": 2.0}}, file).read_text().split()
    ['[time]', 'end', '=', '2.0']
    """
    text = to_toml(scene)
    path = pathlib.Path(path)
    path.write_text(text, encoding="utf-8")
    return path


@contextlib.contextmanager
def as_file(scene: Scene) -> Iterator[pathlib.Path]:
    """The scene's file; that of a dict is gone afterwards."""
    if isinstance(scene, Mapping):
        with tempfile.TemporaryDirectory(prefix="moraine-") as folder:
            yield write_scene(scene, pathlib.Path(folder) / "scene.toml")
    else:
        yield pathlib.Path(scene)


def parse_set(text: str) -> Tuple[str, Any]:
    """KEY=VALUE as the program reads it: VALUE is TOML, else a string.

    >>> parse_set("domain.max=[4, 2]"), parse_set("numerics.transfer=apic")
    (('domain.max', [4, 2]), ('numerics.transfer', 'apic'))
    """
    key, equals, value = text.partition("=")
    if not equals or not key.strip():
        raise Error(f"--set {text} (it must be KEY=VALUE). Is it time.end=2.0?")
    try:
        return key.strip(), _toml(f"v = {value}")["v"]
    except ValueError:
        return key.strip(), value.strip()


def with_sets(scene: Mapping[str, Any], sets: Mapping[str, Any]) -> Dict[str, Any]:
    """A copy of the scene with changed keys; material.NAME.key, body.NAME.key, structure.NAME.key and wall.FACE.key address
    the tables of a list, as in --set. What is not there is left to the program to refuse.

    >>> with_sets({"body": [{"name": "block", "max": [1, 1]}]}, {"body.block.max": [2, 1], "time.end": 3.0})
    {'body': [{'name': 'block', 'max': [2, 1]}], 'time': {'end': 3.0}}
    """
    changed = copy.deepcopy(dict(scene))
    for key, value in sets.items():
        *path, last = key.split(".")
        table: Any = changed
        if path and path[0] in _LABELS:
            label, name = _LABELS[path[0]], path[1] if len(path) > 1 else ""
            items = table.setdefault(path[0], [])
            found = [item for item in items if item.get(label) == name]
            if not found:
                items.append({label: name})
            table, path = found[0] if found else items[-1], path[2:]
        for name in path:
            table = table.setdefault(name, {})
        table[last] = value
    return changed


def set_words(sets: Mapping[str, Any]) -> List[str]:
    """Changed keys as options of the program.

    >>> set_words({"time.end": 2.0, "domain.max": [4, 2], "output.block_loads": "on"})
    ['--set', 'time.end=2.0', '--set', 'domain.max=[4, 2]', '--set', 'output.block_loads="on"']
    """
    words: List[str] = []
    for key, value in sets.items():
        words += ["--set", f"{key}={value_text(value, key)}"]
    return words
