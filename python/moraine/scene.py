"""Scenes as dicts: read from TOML, written as TOML, and called by the program."""
import contextlib
import pathlib
import tempfile
from typing import Any, Dict, Iterator, List, Mapping, Union

from .errors import Error
from .toml_text import to_toml, value_text

Path = Union[str, pathlib.Path]
#: A file, or a dict with the keys of inputs/reference.toml.
Scene = Union[str, pathlib.Path, Mapping[str, Any]]


def read_scene(path: Path) -> Dict[str, Any]:
    """The scene in a TOML file as a dict. Raises Error if it cannot be read or is no TOML."""
    try:
        import tomllib
    except ImportError:  # before Python 3.11
        try:
            import tomli as tomllib  # type: ignore[no-redef]
        except ImportError:
            raise Error(f"{path} cannot be read (no tomllib before Python 3.11, and no tomli). "
                        "pip install tomli?") from None
    try:
        return tomllib.loads(pathlib.Path(path).read_text(encoding="utf-8"))
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


def set_words(sets: Mapping[str, Any]) -> List[str]:
    """Changed keys as options of the program.

    >>> set_words({"time.end": 2.0, "domain.max": [4, 2], "output.block_loads": "on"})
    ['--set', 'time.end=2.0', '--set', 'domain.max=[4, 2]', '--set', 'output.block_loads="on"']
    """
    words: List[str] = []
    for key, value in sets.items():
        words += ["--set", f"{key}={value_text(value, key)}"]
    return words
