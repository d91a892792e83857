#!/usr/bin/python3
"""Compares the figures of --error with the true distances, found without a line of isoextract's code.

    scripts/compare_error.py [--isoextract PROGRAM] [--fields NAME,...] [--sizes N,...] [--methods NAME,...] [--json FILE]

Eight fields are sampled at several resolutions and extracted by every method. The true isosurface is a cloud of its
points on lines along the axes, found by bisection, five lines a cell. From the cloud's points nearest to a position,
steps along the surface lead to the foot. For the other direction, the script measures the distance from each point of
the cloud to the triangles of the file. All figures are in voxels. Prints a line for each mesh and direction, and ends
with 1 if a figure is more than a tenth off.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "support"))
import mesh_readers  # noqa: E402

METHODS = ("mc", "mt", "voxels", "surface-nets")
SIZES = (9, 12, 18, 24)
LINES = 5  # in each cell along each axis, at least
ALLOWED = 0.1
ON_SURFACE = 2e-3


def hypot(*parts):
    return numpy.sqrt(sum(part * part for part in parts))


def gyroid(x, y, z):
    k = 4 * numpy.pi
    return numpy.sin(k * x) * numpy.cos(k * y) + numpy.sin(k * y) * numpy.cos(k * z) + numpy.sin(k * z) * numpy.cos(k * x)


def marschner_lobb(x, y, z):
    ring = numpy.cos(12 * numpy.pi * numpy.cos(numpy.pi * hypot(x, y) / 2))
    return (1 - numpy.sin(numpy.pi * z / 2) + 0.25 * (1 + ring)) / 2.5


def metaballs(x, y, z):
    balls = ((-0.35, -0.2, 0.1, 0.35), (0.3, -0.3, -0.15, 0.3), (0.1, 0.35, 0.2, 0.32), (-0.15, 0.1, -0.45, 0.22),
             (0.45, 0.2, 0.45, 0.18))
    return sum(r * r / ((x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2 + 0.01) for a, b, c, r in balls) - 1


def turbulence(x, y, z):
    """Waves of random directions; longer waves have larger amplitudes."""
    random = numpy.random.default_rng(3)
    total = 0
    for _ in range(60):
        wave = random.normal(size=3) * random.uniform(2, 8)
        total = total + numpy.sin(wave[0] * x + wave[1] * y + wave[2] * z + random.uniform(0, 7)) / hypot(*wave)
    return total


class Field:
    def __init__(self, name, iso, formula=None, demo=False):
        self.name, self.iso, self.formula, self.demo = name, iso, formula, demo

    def samples(self, size):
        """In the order z, y, x, as float32."""
        if self.formula is None:
            return numpy.random.default_rng(5).uniform(-1, 1, (size, size, size)).astype("f4")
        axis = numpy.linspace(-1, 1, size)
        z, y, x = numpy.meshgrid(axis, axis, axis, indexing="ij")
        return self.formula(x, y, z).astype("f4")


FIELDS = (
    Field("sphere", 0, lambda x, y, z: 0.7 - hypot(x, y, z), True),
    Field("torus", 0, lambda x, y, z: 0.25 - hypot(hypot(x, y) - 0.6, z), True),
    Field("gyroid", 0, gyroid, True),
    Field("marschner-lobb", 0.5, marschner_lobb, True),
    Field("metaballs", 0, metaballs, True),
    Field("octahedron", 0, lambda x, y, z: 0.81 - abs(x) - abs(y) - abs(z)),
    Field("turbulence", 0.02, turbulence),
    Field("random", 0.05),
)


class Trilinear:
    """The interpolant of samples, in index space."""

    beyond = 0

    def __init__(self, samples):
        self.samples = samples.astype("f8")
        self.last = numpy.array(samples.shape[::-1]) - 1

    def value(self, points):
        cell = numpy.clip(numpy.floor(points).astype(int), 0, self.last - 1)
        t = points - cell
        total = 0
        for corner in range(8):
            on = numpy.array((corner & 1, corner >> 1 & 1, corner >> 2 & 1))
            weight = numpy.prod(numpy.where(on, t, 1 - t), axis=1)
            x, y, z = (cell + on).T
            total = total + weight * self.samples[z, y, x]
        return total


class Formula:
    """A formula, in the index space of samples on the cube from -1 to 1."""

    beyond = 1e-6  # voxels

    def __init__(self, formula, size):
        self.formula, self.last, self.step = formula, numpy.full(3, size - 1), 2 / (size - 1)

    def value(self, points):
        return self.formula(*(points * self.step - 1).T)


class Surface:
    """Points of an isosurface, and the nearest one of any position."""

    def __init__(self, function, iso, lines):
        self.function, self.iso = function, iso
        between = [self.on_lines(axis, lines) for axis in range(3)]
        self.even = sum(map(len, between))  # number of evenly dense points; lines through samples follow
        # A small component may cross no lines except those through samples.
        self.points = numpy.concatenate(between + [self.on_lines(axis, 1, True) for axis in range(3)])
        self.spacing = 1 / lines
        self.buckets = Buckets(self.points, numpy.arange(len(self.points)), function.last)

    def residual(self, points):
        return self.function.value(points) - self.iso

    def on_lines(self, axis, lines, through_samples=False):
        """Points where lines along an axis cross iso: half a spacing off the planes of samples, or through samples.
        Lines of a formula end `beyond` voxels outside the grid: a side may be iso by the formula but not by samples."""
        last = self.function.last
        across = [numpy.arange(last[a] + 1.0) if through_samples else (numpy.arange(last[a] * lines) + 0.5) / lines
                  for a in range(3) if a != axis]
        along = numpy.linspace(0, last[axis], last[axis] * lines + 1)
        along[[0, -1]] += -self.function.beyond, self.function.beyond
        u, v, w = numpy.meshgrid(*across, along, indexing="ij")
        columns = [u, v]
        columns.insert(axis, w)
        grid = numpy.stack(columns, axis=-1)
        above = (self.residual(grid.reshape(-1, 3)) > 0).reshape(w.shape)
        i, j, k = numpy.nonzero(above[:, :, 1:] != above[:, :, :-1])
        low, high, low_above = grid[i, j, k], grid[i, j, k + 1], above[i, j, k]
        for _ in range(40):
            middle = (low + high) / 2
            same = (self.residual(middle) > 0) == low_above
            low, high = numpy.where(same[:, None], middle, low), numpy.where(same[:, None], high, middle)
        return (low + high) / 2

    def gradient(self, points):
        h = 1e-5
        return numpy.stack([(self.function.value(points + h * e) - self.function.value(points - h * e)) / (2 * h)
                            for e in numpy.eye(3)], axis=1)

    def land(self, points):
        """Moves points to iso by Newton's method. Returns them, and which of them converged within two spacings."""
        start, near = points.copy(), numpy.zeros(len(points), bool)
        for _ in range(4):
            gradient, residual = self.gradient(points), self.residual(points)
            squared = numpy.maximum((gradient ** 2).sum(1), 1e-300)
            step = -gradient * (residual / squared)[:, None]
            points = numpy.clip(points + step, 0, self.function.last)
            near = (hypot(*step.T) < 1e-6) & (hypot(*(points - start).T) < 2 * self.spacing)
        return points, near

    def distances(self, places, starts=3):
        """Distances to the surface: moves from the cloud's nearest points along the surface while that comes nearer."""
        best = numpy.full(len(places), numpy.inf)
        found = self.buckets.nearest(places, lambda p, n: ((p - self.points[n]) ** 2).sum(-1), starts)
        for column in found.T:
            has = column >= 0
            place, point = places[has], self.points[column[has]]
            distance = hypot(*(place - point).T)
            step = numpy.ones(len(place))
            for _ in range(7):
                normal = self.gradient(point)
                normal /= numpy.maximum(hypot(*normal.T), 1e-300)[:, None]
                away = place - point
                slide = away - normal * (away * normal).sum(1)[:, None]
                length = numpy.maximum(hypot(*slide.T), 1e-300)
                moved, there = self.land(point + slide * (step * numpy.minimum(1, self.spacing / length))[:, None])
                nearer = there & (hypot(*(place - moved).T) < distance)
                point = numpy.where(nearer[:, None], moved, point)
                distance = hypot(*(place - point).T)
                step = numpy.where(nearer, step, step / 2)
            best[has] = numpy.minimum(best[has], distance)
        return best


class Buckets:
    """Indices of elements by the cell of their position. Finds the elements nearest to a position in nearby cells."""

    FARTHEST = 4  # cells

    def __init__(self, places, elements, last):
        self.dims = last + 2 * self.FARTHEST + 3
        cells = self.number(numpy.floor(places).astype(int))
        order = numpy.argsort(cells, kind="stable")
        self.elements = elements[order]
        self.first = numpy.searchsorted(cells[order], numpy.arange(self.dims.prod() + 1))

    def number(self, cells):
        x, y, z = numpy.clip(cells + self.FARTHEST + 1, 0, self.dims - 1).T
        return x + self.dims[0] * (y + self.dims[1] * z)

    def nearest(self, places, squared, count, slack=0):
        """Indices of the `count` nearest elements, or -1. An element is within `slack` of its position."""
        result = numpy.full((len(places), count), -1)
        left = numpy.arange(len(places))
        for ring in range(1, self.FARTHEST + 1):
            found, distance = self.nearest_in_ring(places[left], squared, count, ring)
            result[left] = found
            left = left[~(distance <= max(ring - slack, 0) ** 2)]
        return result

    def nearest_in_ring(self, places, squared, count, ring):
        result, least = numpy.full((len(places), count), -1), numpy.full(len(places), numpy.inf)
        steps = range(-ring, ring + 1)
        steps = numpy.array([(i, j, k) for i in steps for j in steps for k in steps])
        cells = numpy.floor(places).astype(int)
        at_once = max(8, 4000 // len(steps))
        for first in range(0, len(places), at_once):
            part = places[first:first + at_once]
            near = numpy.stack([self.number(cells[first:first + at_once] + step) for step in steps], axis=1)
            counts = self.first[near + 1] - self.first[near]
            total = counts.sum(1)
            if not total.any():
                continue
            rows = numpy.repeat(numpy.arange(len(part)), total)
            flat = counts.ravel()
            inside = numpy.arange(flat.sum()) - numpy.repeat(numpy.cumsum(flat) - flat, flat)
            elements = self.elements[numpy.repeat(self.first[near].ravel(), flat) + inside]
            distance = squared(part[rows], elements)
            order = numpy.lexsort((distance, rows))
            rank = numpy.arange(len(order)) - numpy.repeat(numpy.cumsum(total) - total, total)
            keep = rank < count
            result[first + rows[order][keep], rank[keep]] = elements[order][keep]
            least[first + rows[order][rank == 0]] = distance[order][rank == 0]
        return result, least


def squared_to_triangles(p, a, b, c):
    """Squared distances of points to triangles, row by row: to the plane where the foot is within, else to the sides."""

    def to_segment(p, a, b):
        along = b - a
        t = ((p - a) * along).sum(-1) / numpy.maximum((along ** 2).sum(-1), 1e-300)
        return ((p - a - numpy.clip(t, 0, 1)[..., None] * along) ** 2).sum(-1)

    normal = numpy.cross(b - a, c - a)
    length = numpy.maximum((normal ** 2).sum(-1), 1e-300)
    within = numpy.ones(p.shape[:-1], bool)
    for u, v in ((a, b), (b, c), (c, a)):
        within &= (numpy.cross(normal, v - u) * (p - u)).sum(-1) >= 0
    plane = ((p - a) * normal).sum(-1) ** 2 / length
    sides = numpy.minimum(numpy.minimum(to_segment(p, a, b), to_segment(p, b, c)), to_segment(p, c, a))
    return numpy.where(within, plane, sides)


class Triangles:
    """The triangles of a mesh, bisected until no side is longer than a third of a cell."""

    def __init__(self, corners):
        small = []
        while len(corners):
            sides = hypot(*numpy.moveaxis(corners[:, (1, 2, 0)] - corners, -1, 0))
            large = sides.max(1) > 1 / 3
            small.append(corners[~large])
            first = sides[large].argmax(1)
            corners = corners[large]
            rows = numpy.arange(len(corners))
            a, b, c = (corners[rows, (first + k) % 3] for k in range(3))
            middle = (a + b) / 2
            corners = numpy.concatenate([numpy.stack([a, middle, c], 1), numpy.stack([middle, b, c], 1)])
        self.corners = numpy.concatenate(small)
        self.areas = hypot(*numpy.cross(self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0]).T) / 2

    def sample(self, count, random):
        """Points spread evenly over the area."""
        share = numpy.cumsum(self.areas) / self.areas.sum()
        which = numpy.searchsorted(share, (numpy.arange(count) + random.uniform(size=count)) / count)
        a, b, c = numpy.moveaxis(self.corners[numpy.minimum(which, len(share) - 1)], 1, 0)
        u, v = random.uniform(size=(2, count, 1))
        u, v = numpy.where(u + v > 1, 1 - u, u), numpy.where(u + v > 1, 1 - v, v)
        return a + u * (b - a) + v * (c - a)

    def distances(self, places, last):
        buckets = Buckets(self.corners.mean(1), numpy.arange(len(self.corners)), last)
        found = buckets.nearest(places, lambda p, n: squared_to_triangles(p, *numpy.moveaxis(self.corners[n], 1, 0)), 1,
                                0.25)[:, 0]
        distances = numpy.sqrt(squared_to_triangles(places, *numpy.moveaxis(self.corners[found], 1, 0)))
        return numpy.where(found < 0, numpy.inf, distances)


def rms(distances, weights=None):
    return float(numpy.sqrt(numpy.average(distances ** 2, weights=weights)))


class Truth:
    """The true surfaces of one field at one resolution."""

    def __init__(self, field, size):
        self.field, self.size, self.array = field, size, field.samples(size)
        self.surface = Surface(Trilinear(self.array), field.iso, LINES)
        self.formula = None
        if field.demo:
            self.formula = Surface(Formula(field.formula, size), field.iso, max(LINES, -(-150 // size)))

    def from_mesh(self, surface, corners, count, worst):
        """Root mean square and greatest distance of a mesh. Points beyond the samples have no true distance. Includes
        `worst`, the farthest point according to the report, if it is on the mesh."""
        triangles = Triangles(corners)
        last = surface.function.last
        places = triangles.sample(count, numpy.random.default_rng(1))
        # Corners and centers of triangles are the most likely farthest points.
        extremes = numpy.concatenate([corners.reshape(-1, 3), corners.mean(1)])
        extremes = extremes[:: max(1, 2 * len(extremes) // count)]
        inside = [((p >= 0) & (p <= last)).all(1) for p in (places, extremes)]
        even = surface.distances(places[inside[0]])
        extremes = extremes[inside[1]]
        if triangles.distances(worst[None], last)[0] < ON_SURFACE:
            extremes = numpy.concatenate([extremes, worst[None]])
        return rms(even), float(max(even.max(), surface.distances(extremes).max()))

    def to_mesh(self, corners, count, worst):
        """Figures of the points on lines; their density on the surface is the sum of its normal's components."""
        points = self.surface.points[:self.surface.even]
        points = points[numpy.random.default_rng(2).permutation(len(points))[:count]]
        normal = numpy.abs(self.surface.gradient(points))
        weights = hypot(*normal.T) / numpy.maximum(normal.sum(1), 1e-300)
        triangles, last = Triangles(corners), self.surface.function.last
        distances = triangles.distances(points, last)
        farthest = distances.max()
        if self.surface.distances(worst[None])[0] < ON_SURFACE:
            farthest = max(farthest, triangles.distances(worst[None], last)[0])
        return rms(distances, weights), float(farthest)


def told(program, source, iso, method, folder):
    """The triangles' corners in index space, and the error in the report."""
    done = subprocess.run([program, source, "--iso", str(iso), "--method", method, "--error", "--space", "index", "-q",
                           "-o", "mesh.ply", "--report", "report.json"], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{source} by {method}: {done.stderr}")
    (mesh,) = mesh_readers.read(folder / "mesh.ply")
    corners = numpy.array(mesh.vertices, "f8")[numpy.array(mesh.triangles)]
    error = json.loads((folder / "report.json").read_text())["meshes"][0].get("error")
    if error is None:
        raise RuntimeError(f"{source} by {method}: its error was not measured")
    return corners, error


def rows_of(program, field, size, methods, folder, count):
    """A row a mesh and direction: (direction, method, told rms, true rms, told maximum, true maximum, at most)."""
    truth = Truth(field, size)
    numpy.save(folder / "field.npy", truth.array)
    for method in methods:
        corners, error = told(program, "field.npy", field.iso, method, folder)

        def row(direction, true, figures, bounded):
            figures = [part[key]["voxels"] for part, key in ((figures, "rms"), (figures, "max"), bounded)]
            return (direction, method, figures[0], true[0], figures[1], true[1], figures[2])

        interior, coverage = error["interior"], error["coverage"]
        true = truth.from_mesh(truth.surface, corners, count, numpy.array(interior["worst"]))
        yield row("mesh to surface", true, interior, (interior, "max"))
        bounded = (coverage, "max_at_most") if "max_at_most" in coverage else (coverage["distances"], "max")
        true = truth.to_mesh(corners, count, numpy.array(coverage["distances"]["worst"]))
        yield row("surface to mesh", true, coverage["distances"], bounded)
        if truth.formula is None:
            continue
        corners, error = told(program, f"demo:{field.name}?size={size}", field.iso, method, folder)
        interior = error["analytic"]["interior"]
        true = truth.from_mesh(truth.formula, corners, count, numpy.array(interior["worst"]))
        yield row("mesh to formula", true, interior, (interior, "max"))


def is_true(row):
    """Whether the rms is right to a tenth, and the maximum and the reported bound are at most a tenth off."""
    _, _, told_rms, true_rms, told_max, true_max, at_most = row
    floor = 1e-5  # rounding of float32
    return (abs(told_rms - true_rms) <= ALLOWED * true_rms + floor and true_max <= (1 + ALLOWED) * at_most + floor and
            told_max <= (1 + ALLOWED) * true_max + floor)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--isoextract", default=str(ROOT / "build" / "release" / "isoextract"))
    parser.add_argument("--fields", default=",".join(field.name for field in FIELDS))
    parser.add_argument("--sizes", default=",".join(map(str, SIZES)))
    parser.add_argument("--methods", default=",".join(METHODS))
    parser.add_argument("--points", type=int, default=1500, help="that are measured of each mesh")
    parser.add_argument("--json")
    options = parser.parse_args()
    chosen = options.fields.split(",")
    program = str(pathlib.Path(options.isoextract).resolve())
    wrong, lines = 0, []
    print(f"{'field':<16}{'size':>5} {'method':<13}{'direction':<17}{'rms told':>10}{'true':>10}{'max told':>10}{'true':>10}"
          f"{'at most':>10}")
    with tempfile.TemporaryDirectory(prefix="isoextract-error-") as folder:
        for field in (field for field in FIELDS if field.name in chosen):
            for size in map(int, options.sizes.split(",")):
                for row in rows_of(program, field, size, options.methods.split(","), pathlib.Path(folder), options.points):
                    direction, method, *figures = row
                    right = is_true(row)
                    wrong += not right
                    lines.append({"field": field.name, "size": size, "direction": direction, "method": method, "true": right,
                                  "figures": figures})
                    print(f"{field.name:<16}{size:>5} {method:<13}{direction:<17}" +
                          "".join(f"{figure:>10.4f}" for figure in figures) + ("" if right else "  WRONG"), flush=True)
    print(f"{len(lines) - wrong} of {len(lines)} are true")
    if options.json:
        pathlib.Path(options.json).write_text(json.dumps(lines, indent=1) + "\n")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
