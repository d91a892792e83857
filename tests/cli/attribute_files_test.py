"""Attributes from other files: where their samples are, which are no data, and what becomes of those that are missing."""

import csv
import json
import math
import pathlib
import struct
import unittest
import zipfile

from attributes_test import Glb, columns
from support import PROGRAM, ProgramTest, main

DIMS = (9, 8, 7)
PLUGIN = pathlib.Path(PROGRAM).parent / "plugins" / "isoextract-volume-openvdb.so"


def ball(i, j, k):
    return 3.3 - math.dist((i, j, k), (4, 3.6, 3.1))


def linear(i, j, k):
    """What `linear.npy` holds, by index: linear interpolation finds it again everywhere."""
    return 0.25 + 2 * i - 3 * j + 0.5 * k


def npy(value_at, dims=DIMS, order="zyx", fortran=False):
    """A NumPy array of floats, indexed [z, y, x] or [x, y, z], in C order or in Fortran's."""
    shape = dims if order == "xyz" else dims[::-1]
    head = f"{{'descr': '<f4', 'fortran_order': {fortran}, 'shape': {tuple(shape)}, }}".encode()
    head += b" " * (-(len(head) + 11) % 64) + b"\n"
    x_is_fastest = (order == "zyx") != fortran
    walk = ([(i, j, k) for k in range(dims[2]) for j in range(dims[1]) for i in range(dims[0])] if x_is_fastest else
            [(i, j, k) for i in range(dims[0]) for j in range(dims[1]) for k in range(dims[2])])
    values = [value_at(*index) for index in walk]
    return b"\x93NUMPY\1\0" + struct.pack("<H", len(head)) + head + struct.pack(f"<{len(values)}f", *values)


def nrrd(value_at, *fields, dims=DIMS):
    head = ["NRRD0004", "type: float", "dimension: 3", "sizes: {} {} {}".format(*dims), "encoding: raw", "endian: little",
            *fields, "", ""]
    values = [value_at(i, j, k) for k in range(dims[2]) for j in range(dims[1]) for i in range(dims[0])]
    return "\n".join(head).encode() + struct.pack(f"<{len(values)}f", *values)


class FilesTest(ProgramTest):
    def write(self, name, data):
        (self.folder / name).write_bytes(data)

    def ply(self, *arguments, iso="0.5"):
        self.done = self.convert(*arguments, "--iso", iso, "--ascii", "-o", "out.ply")
        return columns(self.folder / "out.ply")

    def assert_linear(self, found, index_of, name="a"):
        """The attribute is linear() of the indices that the places come of."""
        self.assertGreater(len(found[name]), 50)
        for *place, value in zip(found["x"], found["y"], found["z"], found[name]):
            wanted = linear(*index_of(place))
            self.assertAlmostEqual(value, wanted, delta=1e-4 * (1 + abs(wanted)))


class PlacementTest(FilesTest):
    """A file that states no placement lies on the grid of the input, where it has its shape."""

    def setUp(self):
        super().setUp()
        self.write("ball.npy", npy(ball))
        self.write("linear.npy", npy(linear))

    def test_a_file_of_another_patient_space_or_unit_is_where_the_patient_is(self):
        """The same samples at the same places of the patient, as LPS in mm, and as RAS in cm with coarser voxels."""
        scan = ("space: left-posterior-superior", "space directions: (2,0,0) (0,3,0) (0,0,1)", "space origin: (-5,7,11)",
                'space units: "mm" "mm" "mm"')
        self.write("scan.nrrd", nrrd(ball, *scan))
        self.write("same.nrrd", nrrd(linear, *scan))
        # RAS mirrors x and y: samples of every other index, from the far ends.
        self.write("dose.nrrd", nrrd(lambda i, j, k: linear(8 - 2 * i, 8 - 2 * j, 2 * k), "space: right-anterior-superior",
                                     "space directions: (0.4,0,0) (0,0.6,0) (0,0,0.2)", "space origin: (-1.1,-3.1,1.1)",
                                     'space units: "cm" "cm" "cm"', dims=(5, 5, 4)))
        index_of = lambda p: ((p[0] + 5) / 2, (p[1] - 7) / 3, p[2] - 11)  # noqa: E731
        found = self.ply("scan.nrrd", "--attribute", "a=same.nrrd", "--attribute", "b=dose.nrrd")
        self.assert_linear(found, index_of)
        self.assert_linear(found, index_of, "b")
        self.assertIn("dose.nrrd states world coordinates in right-anterior-superior, cm; the conversion transforms them to the world of scan.nrrd, "
                      "left-posterior-superior, mm", self.done.err)
        self.assertNotIn("same.nrrd states world coordinates", self.done.err)
        # One that does not say is taken as it is.
        self.write("silent.nrrd", nrrd(linear, "spacings: 2 3 1", "axis mins: -5 7 11"))
        self.ply("scan.nrrd", "--attribute", "a=silent.nrrd")
        self.assertNotIn("the conversion transforms", self.done.err)

    def test_the_same_array_has_the_iso_value_everywhere(self):
        for more in ((), ("--spacing", "0.1"), ("--origin", "5,-3,8"), ("--spacing", "0.1,0.2,0.3", "--origin", "1,2,3")):
            with self.subTest(more=more):
                for value in self.ply("ball.npy", *more, "--attribute", "a=ball.npy")["a"]:
                    self.assertAlmostEqual(value, 0.5, delta=1e-5)
        self.write("x_first.npy", npy(ball, order="xyz"))
        self.write("other.npy", npy(linear, order="xyz"))
        order = ("x_first.npy", "--axis-order", "xyz", "--spacing", "0.1,0.2,0.3")
        for value in self.ply(*order, "--attribute", "a=x_first.npy")["a"]:
            self.assertAlmostEqual(value, 0.5, delta=1e-5)
        self.assert_linear(self.ply(*order, "--attribute", "a=other.npy"),
                           lambda p: (p[0] / 0.1, p[1] / 0.2, p[2] / 0.3))

    def test_wherever_the_mesh_is_put(self):
        """Spacing (0.1, 0.2, 0.3) and origin (1, 2, 3), and then what each option does to the world."""
        def index_of(p):
            return [(c - o) / s for c, o, s in zip(p, (1, 2, 3), (0.1, 0.2, 0.3))]

        undone = {(): lambda p: p, ("--roi", "1,2,3,1.4,3.4,4.8"): lambda p: p, ("--resolution", "15"): lambda p: p,
                  ("--voxel-size", "0.15"): lambda p: p, ("--up-out", "y"): lambda p: [p[0], -p[2], p[1]],
                  ("--scale", "2"): lambda p: [c / 2 for c in p], ("--unit", "mm", "--to-unit", "m"): lambda p: [1000 * c for c in p],
                  ("--simplify", "0.1"): lambda p: p}
        place = ("ball.npy", "--spacing", "0.1,0.2,0.3", "--origin", "1,2,3", "--attribute", "a=linear.npy")
        for more, world_of in undone.items():
            with self.subTest(more=more):
                self.assert_linear(self.ply(*place, *more), lambda p: index_of(world_of(p)))
        self.assert_linear(self.ply(*place, "--space", "index"), lambda p: p)
        self.assertIn("linear.npy states no spacing and no origin: the program places it on the grid of ball.npy, which has "
                      "9 x 8 x 7 samples too\n", self.done.err)

    def test_mirrored_and_oblique_frames(self):
        frames = {"(-1,0,0) (0,2,0) (0,0,1)": lambda p: (5 - p[0], p[1] / 2, p[2]),
                  "(0,1,0) (-1,0,0) (0,0,3)": lambda p: (p[1], 5 - p[0], p[2] / 3)}
        for directions, index_of in frames.items():
            self.write("in.nrrd", nrrd(ball, "space: left-posterior-superior", f"space directions: {directions}",
                                       "space origin: (5,0,0)"))
            with self.subTest(directions=directions):
                self.assert_linear(self.ply("in.nrrd", "--attribute", "a=linear.npy"), index_of)
                self.assert_linear(self.ply("in.nrrd", "--attribute", "a=linear.npy", "--to-space", "ras"),
                                   lambda p: index_of((-p[0], -p[1], p[2])))

    def test_other_formats_that_state_none(self):
        with zipfile.ZipFile(self.folder / "both.npz", "w") as archive:
            archive.writestr("ball.npy", npy(ball))
            archive.writestr("linear.npy", npy(linear))
            archive.writestr("small.npy", npy(linear, (5, 5, 5)))
        self.write("bare.nrrd", nrrd(linear))
        self.write("fortran.npy", npy(linear, fortran=True))
        place = ("--spacing", "0.5", "--origin", "1,2,3")
        for arguments in (("both.npz", "--grid", "ball", "--attribute", "a=linear"), ("ball.npy", "--attribute", "a=both.npz[linear]"),
                          ("ball.npy", "--attribute", "a=bare.nrrd"), ("ball.npy", "--attribute", "a=fortran.npy")):
            with self.subTest(arguments=arguments):
                self.assert_linear(self.ply(*arguments, *place), lambda p: [(c - o) / 0.5 for c, o in zip(p, (1, 2, 3))])
                self.assertNotIn("assumes", self.done.err)
        self.assert_fails(2, self.run_program("both.npz", "--grid", "ball", "--iso", "0.5", "--attribute", "small", "-o", "a.ply"),
                          "on the grid of both.npz: expected 9 x 8 x 7 samples, found 5 x 5 x 5")

    def test_another_shape_needs_a_placement(self):
        # linear() again, by samples that are twice as far apart and begin at (-2, -2, -2).
        self.write("coarse.npy", npy(lambda i, j, k: linear(2 * i - 2, 2 * j - 2, 2 * k - 2), (8, 7, 6)))
        refused = self.run_program("ball.npy", "--spacing", "0.5", "--iso", "0.5", "--attribute", "a=coarse.npy", "-o", "a.ply")
        self.assert_fails(2, refused, "the attribute 'a': coarse.npy states no spacing and no origin, so its samples must be on "
                          "the grid of ball.npy: expected 9 x 8 x 7 samples, found 8 x 7 x 6", "NAME=FILE:spacing=SX,SY,SZ:origin=X,Y,Z")
        self.assertNotIn("a.ply", self.files())
        for settings in (":spacing=1:origin=-1,-1,-1", ":origin=-1,-1,-1:spacing=1,1,1"):
            found = self.ply("ball.npy", "--spacing", "0.5", "--attribute", "a=coarse.npy" + settings)
            self.assert_linear(found, lambda p: [c / 0.5 for c in p])
        self.ply("ball.npy", "--spacing", "0.5", "--attribute", "a=coarse.npy:spacing=1")
        self.assertIn("coarse.npy states no spacing and no origin: the program places its first sample at 0,0,0", self.done.err)
        # Of the shape of the input, the axes are its axes.
        self.assert_linear(self.ply("ball.npy", "--spacing", "0.5", "--attribute", "a=linear.npy:origin=1,0,0"),
                           lambda p: ((p[0] - 1) / 0.5 if p[0] > 1 else 0, p[1] / 0.5, p[2] / 0.5))

    def test_a_placement_of_its_own_is_kept(self):
        self.write("placed.nrrd", nrrd(linear, "space: left-posterior-superior", "space directions: (1,0,0) (0,1,0) (0,0,1)",
                                       "space origin: (-2,-2,-2)"))
        found = self.ply("ball.npy", "--spacing", "0.5", "--attribute", "a=placed.nrrd")
        self.assert_linear(found, lambda p: [c + 2 for c in p])
        self.assertIn("placed.nrrd and ball.npy have equal dimensions but different placements; the conversion uses the placement of each file", self.done.err)
        # What says where the input is says it of its own samples, too.
        self.write("in.nrrd", nrrd(ball, "space: left-posterior-superior", "space directions: (1,0,0) (0,1,0) (0,0,1)",
                                   "space origin: (-2,-2,-2)"))
        for value in self.ply("in.nrrd", "--spacing", "0.25", "--origin", "1,1,1", "--attribute", "a=in.nrrd")["a"]:
            self.assertAlmostEqual(value, 0.5, delta=1e-5)
        self.assert_linear(self.ply("ball.npy", "--attribute", "a=placed.nrrd:spacing=1:origin=0,0,0"), lambda p: p)

    def test_colors(self):
        found = self.ply("ball.npy", "--spacing", "0.1", "--color-by", "a=linear.npy:gray:-20,20")
        for *place, red in zip(found["x"], found["y"], found["z"], found["red"]):
            wanted = (linear(*(c / 0.1 for c in place)) + 20) / 40
            self.assertAlmostEqual(red, 255 * min(max(wanted, 0), 1), delta=1)
        self.write("coarse.npy", npy(linear, (5, 5, 5)))
        self.assert_fails(2, self.run_program("ball.npy", "--iso", "0.5", "--color-by", "a=coarse.npy", "-o", "a.ply"), "5 x 5 x 5")
        for settings in ("a=coarse.npy:spacing=2:gray", "a=coarse.npy:gray:spacing=2", "a=coarse.npy:spacing=2:origin=0,0,0:gray:0,1"):
            self.ply("ball.npy", "--color-by", settings)

    def test_sequences(self):
        for k in (1, 2):
            self.write(f"ball_{k}.npy", npy(ball))
            self.write(f"heat_{k}.npy", npy(lambda i, j, l, k=k: linear(i, j, l) + 100 * k))
        self.convert("ball_{}.npy", "--spacing", "0.1", "--iso", "0.5", "--attribute", "a=heat_{}.npy", "--ascii", "-o", "out_{}.ply")
        for k in (1, 2):
            found = columns(self.folder / f"out_{k}.ply")
            found["a"] = [value - 100 * k for value in found["a"]]
            self.assert_linear(found, lambda p: [c / 0.1 for c in p])

    def test_the_file_of_an_optional_attribute_that_comes_later(self):
        for k in (1, 2):
            self.write(f"ball_{k}.npy", npy(ball))
        self.write("heat_1.npy", npy(linear))
        batch = ("ball_{}.npy", "--iso", "0.5", "--attribute", "a?=heat_{}.npy", "--ascii", "--resume")
        frames = (*batch, "-o", "out_{}.ply")
        self.convert(*frames)
        self.assertIn("0 of 2 frames done, 2 kept", self.convert(*frames).err)
        self.write("heat_2.npy", npy(linear))
        self.assertIn("1 of 2 frames done, 1 kept", self.convert(*frames).err)
        self.assert_linear(columns(self.folder / "out_2.ply"), lambda p: p)
        self.assertIn("0 of 2 frames done, 2 kept", self.convert(*frames).err)
        (self.folder / "heat_2.npy").unlink()
        self.assertIn("1 of 2 frames done, 1 kept", self.convert(*frames).err)
        self.assertNotIn("a", columns(self.folder / "out_2.ply"))
        animation = (*batch[:-2], "--resume", "--animate", "-o", "all.glb")
        self.convert(*animation)
        self.assertIn("2 kept", self.convert(*animation).err)
        self.write("heat_2.npy", npy(linear))
        self.assertIn("2 of 2 frames done", self.convert(*animation).err)

    @unittest.skipUnless(PLUGIN.exists(), "the plug-ins around OpenVDB were not built")
    def test_sparse_inputs_have_no_shape(self):
        self.convert("ball.npy", "-o", "ball.vdb")
        self.assert_fails(2, self.run_program("ball.vdb", "--iso", "0.5", "--attribute", "a=linear.npy", "-o", "a.ply"),
                          "ball.vdb, a sparse grid, cannot place it", "expected a spacing after the file name, found none", ":spacing=")
        self.assert_linear(self.ply("ball.vdb", "--attribute", "a=linear.npy:spacing=1:origin=0,0,0"), lambda p: p)

    def test_settings_that_are_refused(self):
        for word, part in (("a=linear.npy:spacing=0", "spacing: expected"), ("a=linear.npy:origin=1", "origin: expected"),
                           ("a=linear.npy:spaceing=1", "did you mean 'spacing'?"),
                           ("a=linear.npy:spacing=1:spacing=2", "occurs twice"), ("a=linear.npy:nodata=x", "nodata: expected")):
            for option in ("--attribute", "--color-by"):
                self.assert_fails(1, self.run_program("ball.npy", "--iso", "0.5", option, word, "-o", "a.ply"), option, part)
        self.assert_fails(1, self.run_program("ball.npy", "--iso", "0.5", "--attribute", "a=linear.npy", "--color-by",
                                              "a=linear.npy:spacing=1", "-o", "a.ply"), "give different settings")


class PartTest(FilesTest):
    """One volume of several, and one number of several, of a file beside the input."""

    SPACE = ("space: right-anterior-superior", "space directions: (1,0,0) (0,1,0) (0,0,1)", "space origin: (0,0,0)")

    def setUp(self):
        super().setUp()
        self.write("ct.nrrd", nrrd(ball, *self.SPACE))
        scaled = lambda times: (lambda *index: times * linear(*index))  # noqa: E731
        several = [nrrd(scaled(1 + n))[-4 * math.prod(DIMS):] for n in range(3)]
        head = ["NRRD0004", "type: float", "dimension: 4", "encoding: raw", "endian: little", self.SPACE[0], self.SPACE[2]]
        dims = "{} {} {}".format(*DIMS)
        axes = "(1,0,0) (0,1,0) (0,0,1)"
        self.write("pet.nrrd", "\n".join([*head, f"sizes: {dims} 3", f"space directions: {axes} none",
                                          "kinds: domain domain domain time", "", ""]).encode() + b"".join(several))
        turned = b"".join(n for voxel in zip(*(struct.iter_unpack("4s", one) for one in several)) for (n,) in voxel)
        self.write("disp.nrrd", "\n".join([*head, f"sizes: 3 {dims}", f"space directions: none {axes}",
                                           "kinds: vector domain domain domain", "", ""]).encode() + turned)

    def test_one_of_several_volumes_and_components(self):
        for number in range(3):
            for setting in (f"pet.nrrd:volume={number}", f"disp.nrrd:component={number}"):
                found = self.ply("ct.nrrd", "--attribute", f"a={setting}")
                found["a"] = [value / (1 + number) for value in found["a"]]
                self.assert_linear(found, lambda place: place)
        lengths = self.ply("ct.nrrd", "--attribute", "a=disp.nrrd:component=0", "--attribute", "all=disp.nrrd:component=length")
        for one, length in zip(lengths["a"], lengths["all"]):
            # Lengths are taken of the samples: where the number changes its sign among them, they are larger.
            self.assertGreater(length, math.sqrt(14) * abs(one) - 1e-3)
            if abs(one) > 6:
                self.assertAlmostEqual(length, math.sqrt(14) * abs(one), delta=1e-3)
        # In place of the input's --volume; colors take it as well, and the report has it.
        found = self.ply("pet.nrrd", "--volume", "0", "--attribute", "a=pet.nrrd:volume=2", "--report", "r.json")
        self.assertAlmostEqual(min(found["a"]), 1.5, delta=1e-4)
        (choice,) = json.loads((self.folder / "r.json").read_text())["options"]["attributes"]
        self.assertEqual((choice["volume"], choice["component"]), (2, None))
        self.convert("ct.nrrd", "--iso", "0.5", "--color-by", "a=pet.nrrd:volume=1:viridis:0,9", "-o", "c.glb")

    def test_vectors(self):
        """All components of a NRRD and of arrays of four axes, which have the input's shape."""
        several = [npy(lambda *at, n=n: (1 + n) * linear(*at)) for n in range(3)]
        size = 4 * math.prod(DIMS)
        head = several[0][:-size].replace(b"(7, 8, 9)", b"(7, 8, 9, 3)").replace(b"   \n", b"\n")
        body = b"".join(n for voxel in zip(*(struct.iter_unpack("4s", one[-size:]) for one in several)) for (n,) in voxel)
        self.write("disp.npy", head + body)
        with zipfile.ZipFile(self.folder / "all.npz", "w") as archive:
            archive.writestr("disp.npy", head + body)
            archive.writestr("other.npy", several[0])
        for source in ("disp.nrrd", "disp.npy", "all.npz[disp]"):
            found = self.ply("ct.nrrd", "--attribute", f"a={source}")
            for n in range(3):
                self.assert_linear({**found, "a": [value / (1 + n) for value in found[f"a_{n}"]]}, lambda place: place)
        # Another shape: the array has several volumes.
        self.write("wrong.npy", head.replace(b"(7, 8, 9, 3)", b"(9, 8, 7, 3)") + body)
        run = self.run_program("ct.nrrd", "--iso", "0.5", "--attribute", "a=wrong.npy", "-o", "no.ply")
        self.assert_fails(2, run, "9 volumes")

    def test_hints_name_what_works(self):
        for setting, message, hint in (
                ("pet.nrrd", "because the file has 3 volumes", "choose one of them with :volume=K behind NAME=FILE, K from 0 to 2"),
                ("pet.nrrd:volume=3", "there is no volume 3", ":volume=K behind NAME=FILE, K from 0 to 2"),
                ("ct.nrrd:volume=1", "there is no volume 1", "leave :volume= out"),
                ("disp.nrrd:component=3", "there is no component 3", ":component=K"),
                ("ct.nrrd:component=1", "expected several components per sample", "leave :component= out")):
            run = self.run_program("ct.nrrd", "--iso", "0.5", "--attribute", f"a={setting}", "-o", "no.ply")
            self.assert_fails(2, run, message, hint)
            self.assertNotIn("--", run.err.split("hint:")[1])
        for setting, said in (("volume=-1", "volume: expected the number of a volume"), ("volume=all", "volume: expected"),
                              ("component=x", "component: expected the number"), ("volume=0:volume=1", "volume= occurs twice"),
                              ("volumes=1", "did you mean 'volume'?")):
            self.assert_fails(1, self.run_program("ct.nrrd", "--iso", "0", "--attribute", f"a=pet.nrrd:{setting}", "-o", "o.ply"), said)


class NoDataTest(FilesTest):
    def test_samples_of_no_data_are_no_values(self):
        self.write("ball.npy", npy(ball))
        self.write("heat.npy", npy(lambda i, j, k: -9999 if i > 4 else 7))
        place = ("ball.npy", "--spacing", "0.5")
        found = self.ply(*place, "--nodata", "-9999", "--attribute", "a=heat.npy")
        for x, value in zip(found["x"], found["a"]):
            self.assertTrue(math.isnan(value) if x / 0.5 > 4 else value == 7, (x, value))
        self.assertRegex(self.done.err, r"the attribute 'a' is not finite at \d+ of \d+ vertices")
        # A value of its own.
        own = self.ply(*place, "--attribute", "a=heat.npy:nodata=-9999")
        self.assertEqual([str(value) for value in own["a"]], [str(value) for value in found["a"]])
        other = self.ply(*place, "--nodata", "-9999", "--attribute", "a=heat.npy:nodata=-1")
        self.assertLess(min(other["a"]), -1000)

    def test_grids_of_the_same_file(self):
        with zipfile.ZipFile(self.folder / "both.npz", "w") as archive:
            archive.writestr("ball.npy", npy(ball))
            archive.writestr("heat.npy", npy(lambda i, j, k: -9999 if i > 4 else 7))
        found = self.ply("both.npz", "--grid", "ball", "--nodata", "-9999", "--attribute", "heat")
        self.assertEqual({value for value in found["heat"] if not math.isnan(value)}, {7})
        self.assertTrue(any(map(math.isnan, found["heat"])))

    @unittest.skipUnless(PLUGIN.exists(), "the plug-ins around OpenVDB were not built")
    def test_sparse_files_beside_a_dense_input_have_none(self):
        self.write("ball.npy", npy(ball))
        self.convert("ball.npy", "-o", "ball.vdb")
        self.assertEqual(set(self.ply("ball.npy", "--nodata", "-9999", "--attribute", "a=ball.vdb")), {"x", "y", "z", "a"})


class MissingTest(FilesTest):
    """Grids and files that some frames lack."""

    def archive(self, name, **arrays):
        with zipfile.ZipFile(self.folder / name, "w") as archive:
            for key, value_at in arrays.items():
                archive.writestr(key + ".npy", npy(value_at))

    def setUp(self):
        super().setUp()
        self.archive("a_1.npz", d=lambda i, j, k: -5, e=linear)  # empty, and without T
        self.archive("a_2.npz", d=ball, T=linear)

    def test_an_empty_frame_needs_no_attributes(self):
        for option in (("--color-by", "T"), ("--attribute", "T"), ("--attribute", "T", "--color-by", "T")):
            with self.subTest(option=option):
                self.convert("a_{}.npz", "--grid", "d", "--iso", "0.5", "--empty", "skip", *option, "--ascii", "-o", "o_{}.ply")
                self.assertNotIn("o_1.ply", self.files())
                self.assertIn("o_2.ply", self.files())
                (self.folder / "o_2.ply").unlink()
        self.assert_linear(self.ply("a_2.npz", "--grid", "d", "--empty", "skip", "--attribute", "a=T"), lambda p: p)
        # An empty mesh is written without it.
        run = self.convert("a_1.npz", "--grid", "d", "--iso", "0.5", "--empty", "write", "--attribute", "T", "-o", "w.ply")
        self.assertIn("the input has no attribute 'T'", run.err)
        # Files of attributes that are not there are no fault either.
        self.convert("a_1.npz", "--grid", "d", "--iso", "0.5", "--empty", "skip", "--attribute", "T=none.npy", "-o", "x.ply")

    def test_frames_with_a_surface_still_need_them(self):
        self.archive("a_1.npz", d=ball, e=linear)
        for more in ((), ("--empty", "skip")):
            self.assert_fails(2, self.run_program("a_1.npz", "--grid", "d", "--iso", "0.5", *more, "--attribute", "T", "-o", "o.ply"),
                              "the attribute 'T': a_1.npz: there is no grid 'T'", "choose one of the file's grids for the attribute")
            self.assert_fails(2, self.run_program("a_1.npz", "--grid", "d", "--iso", "0.5", *more, "--attribute", "T=no.npy", "-o",
                                                  "o.ply"), "the attribute 'T': no.npy", "cannot read the file")
        self.assertNotIn("o.ply", self.files())

    def test_optional_attributes(self):
        self.archive("a_1.npz", d=ball, e=linear)
        batch = ("a_{}.npz", "--grid", "d", "--iso", "0.5", "--attribute", "T?", "--color-by", "T?", "--ascii", "-o", "o_{}.ply")
        for more in ((), ("--resume",)):
            run = self.convert(*batch, "--table", "t.csv", *more)
            self.assertIn("note[attribute-missing]: 1 of 2 frames lack the optional attribute 'T': 1\n", run.err)
            with open(self.folder / "t.csv", newline="") as table:
                self.assertEqual([row["lacked_attributes"] for row in csv.DictReader(table)], ["T", ""])
        self.convert(*batch, "--table", "t.json")
        rows = json.loads((self.folder / "t.json").read_text())
        self.assertEqual([row["lacked_attributes"] for row in rows], [["T"], []])
        self.assertEqual(set(columns(self.folder / "o_1.ply")), {"x", "y", "z"})
        self.assertEqual(set(columns(self.folder / "o_2.ply")), {"x", "y", "z", "T", "red", "green", "blue"})
        run = self.convert("a_1.npz", "--grid", "d", "--iso", "0.5", "--attribute", "T?", "--report", "r.json", "-o", "p.ply")
        self.assertRegex(run.err, r"converted without the optional attribute 'T': .*there is no grid 'T'")
        self.assertEqual(json.loads((self.folder / "r.json").read_text())["attributes"], [])
        found = self.ply("a_2.npz", "--grid", "d", "--attribute", "heat?=T", "--attribute", "h?=none.npy", "--attribute", "t?=T")
        self.assertEqual(found["heat"], found["t"])
        self.assertNotIn("h", found)
        # A file that exists and cannot be read is an error all the same.
        self.write("bad.npy", b"\x93NUMPY\1\0damaged")
        self.assert_fails(2, self.run_program("a_2.npz", "--grid", "d", "--iso", "0.5", "--attribute", "T?=bad.npy", "-o", "o.ply"),
                          "bad.npy")
        self.assert_fails(1, self.run_program("a_2.npz", "--grid", "d", "--iso", "0.5", "--attribute", "a=T?", "-o", "o.ply"), "a?=T")

    def test_a_flat_array_gets_the_hint_of_its_attribute(self):
        """Not the options that read the main input as particles or terrain."""
        self.archive("v.npz", d=ball)
        self.write("flat.npy", npy(lambda i, j, k: i, (DIMS[0], DIMS[1], 1)).replace(b"(1, ", b"(   "))
        run = self.run_program("v.npz", "--grid", "d", "--iso", "0.5", "--attribute", "heat=flat.npy", "-o", "o.ply")
        self.assert_fails(2, run, "the attribute 'heat': flat.npy: expected an array with 3 axes", "give the attribute 'heat' the file "
                          "of a volume, such as one with the {} x {} x {} samples of v.npz".format(*DIMS))
        self.assertNotIn("--particles", run.err)
        self.assertNotIn("--heightfield", run.err)

    def test_grids_of_axes_are_one_vector(self):
        """As volumes of Houdini that were not merged: vel.x, vel.y and vel.z."""
        for names in (("vel.x", "vel.y", "vel.z"), ("vel_X", "vel_Y", "vel_Z"), ("velx", "vely", "velz")):
            with self.subTest(names=names):
                parts = {name: (lambda i, j, k, c=c: c + 1.0) for c, name in enumerate(names)}
                self.archive("v.npz", d=ball, **parts)
                found = self.ply("v.npz", "--grid", "d", "--attribute", "vel", "--attribute", f"s={names[1]}")
                self.assertEqual([set(found[name]) for name in ("vel_0", "vel_1", "vel_2", "s")], [{1}, {2}, {3}, {2}])
                self.convert("v.npz", "--grid", "d", "--iso", "0.5", "--attribute", "w=vel", "-o", "v.glb")
                self.assertEqual(set(Glb((self.folder / "v.glb").read_bytes()).values("_w")), {(1, 3, -2)})
                del parts[names[2]]
                self.archive("v.npz", d=ball, **parts)
                run = self.run_program("v.npz", "--grid", "d", "--iso", "0.5", "--attribute", "vel", "-o", "no.ply")
                self.assert_fails(2, run, "there is no grid 'vel'")
                self.assertIn("without the optional attribute 'vel'",
                              self.convert("v.npz", "--grid", "d", "--iso", "0.5", "--attribute", "vel?", "-o", "b.ply").err)
        self.archive("v.npz", d=ball, vel=linear, **{f"vel.{axis}": linear for axis in "xyz"})
        self.assertIn("vel", self.ply("v.npz", "--grid", "d", "--attribute", "vel"))  # the grid of that name, a scalar

    def test_optional_attributes_of_particles(self):
        head = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
        places = [(i, j, k) for i in range(2) for j in range(2) for k in range(2)]
        self.write("p.ply", (head + "property float t\nend_header\n" + "".join("{} {} {} 5\n".format(*p) for p in places)).encode())
        self.write("q.ply", (head + "end_header\n" + "".join("{} {} {}\n".format(*p) for p in places)).encode())
        for name, wanted in (("p.ply", {"t"}), ("q.ply", set())):
            self.convert(name, "--radius", "0.6", "--attribute", "t?", "--color-by", "t", "--ascii", "-o", "out.ply")
            self.assertEqual({"t"} & set(columns(self.folder / "out.ply")), wanted)
        self.assert_fails(2, self.run_program("q.ply", "--radius", "0.6", "--attribute", "t", "-o", "o.ply"), "no attribute 't'")
        self.assert_fails(2, self.run_program("q.ply", "--radius", "0.6", "--empty", "skip", "--attribute", "t", "-o", "o.ply"), "'t'")
        self.assert_fails(1, self.run_program("p.ply", "--radius", "0.6", "--attribute", "t:spacing=1", "-o", "o.ply"), "has a setting for volumes")


if __name__ == "__main__":
    main()
