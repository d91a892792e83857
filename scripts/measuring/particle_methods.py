"""Surfaces of liquids by each method: volume, area, roughness and crawl on sets whose shape is known, and on a FLIP frame."""

import array
import dataclasses
import json
import math
import random
import struct

from measuring import processes, programs, record
from measuring.particles import apart, as_ply
from measuring.tables import number, percent, table

import particle_clouds as clouds  # of tests/support, where `processes` looks for modules

NAME = "particle-methods"
TITLE = "Particles: volume, area, roughness and crawl by method"
# Rows: their options after --particles, and all options.
METHODS = {" ".join(options): ["--particles", *options] for options in (
    ["sph"], ["sph", "--smooth", "25:weighted"], ["sph", "--smoothing-length", "3"], ["anisotropic"], ["weight"], ["spheres"],
    ["smooth"])}
SHIFT = (0.3, 0.45, 0.2)  # of a cell, between the two surfaces of the crawl
RIM = 4  # radii: vertices nearer than this to an edge of the box do not count as roughness, as kernels round edges
BOX = (25, 19, 13)  # particles along the axes
FLIP = "flip_quickliquid/flip_0020.ply"
FLIP_RADIUS = 0.024  # a quarter of the cells, which have eight particles each


@dataclasses.dataclass
class Shape:
    """A set of particles of radius 1 and the surface that bounds its volume, of 8 for each particle."""

    name: str
    about: str
    points: list
    kind: str | None = None  # "ball" or "box"; None if the surface is not known
    radius: float = 1
    file: str = ""

    def volume(self):
        return 8 * len(self.points)

    def ball(self):
        return clouds.ball_radius(len(self.points), 1)

    def area(self):
        if self.kind == "ball":
            return 4 * math.pi * self.ball() ** 2
        a, b, c = (2 * n for n in BOX)
        return 2 * (a * b + b * c + c * a)


def points_of(layers):
    flat = array.array("f")
    for layer in layers:
        flat.extend(layer)
    return [tuple(flat[i:i + 3]) for i in range(0, len(flat), 3)]


def lattice_ball(count, jitter):
    size = clouds.ball_radius(count, 1)
    return points_of(clouds.jittered_lattice(1, size, lambda x, y, z: x * x + y * y + z * z <= size * size, jitter))


def lattice_box(jitter):
    return points_of(clouds.jittered_lattice(
        1, max(BOX), lambda *p: all(abs(c) <= n - 0.5 for c, n in zip(p, BOX)), jitter))


def random_ball(count, seed=11):
    draw = random.Random(seed).uniform
    size = clouds.ball_radius(count, 1)
    points = []
    while len(points) < count:
        point = tuple(draw(-size, size) for _ in range(3))
        if sum(c * c for c in point) <= size * size:
            points.append(point)
    return points


def shapes(quick):
    many = 1200 if quick else 7239
    return [
        Shape("small ball", "on a lattice", lattice_ball(524, 0), "ball"),
        Shape("ball", "on a lattice", lattice_ball(many, 0), "ball"),
        Shape("ball, jittered", "on the same lattice, each shifted by up to half a radius along each axis", lattice_ball(many, 0.5), "ball"),
        Shape("ball, as FLIP seeds it", "anywhere in cubes two radii wide, one in each: eight a cell of the simulation", lattice_ball(many, 1),
              "ball"),
        Shape("ball, random", "at independent uniform positions", random_ball(many), "ball"),
        Shape("box", "on a lattice of {} × {} × {}".format(*BOX), lattice_box(0), "box"),
        Shape("box, jittered", "on the same lattice, shifted as those of the ball", lattice_box(0.5), "box"),
    ]


def write_points(path, points, shift=0.0):
    return clouds.write_ply(path, clouds.as_layers([tuple(c + shift * s for c, s in zip(point, SHIFT)) for point in points]))


def from_box(x, y, z):
    """The signed distance from the box's nearest face; None near an edge or beside the box."""
    away = sorted(abs(c) - n for c, n in zip((x, y, z), BOX))
    return away[2] if away[1] < -RIM else None


def area_of(vertices, polygons):
    total = 0.0
    for first, *others in polygons:
        a = vertices[first]
        for b, c in zip(others, others[1:]):
            u = [p - q for p, q in zip(vertices[b], a)]
            v = [p - q for p, q in zip(vertices[c], a)]
            total += math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
    return total / 2


def shape_facts(path, kind, ball):
    """Volume, area and roughness of a mesh, in radii; roughness is the rms of the distances about their mean."""
    vertices, polygons = clouds.polygons_of_ply(path)
    if kind == "ball":
        distances = [math.hypot(*vertex) - ball for vertex in vertices]
    else:
        distances = [d for d in (from_box(*vertex) for vertex in vertices) if d is not None]
    mean = math.fsum(distances) / len(distances)
    rough = math.sqrt(math.fsum((d - mean) ** 2 for d in distances) / len(distances))
    return {"volume": clouds.volume_of(vertices, polygons), "area": area_of(vertices, polygons), "roughness": rough}


def move_back(path, shift):
    """Moves the vertices of a PLY mesh by -shift, in place: binary float32 positions first in each vertex."""
    data = bytearray(path.read_bytes())
    start = data.index(b"end_header\n") + len(b"end_header\n")
    header = data[:start].decode().splitlines()
    count = next(int(line.split()[2]) for line in header if line.startswith("element vertex"))
    kinds = []
    for line in header[header.index(next(line for line in header if line.startswith("element vertex"))) + 1:]:
        if not line.startswith("property"):
            break
        kinds.append(line.split()[1])
    record_of_vertex = struct.Struct("<" + "".join({"float": "f", "double": "d"}[kind] for kind in kinds))
    for v in range(count):
        at = start + v * record_of_vertex.size
        values = list(record_of_vertex.unpack_from(data, at))
        record_of_vertex.pack_into(data, at, *(c - s for c, s in zip(values[:3], shift)), *values[3:])
    path.write_bytes(data)


def measure_method(setting, shape, options, rounds):
    """A row about the surface of the particles, and the surface of the shifted particles."""
    mesh, shifted_mesh = setting.folder / "mesh.ply", setting.folder / "shifted_mesh.ply"
    report = setting.folder / "mesh.json"
    common = ["--radius", f"{shape.radius:g}", *options, "-q"]
    command = [setting.isoextract, setting.folder / shape.file, *common, "-o", mesh]
    times = [processes.run_once([*command, "--report", report]) for _ in range(rounds + 1)][1:]
    cell = json.loads(report.read_text())["particles"]["spacing"]
    shift = [cell * s for s in SHIFT]
    shifted = setting.folder / "shifted.ply"
    write_points(shifted, shape.points, cell)
    programs.run([setting.isoextract, shifted, *common, "-o", shifted_mesh])
    apart(move_back, shifted_mesh, shift)
    apart_by = json.loads(programs.run([setting.isoextract, "compare", "--json", mesh, shifted_mesh]))
    row = {"command": programs.shown(command), "wall": processes.summary([one["wall"] for one in times]),
           "crawl": apart_by["rms"] / shape.radius, "triangles": apart_by["a"]["triangles"]}
    if shape.kind:
        facts = apart(shape_facts, mesh, shape.kind, shape.ball())
        row |= {"volume": facts["volume"] / shape.volume() - 1, "area": facts["area"] / shape.area() - 1,
                "roughness": facts["roughness"]}
    return row


def flip_frame(setting):
    path = setting.data / "particles" / FLIP
    if not path.exists():
        return None
    name = as_ply(setting, path)
    columns = struct.Struct("<6f")
    data = path.read_bytes()
    body = data[data.index(b"end_header\n") + len(b"end_header\n"):]
    points = [values[:3] for values in columns.iter_unpack(body)]
    return Shape("FLIP frame", f"of `{FLIP}`", points, None, FLIP_RADIUS, name)


def measure(setting):
    measured = record.Record(NAME, setting.isoextract, setting.quick)
    rounds = 1 if setting.quick else 3
    sets = shapes(setting.quick)
    for i, shape in enumerate(sets):
        shape.file = f"set_{i}.ply"
        write_points(setting.folder / shape.file, shape.points)
    frame = None if setting.quick else flip_frame(setting)
    figures = {"rounds": rounds, "sets": []}
    for shape in [*sets, *([frame] if frame else [])]:
        rows = [{"method": name} | measure_method(setting, shape, options, rounds) for name, options in METHODS.items()]
        figures["sets"].append({"name": shape.name, "about": shape.about, "particles": len(shape.points), "rows": rows})
    commands = [row["command"] for part in figures["sets"] for row in part["rows"]]
    return measured.finish([record.cores()], {}, commands, figures)


def row_of(row):
    known = row.get("volume") is not None
    return [f"`{row['method']}`", number(row["triangles"]),
            percent(row["volume"]) if known else "–", percent(row["area"]) if known else "–",
            number(row["roughness"], 2) if known else "–", number(row["crawl"], 2), number(row["wall"]["median"])]


def part_of(part):
    heads = ["`--particles`", "triangles:", "volume:", "area:", "roughness, radii:", "crawl, radii:", "whole command, s:"]
    return f"""## {part['name'][0].upper() + part['name'][1:]}

{number(part['particles'])} particles {part['about']}.

{table(heads, [row_of(row) for row in part['rows']])}
"""


def page(measured):
    figures = measured["figures"]
    return f"""Surfaces of particles of radius 1 at each method's default cell size and iso value.

- Volume and area are differences from those of the ball or box that has 8 units of volume (a cube two radii wide) for each particle.
- Roughness is the rms deviation of the vertices' distances to this shape from the mean distance. For the box, vertices within {RIM} radii
  of an edge do not count.
- Crawl is the rms distance between two surfaces. The second one is made of the same particles, shifted by ({', '.join(map(str, SHIFT))}) cells
  along x, y and z, and then moved back. Crawl shows how much a surface flickers while liquid moves through the grid.
- Irregular particles can leave cavities inside, which count in volume, area and roughness. A larger `--smoothing-length` closes them.
- Times are for the whole command on all cores, warm: the median of {figures['rounds']} runs after one that does not count.

{chr(10).join(map(part_of, figures['sets']))}"""
