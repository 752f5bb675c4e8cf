"""Reads the PNG files that meldsim writes."""
import struct
import zlib

import numpy as np


def read_png(data):
    """Rows of pixels, each red, green, blue and, where there is one, alpha."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n", "no PNG"
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        chunk = data[at + 8:at + 8 + size]
        assert zlib.crc32(kind + chunk) == struct.unpack(">I", data[at + 8 + size:at + 12 + size])[0], "damaged"
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack(">IIBB", chunk[:10])
            assert depth == 8 and colour in (2, 6), "another kind of pixels"
        if kind == b"IDAT":
            packed += chunk
        at += 12 + size
    channels = 3 if colour == 2 else 4
    rows = np.frombuffer(zlib.decompress(packed), dtype=np.uint8).reshape(height, 1 + width * channels)
    out = np.zeros((height, width * channels), dtype=np.uint8)
    for y, row in enumerate(rows):
        out[y] = unfiltered(row[0], row[1:].astype(np.int64), out[y - 1].astype(np.int64) if y else np.zeros(width * channels, np.int64),
                            channels)
    return out.reshape(height, width, channels)


def unfiltered(kind, row, above, step):
    if kind == 0:
        return row
    if kind == 2:
        return (row + above) % 256
    out = np.zeros(len(row), np.int64)
    if kind == 1:
        for channel in range(step):
            out[channel::step] = np.cumsum(row[channel::step]) % 256
        return out
    for i, value in enumerate(row):
        left, corner = (out[i - step], above[i - step]) if i >= step else (0, 0)
        if kind == 3:
            guess = (left + above[i]) // 2
        else:
            near = left + above[i] - corner
            guess = min((left, above[i], corner), key=lambda x: abs(near - x))
        out[i] = (value + guess) % 256
    return out
