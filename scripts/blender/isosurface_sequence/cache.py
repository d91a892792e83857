"""Reads frames, and keeps the last ones as long as they fit into the memory that they may take."""

import collections
import os

from .glb import read_glb
from .ply import read_ply
from .surface import UnreadableFile

READERS = {".glb": read_glb, ".ply": read_ply}


class SurfaceCache:
    """The surfaces read last. `limit`: bytes; the newest one is kept even where it is larger."""

    def __init__(self, limit):
        self.limit = limit
        self._surfaces = collections.OrderedDict()

    def bytes(self):
        return sum(surface.bytes() for surface in self._surfaces.values())

    def surface(self, path, y_is_up):
        """The surface of a file, with z up; read again where the file has changed."""
        key = (stamp(path), y_is_up)
        if key in self._surfaces:
            self._surfaces.move_to_end(key)
            return self._surfaces[key]
        extension = os.path.splitext(path)[1].lower()
        if extension not in READERS:
            raise UnreadableFile(f"{path}: reads {' and '.join(READERS)} files only")
        surface = READERS[extension](path)
        self._surfaces[key] = surface.turned_from_y_up() if y_is_up else surface
        while len(self._surfaces) > 1 and self.bytes() > self.limit:
            self._surfaces.popitem(last=False)
        return self._surfaces[key]

    def clear(self):
        self._surfaces.clear()


def stamp(path):
    """What tells a file's contents from others without reading them."""
    try:
        status = os.stat(path)
    except OSError as error:
        raise UnreadableFile(f"{path}: {error.strerror or error}") from error
    return f"{path}|{status.st_size}|{status.st_mtime_ns}"
