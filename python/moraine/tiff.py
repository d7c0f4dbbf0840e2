"""Writes maps as GeoTIFF in pure Python: 32-bit numbers, deflate, with the place, coordinate system and no-data value of another map."""
import html
import pathlib
import struct
import zlib
from typing import Any, Dict, List, Mapping, Optional, Tuple

import numpy

from .errors import Error
from .grids import NO_DATA, SCALE, TIE, Grid

UNKNOWN = -9999.0
METADATA = 42112
SYSTEM = (34735, 34736, 34737)  # keys, numbers and words of a coordinate system
SIZES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 12: 8}
Entry = Tuple[int, int, bytes]  # type, count, bytes


def system_of(path: pathlib.Path) -> Dict[int, Entry]:
    """Entries of the coordinate system of a little-endian TIFF, as bytes; none of a file that has none."""
    data = path.read_bytes()
    if data[:4] != b"II*\0":
        return {}
    found: Dict[int, Entry] = {}
    at = struct.unpack_from("<I", data, 4)[0]
    for k in range(struct.unpack_from("<H", data, at)[0]):
        place = at + 2 + 12 * k
        tag, kind, count = struct.unpack_from("<HHI", data, place)
        size = SIZES.get(kind, 0) * count
        if tag in SYSTEM and size:
            start = place + 8 if size <= 4 else struct.unpack_from("<I", data, place + 8)[0]
            found[tag] = kind, count, data[start:start + size]
    return found


def _text(words: str) -> Entry:
    data = words.encode("utf-8") + b"\0"
    return 2, len(data), data


def _metadata(unit: str, name: str, tags: Mapping[str, str]) -> str:
    """As GDAL keeps it."""
    items = [f'<Item name="{html.escape(key)}">{html.escape(value)}</Item>' for key, value in tags.items()]
    items += [f'<Item name="DESCRIPTION" sample="0" role="description">{html.escape(name)}</Item>']
    if unit:
        items += [f'<Item name="UNITTYPE" sample="0" role="unittype">{html.escape(unit)}</Item>']
    return "<GDALMetadata>" + "".join(items) + "</GDALMetadata>"


def write_tiff(path: pathlib.Path, grid: Grid, name: str, unit: str, like: Optional[pathlib.Path] = None, tags: Mapping[str, str] = {}) -> None:
    """The map as path.tif; what is not finite is no-data. `like`: a map whose coordinate system it has; tags: words about it."""
    rows, columns = grid.values.shape
    values = numpy.where(numpy.isfinite(grid.values), grid.values, UNKNOWN)[::-1].astype("<f4")
    body = zlib.compress(values.tobytes(), 9)
    west, _, _, north = grid.extent
    number = {3: "<H", 4: "<I"}

    def one(kind: int, value: int) -> Entry:
        return kind, 1, struct.pack(number[kind], value)
    entries: Dict[int, Entry] = {
        256: one(4, columns), 257: one(4, rows), 258: one(3, 32), 259: one(3, 8), 262: one(3, 1), 273: one(4, 8), 277: one(3, 1),
        278: one(4, rows), 279: one(4, len(body)), 284: one(3, 1), 339: one(3, 3),
        SCALE: (12, 3, struct.pack("<3d", grid.cell, grid.cell, 0.0)), TIE: (12, 6, struct.pack("<6d", 0, 0, 0, west, north, 0)),
        METADATA: _text(_metadata(unit, name, tags)), NO_DATA: _text(f"{UNKNOWN:g}")}
    if like is not None and like.suffix == ".tif":
        entries.update(system_of(like))
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(path.name + ".partial")
    part.write_bytes(_file(entries, body))
    part.replace(path)


def _file(entries: Mapping[int, Entry], body: bytes) -> bytes:
    """Head, numbers, values of entries that do not fit into them, and the entries."""
    data = bytearray(b"II*\0\0\0\0\0" + body)
    rows: List[bytes] = []
    for tag in sorted(entries):
        kind, count, value = entries[tag]
        if len(value) > 4:
            data += b"\0" * (len(data) % 2)
            place, value = len(data), value
            data += value
            rows.append(struct.pack("<HHII", tag, kind, count, place))
        else:
            rows.append(struct.pack("<HHI", tag, kind, count) + value.ljust(4, b"\0"))
    data += b"\0" * (len(data) % 2)
    struct.pack_into("<I", data, 4, len(data))
    return bytes(data + struct.pack("<H", len(rows)) + b"".join(rows) + struct.pack("<I", 0))


def write_ascii(path: pathlib.Path, grid: Grid) -> None:
    """The map as path.asc."""
    west, _, south, _ = grid.extent
    rows, columns = grid.values.shape
    head = f"ncols {columns}\nnrows {rows}\nxllcorner {west:.10g}\nyllcorner {south:.10g}\ncellsize {grid.cell:.10g}\nNODATA_value {UNKNOWN:g}\n"
    lines = (" ".join(f"{value:.6g}" if numpy.isfinite(value) else f"{UNKNOWN:g}" for value in row) for row in grid.values[::-1].tolist())
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(head + "\n".join(lines) + "\n", encoding="utf-8")


def write_like(folder: pathlib.Path, name: str, grid: Grid, unit: str, like: pathlib.Path, tags: Mapping[str, str] = {}) -> pathlib.Path:
    """A map into folder/name.tif or .asc, as the map `like` is; the file."""
    if like.suffix not in (".tif", ".asc"):
        raise Error(f"{like} is no map (it ends with {like.suffix}). Is it of a run?")
    path = folder / (name + like.suffix)
    if like.suffix == ".tif":
        write_tiff(path, grid, name, unit, like, tags)
    else:
        write_ascii(path, grid)
    return path
