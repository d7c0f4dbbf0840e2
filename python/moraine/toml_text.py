"""A dict as TOML text. (The standard library reads TOML, and does not write it.)"""
import json
import math
import re
from typing import Any, List, Mapping

from .errors import Error

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def _string(value: str) -> str:
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def _key(name: Any) -> str:
    if not isinstance(name, str):
        raise Error(f"{name!r} is no key of a scene (it is {type(name).__name__}). Write it as a string?")
    return name if _BARE.fullmatch(name) else _string(name)


def value_text(value: Any, path: str) -> str:
    """A value as TOML in one line; `path` names it in the message of an Error."""
    if hasattr(value, "tolist"):  # numbers and arrays of numpy
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else str(value)
    if isinstance(value, str):
        return _string(value)
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(value_text(item, path) for item in value) + "]"
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(k)} = {value_text(v, f'{path}.{k}')}" for k, v in value.items()) + " }"
    raise Error(f"{path} cannot be written (TOML has no {type(value).__name__}). Leave the key out, or give a number?")


def _is_tables(value: Any) -> bool:
    return isinstance(value, (list, tuple)) and len(value) > 0 and all(isinstance(item, Mapping) for item in value)


def _write(table: Mapping[str, Any], path: str, lines: List[str]) -> None:
    later = []
    for name, value in table.items():
        if isinstance(value, Mapping) or _is_tables(value):
            later.append((name, value))  # plain keys come first: behind a header they would belong to it
        else:
            lines.append(f"{_key(name)} = {value_text(value, f'{path}{name}')}")
    for name, value in later:
        inner = f"{path}{_key(name)}"
        for item in [value] if isinstance(value, Mapping) else value:
            lines += ["", f"[{inner}]" if isinstance(value, Mapping) else f"[[{inner}]]"]
            _write(item, inner + ".", lines)


def to_toml(scene: Mapping[str, Any]) -> str:
    """The scene as TOML text: dicts are tables, lists of dicts are arrays of tables (`[[body]]`).

    Raises Error for a value that TOML cannot hold, None among them.

    >>> print(to_toml({"domain": {"min": [0, 0]}, "title": "a \\"slide\\"", "wall": [{"face": "y-min"}]}))
    title = "a \\"slide\\""
    <BLANKLINE>
    [domain]
    min = [0, 0]
    <BLANKLINE>
    [[wall]]
    face = "y-min"
    <BLANKLINE>
    """
    lines: List[str] = []
    _write(scene, "", lines)
    return "\n".join(lines) + "\n"
