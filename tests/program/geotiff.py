"""Reads what the program writes as GeoTIFF: one band of 32-bit floats in tiles, by deflate or as they are."""
import struct
import zlib

SIZES = {1: 1, 2: 1, 3: 2, 4: 4, 12: 8}
LETTERS = {1: "B", 2: "c", 3: "H", 4: "I", 12: "d"}


def tags_of(data):
    """The first directory of a TIFF: tag -> its values, text as bytes."""
    if data[:4] != b"II*\0":
        raise ValueError("no little-endian TIFF")
    at, tags = struct.unpack_from("<I", data, 4)[0], {}
    for k in range(struct.unpack_from("<H", data, at)[0]):
        tag, kind, count, place = struct.unpack_from("<HHII", data, at + 2 + 12 * k)
        if kind not in SIZES:
            continue
        if SIZES[kind] * count <= 4:
            place = at + 10 + 12 * k
        values = struct.unpack_from(f"<{count}{LETTERS[kind]}", data, place)
        tags[tag] = b"".join(values) if kind == 2 else values
    return tags


def read(path):
    """Rows from north to south, and the tags."""
    data = path.read_bytes()
    tags = tags_of(data)
    width, height = tags[256][0], tags[257][0]
    across, down = tags[322][0], tags[323][0]
    rows = [[0.0] * width for _ in range(height)]
    columns = -(-width // across)
    for k, (place, size) in enumerate(zip(tags[324], tags[325])):
        tile = data[place:place + size]
        if tags[259][0] != 1:
            tile = zlib.decompress(tile)
        values = struct.unpack(f"<{across * down}f", tile)
        top, left = k // columns * down, k % columns * across
        for j in range(min(down, height - top)):
            n = min(across, width - left)
            rows[top + j][left:left + n] = values[j * across:j * across + n]
    return rows, tags
