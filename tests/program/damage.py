"""Ways to damage what a run wrote: for the tests of bad files and the fuzzer."""
import struct

MASK = 2**64 - 1


def fnv(data):
    """64-bit FNV-1a (io/checkpoint_format.cpp)."""
    value = 0xcbf29ce484222325
    for byte in data:
        value = (value ^ byte) * 0x100000001b3 & MASK
    return value


def parts(data):
    """A checkpoint's bytes without the seal, and the regions [at, bytes] of its rows."""
    count = struct.unpack_from("<Q", data, len(data) - 16)[0]
    words = struct.unpack_from(f"<{count}Q", data, len(data) - 8 * count)
    return bytearray(data[:len(data) - 8 * count]), list(zip(words[:-4:2], words[1:-4:2]))


def sealed(body, regions):
    """The body under a new seal, as who forges a checkpoint would make it."""
    rest, at = b"", 0
    for start, length in regions:
        rest += body[at:start]
        at = start + length
    words = [word for region in regions for word in region] + [fnv(rest + body[at:])]
    words.append(fnv(struct.pack(f"<{len(words)}Q", *words)))
    words += [len(words) + 2, 0x314c414553524f4d]
    return bytes(body) + struct.pack(f"<{len(words)}Q", *words)


def forged(data, at, form, *values):
    body, regions = parts(data)
    struct.pack_into(form, body, at, *values)
    return sealed(body, regions)
