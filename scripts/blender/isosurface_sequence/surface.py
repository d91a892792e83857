"""What one frame's file holds, as numpy arrays: made by the readers, put into Blender's meshes by `blender_mesh`."""

import dataclasses
import typing

import numpy as np


class UnreadableFile(Exception):
    """A file that is damaged, or that uses features this reader does not know. The message is for the user."""


@dataclasses.dataclass
class Attribute:
    """A value that every vertex has."""

    name: str
    values: np.ndarray  # vertices x components; float32 or int32, colors as linear float32
    is_color: bool = False
    kind: typing.Optional[str] = None  # "vector", "point" or "normal" if the values turn with the mesh

    def turned_from_y_up(self):
        return dataclasses.replace(self, values=y_up_to_z_up(self.values)) if self.kind else self


@dataclasses.dataclass
class Surface:
    """Triangles whose vertices are at `origin` + `positions`: far from zero, 32 bits are too few for the sum."""

    positions: np.ndarray  # n x 3, float32
    triangles: np.ndarray  # m x 3, int32
    origin: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros(3))  # float64
    normals: typing.Optional[np.ndarray] = None  # n x 3, float32
    flat: bool = False  # the file says by its normals that triangles are not to be shaded smoothly
    parts: typing.Optional[np.ndarray] = None  # of each triangle, the number of its part; None: there is one part
    part_names: typing.Tuple[str, ...] = ("",)
    attributes: typing.List[Attribute] = dataclasses.field(default_factory=list)

    def bytes(self):
        """The memory that the arrays take."""
        arrays = [self.positions, self.triangles, self.normals, self.parts, *(a.values for a in self.attributes)]
        return sum(array.nbytes for array in arrays if array is not None)

    def positions_from(self, place):
        """The positions as float32, relative to `place` instead of `origin`."""
        shift = self.origin - np.asarray(place, dtype=np.float64)
        if not shift.any():
            return self.positions
        return (self.positions + shift).astype(np.float32)

    def turned_from_y_up(self):
        """The surface with z up, as Blender has it: (x, y, z) becomes (x, -z, y)."""
        return dataclasses.replace(
            self,
            positions=y_up_to_z_up(self.positions),
            origin=y_up_to_z_up(self.origin),
            normals=None if self.normals is None else y_up_to_z_up(self.normals),
            attributes=[attribute.turned_from_y_up() for attribute in self.attributes],
        )


def y_up_to_z_up(vectors):
    # 0 - z, and not -z, which makes -0 of 0.
    return np.stack([vectors[..., 0], 0 - vectors[..., 2], vectors[..., 1]], axis=-1)


def checked_triangles(corners, vertex_count, path):
    """Corners as int32 triangles; damaged ones would bring Blender down."""
    triangles = np.ascontiguousarray(corners).reshape(-1, 3)
    if triangles.size and (triangles.min() < 0 or triangles.max() >= vertex_count):
        raise UnreadableFile(f"{path}: a triangle has a corner that is none of the {vertex_count} vertices")
    return triangles.astype(np.int32)


def linear_from_srgb(values):
    """Colors from 0 to 1 as screens have them, made linear; alpha, the fourth component, is linear already."""
    result = np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4).astype(np.float32)
    result[:, 3:] = values[:, 3:]
    return result
