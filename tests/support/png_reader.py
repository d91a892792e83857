"""Reads PNG files with 8 bits per channel and without interlacing, as isoextract writes them."""

import struct
import zlib


class Png:
    """Reads an 8-bit RGB or RGBA picture; pixels are tuples."""

    def __init__(self, data):
        assert data[:8] == b"\x89PNG\r\n\x1a\n"
        at, packed = 8, b""
        while at < len(data):
            size, kind = struct.unpack(">I4s", data[at : at + 8])
            body = data[at + 8 : at + 8 + size]
            assert struct.unpack(">I", data[at + 8 + size : at + 12 + size])[0] == zlib.crc32(kind + body)
            if kind == b"IHDR":
                self.width, self.height, depth, color = struct.unpack(">IIBB", body[:10])
            if kind == b"IDAT":
                packed += body
            at += 12 + size
        assert depth == 8
        self.channels = {2: 3, 6: 4}[color]
        self.bytes = self.unfiltered(zlib.decompress(packed))

    def unfiltered(self, rows):
        pitch, channels, rest, above = self.width * self.channels, self.channels, [], bytes(self.width * self.channels)
        for y in range(self.height):
            kind, row = rows[y * (pitch + 1)], bytearray(rows[y * (pitch + 1) + 1 : (y + 1) * (pitch + 1)])
            for x in range(pitch):
                left, corner = (row[x - channels], above[x - channels]) if x >= channels else (0, 0)
                up = above[x]
                paeth = min((abs(up - corner), 0, left), (abs(left - corner), 1, up), (abs(left + up - 2 * corner), 2, corner))
                row[x] = (row[x] + (0, left, up, (left + up) // 2, paeth[2])[kind]) & 255
            rest.append(row)
            above = row
        return b"".join(rest)

    @property
    def shape(self):
        return self.height, self.width, self.channels

    def pixel(self, x, y):
        first = (x + self.width * y) * self.channels
        return tuple(self.bytes[first : first + self.channels])

    def difference(self, other):
        assert self.shape == other.shape
        return max(abs(a - b) for a, b in zip(self.bytes, other.bytes))

    def alpha(self):
        return sum(self.bytes[3::4])

    def pixels(self):
        return [self.pixel(x, y) for y in range(self.height) for x in range(self.width)]
