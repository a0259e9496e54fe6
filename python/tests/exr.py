"""Reads the OpenEXR files that hbil writes: scan lines of floats, without
compression or with zip."""
import struct
import zlib

import numpy as np

ROWS = {0: 1, 2: 1, 3: 16}  # of a block, by compression: none, zips, zip


def _text(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def read(path):
    """A dict of arrays of (height, width) by the channels' names."""
    with open(path, "rb") as file:
        data = file.read()
    assert data[:4] == b"\x76\x2f\x31\x01"
    attributes, at = {}, 8
    while data[at]:
        name, at = _text(data, at)
        _, at = _text(data, at)
        size, = struct.unpack_from("<i", data, at)
        attributes[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    rows = ROWS[attributes["compression"][0]]
    types, head = {}, attributes["channels"]
    place = 0
    while head[place]:
        name, place = _text(head, place)
        types[name] = {1: "<f2", 2: "<f4"}[struct.unpack_from("<i", head,
                                                              place)[0]]
        place += 16
    found = {name: np.empty((height, width), kind)
             for name, kind in types.items()}
    count = -(-height // rows)
    for offset in struct.unpack_from(f"<{count}Q", data, at + 1):
        y, size = struct.unpack_from("<2i", data, offset)
        block = data[offset + 8:offset + 8 + size]
        y -= y0
        lines = min(rows, height - y)
        whole = lines * width * sum(np.dtype(t).itemsize for t in types.values())
        if size < whole:  # else it isn't compressed
            coded = np.frombuffer(zlib.decompress(block), np.uint8)
            steps = coded.astype(np.int64)
            steps[1:] -= 128
            plain = np.cumsum(steps).astype(np.uint8)
            half = (len(plain) + 1) // 2
            mixed = np.empty_like(plain)
            mixed[0::2], mixed[1::2] = plain[:half], plain[half:]
            block = mixed.tobytes()
        at_pixel = 0
        for line in range(y, y + lines):
            for name, kind in types.items():
                found[name][line] = np.frombuffer(block, kind, width, at_pixel)
                at_pixel += width * np.dtype(kind).itemsize
    return found
