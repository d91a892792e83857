"""Vectors, points and normals change with the placement of the mesh; scalars and colors do not."""

import json
import math
import pathlib
import re
import struct
import unittest

from support import DATA, PROGRAM, ProgramTest, main, needs_data, read_glb
from attribute_files_test import nrrd
from attributes_test import Glb, columns

PLUGINS = pathlib.Path(PROGRAM).parent / "plugins"
GAS = DATA / "vdb/c42_gas_seq/fluid_data_0008.vdb"
SPEED = (1.0, 2.0, 3.0)
TO_Y_UP = ((1, 0, 0), (0, 0, 1), (0, -1, 0))
TO_Z_UP = ((1, 0, 0), (0, 0, -1), (0, 1, 0))
SAME = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


def times(matrix, vector, factor=1.0):
    return [factor * sum(row[c] * vector[c] for c in range(3)) for row in matrix]


def unit(vector):
    return [c / math.hypot(*vector) for c in vector]


def bgeo(attributes):
    """Houdini's old format: points of a grid; of each attribute (name, type, value) the same value everywhere."""
    places = [(0.5 * i, 0.5 * j, 0.5 * k) for i in range(4) for j in range(4) for k in range(4)]
    data = b"BgeoV" + struct.pack(">9I", 5, len(places), 0, 0, 0, len(attributes), 0, 0, 0)
    for name, kind, value in attributes:
        data += struct.pack(">H", len(name)) + name.encode() + struct.pack(">HI", len(value), kind) + bytes(4 * len(value))
    for place in places:
        data += struct.pack(">4f", *place, 1) + b"".join(struct.pack(f">{len(value)}f", *value) for _, _, value in attributes)
    return data


class KindsTest(ProgramTest):
    def write_particles(self, names=("v", "N", "rest", "Cd", "dir"), value=SPEED):
        """Particles of one velocity, as a table; of all other attributes the numbers are the same."""
        places = [(0.5 * i, 0.5 * j, 0.5 * k) for i in range(4) for j in range(4) for k in range(4)]
        rows = ["x,y,z," + ",".join(f"{name}:{c}" for name in names for c in range(3))]
        rows += [",".join(str(number) for number in (*place, *(value * len(names)))) for place in places]
        (self.folder / "in.csv").write_text("\n".join(rows) + "\n")

    def values(self, name, *arguments, source="in.csv"):
        """The one value of an attribute; all vertices have it."""
        self.done = self.convert(source, "--radius", "0.3", *arguments, "--ascii", "-o", "out.ply")
        found = columns(self.folder / "out.ply")
        value = [found[f"{name}_{c}"] for c in range(3)]
        for component in value:
            self.assertLess(max(component) - min(component), 1e-5 * (1 + abs(component[0])))
        return [component[0] for component in value]

    def assert_vector(self, found, wanted, delta=2e-6):
        for a, b in zip(found, wanted):
            self.assertAlmostEqual(a, b, delta=delta * max(1.0, max(map(abs, wanted))))

    def test_a_velocity_turns_from_z_up_to_y_up(self):
        self.write_particles()
        self.convert("in.csv", "--radius", "0.3", "--attribute", "v", "-o", "out.glb")
        for value in Glb((self.folder / "out.glb").read_bytes()).values("_v"):
            self.assert_vector(value, (1, 3, -2))
        for more in (("--draco",), ("--quantize",)):
            self.convert("in.csv", "--radius", "0.3", "--attribute", "v", *more, "-o", "packed.glb")
            run = json.loads(self.convert("compare", "out.glb", "packed.glb", "--json").text)
            self.assertEqual([match["name"] for match in run["attributes"]["both"]], ["v"])

    def test_each_kind_and_each_placement(self):
        """Against the matrices of the options, by formula."""
        self.write_particles()
        names = [word for name in ("v", "N", "rest", "Cd", "dir") for word in ("--attribute", name)]
        for more, matrix, factor in (((), SAME, 1), (("--up-out", "y"), TO_Y_UP, 1), (("--up", "y", "--up-out", "z"), TO_Z_UP, 1),
                                     (("--scale", "2.5"), SAME, 2.5), (("--unit", "cm", "--to-unit", "m"), SAME, 0.01),
                                     (("--unit", "in", "--to-unit", "mm", "--up-out", "y"), TO_Y_UP, 25.4)):
            with self.subTest(more=more):
                wanted = {"v": times(matrix, SPEED, factor), "N": unit(times(matrix, SPEED)),
                          "rest": times(matrix, SPEED, factor), "Cd": SPEED, "dir": SPEED}
                for name, value in wanted.items():
                    self.assert_vector(self.values(name, *names, *more), value)
                self.assertEqual("attribute 'dir'" in self.done.err, bool(more))
                self.assertNotIn("attribute 'v'", self.done.err)

    def test_points_move_and_vectors_do_not(self):
        self.write_particles()
        self.convert("in.csv", "--radius", "0.3", "--attribute", "v", "--attribute", "P=rest", "--scale", "2", "--up-out", "y", "--center",
                     "--ascii", "-o", "out.ply")
        found = columns(self.folder / "out.ply")
        record = json.loads(re.search(r"comment placement (.*)", (self.folder / "out.ply").read_text()).group(1))
        self.assertEqual(record["attributes"], {"v": "vector", "P": "point"})
        self.assertGreater(math.hypot(*record["moved_by"]), 1)
        wanted = [a + b for a, b in zip(times(TO_Y_UP, SPEED, 2), record["moved_by"])]
        self.assert_vector([found[f"P_{c}"][0] for c in range(3)], wanted)
        self.assert_vector([found[f"v_{c}"][0] for c in range(3)], times(TO_Y_UP, SPEED, 2))

    def test_kinds_that_are_chosen(self):
        self.write_particles()
        turned = times(TO_Y_UP, SPEED, 2)
        for word, name, wanted in (("dir:vector", "dir", turned), ("v:scalar", "v", SPEED), ("v:color", "v", SPEED),
                                   ("w=dir:normal", "w", unit(turned)), ("w=v", "w", turned), ("Cd:point", "Cd", turned)):
            self.assert_vector(self.values(name, "--attribute", word, "--scale", "2", "--up-out", "y"), wanted)
        for word, part in (("v:vectr", "did you mean 'vector'?"), ("v:vector:point", "found a second one")):
            self.assert_fails(1, self.run_program("in.csv", "--attribute", word, "-o", "a.ply"), part)
        self.assert_fails(1, self.run_program("in.csv", "--color-by", "v:vector", "-o", "a.ply"), "'vector' has no effect")
        self.assert_fails(1, self.run_program("in.csv", "--radius", "0.3", "--attribute", "a=v:0:vector", "-o", "a.ply"),
                          "expected three components of a vector, found 1")

    def test_voxel_coordinates(self):
        """A vector of the world, along the axes of the voxels and in voxels."""
        self.write_particles()
        self.convert("in.csv", "--radius", "0.3", "--cell-size", "0.5", "--attribute", "v", "--space", "index", "--report", "r.json", "-o",
                     "out.ply")
        report = json.loads((self.folder / "r.json").read_text())
        self.assert_vector(self.values("v", "--cell-size", "0.5", "--attribute", "v", "--space", "index"),
                           [c / (0.3 * 0.5) for c in SPEED])
        (record,) = report["attributes"]
        self.assertEqual((record["kind"], record["changed"]), ("vector", True))

    def test_colors_go_by_the_values_of_the_input(self):
        self.write_particles()
        for more in ((), ("--scale", "10"), ("--unit", "mm", "--to-unit", "m", "--up-out", "y")):
            run = self.convert("in.csv", "--radius", "0.3", "--color-by", "v:gray:0,7.483314773547883", *more, "--ascii", "-o", "out.ply")
            self.assertIn("gray from 0 to 7.48331", run.err)
            self.assertEqual(set(columns(self.folder / "out.ply")["red"]), {128.0})

    def test_the_report(self):
        self.write_particles()
        for more, changed in ((("-o", "a.ply"), False), (("-o", "a.glb"), True)):
            self.convert("in.csv", "--radius", "0.3", "--attribute", "v", "--attribute", "Cd", "--attribute", "N", "--report", "r.json", *more)
            found = [(a["name"], a["kind"], a["changed"]) for a in json.loads((self.folder / "r.json").read_text())["attributes"]]
            self.assertEqual(found, [("v", "vector", changed), ("Cd", "color", False), ("N", "normal", changed)])

    def test_compare_and_verify(self):
        """A mesh that was turned and scaled has the same attributes as one that was not, in the world of both."""
        self.write_particles()
        words = [word for name in ("v", "N", "rest", "Cd", "s=dir:scalar") for word in ("--attribute", name)]
        self.convert("in.csv", "--radius", "0.3", *words, "-o", "a.ply")
        for name, more in (("b.glb", ()), ("c.ply", ("--scale", "2")), ("d.drc", ("--up-out", "y")), ("e.ply", ("--up-out", "y")),
                           ("f.ply", ("--scale", "0.01")), ("g.glb", ("--unit", "cm")), ("h.ply", ("--center",)),
                           ("i.glb", ("--unit", "in", "--to-unit", "mm", "--center"))):
            self.convert("in.csv", "--radius", "0.3", *words, *more, "-o", name)
            found = json.loads(self.convert("compare", "a.ply", name, "--json").text)["attributes"]
            self.assertEqual({match["name"] for match in found["both"]}, {"v", "N", "rest", "Cd", "s"})
            if not name.endswith(".drc"):
                self.assertTrue(found["same_vertices"], name)
                for match in found["both"]:
                    self.assertLess(match["difference"]["largest"], 1e-6, (name, match))
        self.convert("in.csv", "--radius", "0.3", "--attribute", "v", "-o", "turned.glb")
        run = self.convert("verify", "in.csv", "--radius", "0.3", "--iso", "auto", "turned.glb")
        self.assertIn("verify does not check", run.err)

    def test_old_files_keep_what_they_have(self):
        """Files of ours that say nothing of kinds hold values that were not turned."""
        self.write_particles()
        self.convert("in.csv", "--radius", "0.3", "--attribute", "v:scalar", "-o", "old.glb")
        self.convert("in.csv", "--radius", "0.3", "--attribute", "v:scalar", "-o", "old.ply")
        found = json.loads(self.convert("compare", "old.ply", "old.glb", "--json").text)["attributes"]
        self.assertEqual([match["difference"]["largest"] for match in found["both"]], [0])

    def test_other_programs_files(self):
        """Names say the kind of what other programs wrote."""
        self.write_particles()
        self.convert("in.csv", "--radius", "0.3", "--attribute", "v", "--ascii", "-o", "a.ply")
        text = (self.folder / "a.ply").read_text()
        head, body = text.split("end_header\n")
        names = [line.split()[-1] for line in head.splitlines() if line.startswith("property float")]
        lines = body.splitlines()
        count = int(re.search(r"element vertex (\d+)", head).group(1))
        for i in range(count):
            row = dict(zip(names, lines[i].split()))
            turned = {**row, "y": row["z"], "z": str(0 - float(row["y"])), "v_1": row["v_2"], "v_2": str(0 - float(row["v_1"]))}
            lines[i] = " ".join(turned[name] for name in names)
        other = "".join(line + "\n" for line in head.splitlines() if not line.startswith("comment"))
        (self.folder / "other.ply").write_text(other + "end_header\n" + "\n".join(lines) + "\n")
        self.convert("in.csv", "--radius", "0.3", "--attribute", "v", "--up-out", "y", "-o", "turned.ply")
        for first, second in (("turned.ply", "other.ply"), ("other.ply", "turned.ply")):
            found = json.loads(self.convert("compare", first, second, "--json").text)["attributes"]
            self.assertEqual([match["difference"]["largest"] for match in found["both"]], [0], found)

    def test_houdinis_types(self):
        """In its old format vectors have a type of their own; N is a normal by its name alone."""
        data = bgeo([("dir", 5, SPEED), ("N", 5, SPEED), ("Cd", 0, SPEED), ("speed3", 0, SPEED)])
        (self.folder / "in.bgeo").write_bytes(data)
        turned = times(TO_Y_UP, SPEED, 2)
        for name, wanted in (("dir", turned), ("N", unit(turned)), ("Cd", SPEED), ("speed3", SPEED)):
            found = self.values(name, "--attribute", name, "--scale", "2", "--up", "z", "--up-out", "y", source="in.bgeo")
            self.assert_vector(found, wanted)

    @unittest.skipUnless((PLUGINS / "isoextract-particles-vtk.so").exists(), "the plug-in around VTK was not built")
    def test_what_vtk_files_mark(self):
        """One array as the vectors of the file, and one as its normals, whatever they are called."""
        places = [(0.5 * i, 0.5 * j, 0.5 * k) for i in range(4) for j in range(4) for k in range(4)]
        rows = "\n".join("{} {} {}".format(*place) for place in places)
        same = "\n".join(["{} {} {}".format(*SPEED)] * len(places))
        (self.folder / "in.vtk").write_text(
            f"# vtk DataFile Version 3.0\nparticles\nASCII\nDATASET POLYDATA\nPOINTS {len(places)} float\n{rows}\n"
            f"POINT_DATA {len(places)}\nVECTORS dir float\n{same}\nNORMALS side float\n{same}\n"
            f"FIELD more 1\nother 3 {len(places)} float\n{same}\n")
        turned = times(TO_Y_UP, SPEED, 2)
        for name, wanted in (("dir", turned), ("side", unit(turned)), ("other", SPEED)):
            self.assert_vector(self.values(name, "--attribute", name, "--scale", "2", "--up-out", "y", source="in.vtk"), wanted)

    def test_animations(self):
        for k in range(2):
            self.write_particles(value=(1.0 + k, 2.0, 3.0))
            (self.folder / "in.csv").rename(self.folder / f"in_{k}.csv")
        run = self.convert("in_{}.csv", "--radius", "0.3", "--attribute", "v", "--animate", "-o", "all.glb")
        self.assertNotIn("placement", run.err)
        glb = Glb((self.folder / "all.glb").read_bytes())
        self.assertEqual(glb.model["asset"]["extras"]["placement"]["attributes"], {"v": "vector"})
        for k in range(2):
            for value in glb.values("_v", k):
                self.assert_vector(value, (1 + k, 3, -2))

    @unittest.skipUnless((PLUGINS / "isoextract-volume-openvdb.so").exists(), "the plug-ins around OpenVDB were not built")
    @needs_data("vdb/c42_gas_seq/fluid_data_0008.vdb")
    def test_grids_of_vectors(self):
        plain = ("--attribute", "v=velocity")
        volume = (GAS, "--grid", "density", "--iso", "0.5")
        self.convert(*volume, *plain, "--ascii", "-o", "a.ply")
        wanted = columns(self.folder / "a.ply")
        for more, matrix, factor in ((("--up-out", "y"), TO_Y_UP, 1), (("--scale", "3"), SAME, 3)):
            self.convert(*volume, *plain, *more, "--ascii", "-o", "b.ply")
            found = columns(self.folder / "b.ply")
            for old, new in zip(zip(*(wanted[f"v_{c}"] for c in range(3))), zip(*(found[f"v_{c}"] for c in range(3)))):
                # Float32 rounds the places of the vertices, 4e-6 at 64, where the velocity grows by 60 a voxel of 0.8.
                self.assert_vector(new, times(matrix, old, factor), delta=factor * 3e-4)

    @unittest.skipUnless((PLUGINS / "isoextract-volume-openvdb.so").exists(), "the plug-ins around OpenVDB were not built")
    @needs_data("vdb/c42_gas_seq/fluid_data_0008.vdb")
    def test_mirrored_worlds(self):
        """A frame of left-anterior-superior axes is mirrored into RAS, and vectors with it."""
        (self.folder / "ball.nrrd").write_bytes(nrrd(lambda i, j, k: 3.3 - math.dist((i, j, k), (4, 3.6, 3.1)),
                                                     "space: left-anterior-superior", "space directions: (1,0,0) (0,1,0) (0,0,1)",
                                                     "space origin: (50,70,15)"))  # in the smoke
        for name, more in (("a.ply", ()), ("b.ply", ("--to-space", "ras"))):
            self.convert("ball.nrrd", "--iso", "0", "--attribute", f"v={GAS}[velocity]", *more, "--ascii", "-o", name)
        first, second = (columns(self.folder / name) for name in ("a.ply", "b.ply"))
        self.assertTrue(any(first["v_0"]))
        self.assertEqual(sorted(zip(first["x"], first["v_0"], first["v_1"], first["v_2"])),
                         sorted((0 - x, 0 - a, b, c) for x, a, b, c in zip(second["x"], second["v_0"], second["v_1"], second["v_2"])))


if __name__ == "__main__":
    main()
