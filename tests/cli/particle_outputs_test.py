"""Particles written as particles: -o FILE.bgeo, .vtu and .xyz."""

import json
import math
import pathlib
import random
import struct

from support import PROGRAM, ProgramTest, main

HAS_VTK = any((pathlib.Path(PROGRAM).parent / "plugins").glob("*vtk*"))
COUNT = 500


def float32(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


def read_xyz(path):
    """Frames of extended XYZ: the comment, and lists of words or of tuples by the names of Properties."""
    lines = path.read_text().splitlines()
    frames = []
    while lines:
        count, comment = int(lines[0]), lines[1]
        words = comment.split("Properties=")[1].split()[0].split(":")
        columns = [(name, kind, int(number)) for name, kind, number in zip(words[::3], words[1::3], words[2::3])]
        rows = [line.split() for line in lines[2:2 + count]]
        data, first = {}, 0
        for name, kind, number in columns:
            cells = [row[first:first + number] for row in rows]
            first += number
            data[name] = [cell[0] for cell in cells] if kind == "S" else [tuple(map(float, cell)) for cell in cells]
        frames.append((comment, data))
        lines = lines[2 + count:]
    return frames


def read_vtu(path):
    """The appended raw arrays by name."""
    head, raw = path.read_bytes().split(b"<AppendedData encoding=\"raw\">\n_", 1)
    arrays = {}
    for line in head.decode().splitlines():
        if not line.startswith("<DataArray"):
            continue
        values = dict(part.split("=", 1) for part in line.replace("/>", "").split()[1:])
        values = {name: text.strip('"') for name, text in values.items()}
        start = int(values["offset"])
        (size,) = struct.unpack_from("<Q", raw, start)
        kind = {"Float64": "d", "Float32": "f", "Int64": "q", "UInt8": "B"}[values["type"]]
        arrays[values["Name"]] = list(struct.iter_unpack("<" + int(values["NumberOfComponents"]) * kind, raw[start + 8:start + 8 + size]))
    return arrays


class ParticleOutputsTest(ProgramTest):
    """500 atoms with species, charge and velocity in a box of 10 x 12 x 14."""

    def setUp(self):
        super().setUp()
        jitter = random.Random(5)
        self.species = [jitter.choice(("O", "Na+", "H")) for _ in range(COUNT)]
        self.positions = [(jitter.uniform(0, 10), jitter.uniform(0, 12), jitter.uniform(0, 14)) for _ in range(COUNT)]
        self.charge = [(float32(jitter.uniform(-1, 1)),) for _ in range(COUNT)]
        self.velocity = [tuple(float32(jitter.gauss(0, 1)) for _ in range(3)) for _ in range(COUNT)]
        rows = "".join(f"{s} {' '.join(repr(v) for v in (*p, *q, *u))}\n"
                       for s, p, q, u in zip(self.species, self.positions, self.charge, self.velocity))
        self.text = (f"{COUNT}\n" 'Lattice="10 0 0 0 12 0 0 0 14" Properties=species:S:1:pos:R:3:charge:R:1:velo:R:3\n' + rows)
        (self.folder / "in.xyz").write_text(self.text)

    def written(self, *arguments):
        run = self.convert(*arguments, "--report", "r.json")
        self.report = json.loads((self.folder / "r.json").read_text())
        return run

    def chosen(self, condition=lambda species, position, velocity: True):
        """The indices of the particles for which a condition holds."""
        return [i for i in range(COUNT) if condition(self.species[i], self.positions[i], self.velocity[i])]

    def assert_rows(self, rows, wanted, chosen):
        """Rows of float32 numbers, as text or in binary."""
        self.assertEqual([tuple(map(float32, row)) for row in rows], [wanted[i] for i in chosen])

    def assert_xyz(self, name, chosen):
        ((_, data),) = read_xyz(self.folder / name)
        self.assertEqual(data["species"], [self.species[i] for i in chosen])
        self.assertEqual(data["pos"], [self.positions[i] for i in chosen])
        self.assert_rows(data["charge"], self.charge, chosen)
        self.assert_rows(data["velo"], self.velocity, chosen)

    def test_round_trip_by_xyz(self):
        run = self.written("in.xyz", "-o", "out.xyz")
        self.assertIn(f"out.xyz: {COUNT} particles with 3 attributes", run.err)
        self.assertNotIn("note[", run.err)
        self.assert_xyz("out.xyz", self.chosen())
        self.assertIn('Lattice="10 0 0 0 12 0 0 0 14" Origin="0 0 0" pbc="T T T"', (self.folder / "out.xyz").read_text())
        (facts,) = self.report["particle_files"]
        self.assertEqual((facts["particles"], facts["chosen"], facts["outside_region"]), (COUNT, None, None))
        self.assertEqual(self.report["options"]["particle_file"], {"format": "xyz"})
        # Again gives the same bytes.
        self.convert("out.xyz", "-o", "again.xyz")
        self.assertEqual((self.folder / "again.xyz").read_bytes(), (self.folder / "out.xyz").read_bytes())

    def test_round_trip_by_houdini_geometry(self):
        run = self.written("in.xyz", "-o", "out.bgeo")
        self.assertIn("note[placement-not-stored]: out.bgeo: the file does not state the box (0, 0, 0) .. (10, 12, 14), "
                      "periodic along x, y, z", run.err)
        self.convert("out.bgeo", "-o", "back.xyz")
        self.assert_xyz("back.xyz", self.chosen())
        # Conditions take the words.
        self.convert("out.bgeo", "--species", "O,H", "-o", "chosen.xyz")
        self.assert_xyz("chosen.xyz", self.chosen(lambda s, p, v: s != "Na+"))
        (told,) = json.loads(self.convert("info", "out.bgeo", "--json").text)
        words = [a for a in told["particles"]["attributes"] if a["name"] == "species"][0]["words"]
        self.assertEqual({w["word"]: w["count"] for w in words}, {s: self.species.count(s) for s in set(self.species)})

    def test_grids_of_vtk(self):
        run = self.written("in.xyz", "--select", "charge > 0", "-o", "out.vtu")
        self.assertIn("note[data-left-out]: out.vtu: the file does not have the words of 'species': vtu files hold numbers only", run.err)
        chosen = [i for i in range(COUNT) if self.charge[i][0] > 0]
        arrays = read_vtu(self.folder / "out.vtu")
        self.assertEqual(arrays["Points"], [self.positions[i] for i in chosen])
        self.assertEqual(arrays["connectivity"], [(i,) for i in range(len(chosen))])
        self.assert_rows(arrays["charge"], self.charge, chosen)
        self.assert_rows(arrays["velo"], self.velocity, chosen)
        if HAS_VTK:
            self.convert("out.vtu", "-o", "back.xyz")
            ((_, data),) = read_xyz(self.folder / "back.xyz")
            self.assertEqual(data["pos"], arrays["Points"])

    def test_choices_and_regions(self):
        def inside(p):
            return all(low <= v <= high for v, low, high in zip(p, (1, 2, 3), (8, 9, 10)))

        roi = ("--roi", "1,2,3,8,9,10")
        for options, chosen in (
                (("--species", "O"), self.chosen(lambda s, p, v: s == "O")),
                (("--select", "|velo| < 1.5 && z > 3"), self.chosen(lambda s, p, v: math.hypot(*v) < 1.5 and p[2] > 3)),
                (("--stride", "7"), list(range(0, COUNT, 7))),
                (roi, self.chosen(lambda s, p, v: inside(p))),
                (("--periodic", "none", *roi, "--species", "H"), self.chosen(lambda s, p, v: s == "H" and inside(p)))):
            self.written("in.xyz", *options, "-o", "out.xyz")
            self.assert_xyz("out.xyz", chosen)
            (facts,) = self.report["particle_files"]
            self.assertEqual(facts["particles"], len(chosen))
        self.assertEqual(facts["chosen"], self.species.count("H"))
        self.assertEqual(facts["outside_region"], self.species.count("H") - len(chosen))
        run = self.convert("in.xyz", *roi, "--explain", "-o", "out.xyz")
        left_out = COUNT - len(self.chosen(lambda s, p, v: inside(p)))
        self.assertIn(f"{left_out} of {COUNT} particles, outside the region", run.err)

    def test_unwrapped_positions_and_types(self):
        (self.folder / "a.lammpstrj").write_text(
            "ITEM: TIMESTEP\n5\nITEM: NUMBER OF ATOMS\n3\nITEM: BOX BOUNDS pp pp pp\n0 10\n0 20\n0 30\n"
            "ITEM: ATOMS id type element x y z ix iy iz\n1 1 O 1 2 3 0 0 0\n2 2 H 4 5 6 1 -1 2\n3 1 O 7 8 9 0 1 0\n")
        run = self.written("a.lammpstrj", "--unwrap", "--type", "1,2", "-o", "out.xyz")
        ((comment, data),) = read_xyz(self.folder / "out.xyz")
        self.assertEqual(data["pos"], [(1, 2, 3), (14, -15, 66), (7, 28, 9)])
        self.assertEqual((data["element"], data["type"]), (["O", "H", "O"], [(1,), (2,), (1,)]))
        self.assertIn('pbc="F F F"', comment)
        self.assertEqual(data["i"], [(0, 0, 0), (1, -1, 2), (0, 1, 0)])
        self.assertNotIn("ix", data)
        self.assertNotIn("attribute-renamed", run.err)

    def test_radii_of_elements_are_an_attribute(self):
        self.convert("in.xyz", "--radii", "covalent", "-o", "out.xyz")
        ((_, data),) = read_xyz(self.folder / "out.xyz")
        expected = [(float32({"O": 0.66, "Na+": 1.66, "H": 0.31}[s]),) for s in self.species]
        self.assert_rows(data["radius"], expected, range(COUNT))

    def test_sequences_and_frames(self):
        (self.folder / "run.xyz").write_text(self.text * 3)
        self.convert("run.xyz", "--volume", "all", "--species", "O", "--jobs", "2", "-o", "f_{}.bgeo")
        self.assertEqual([name for name in self.files() if name.startswith("f_")], ["f_0.bgeo", "f_1.bgeo", "f_2.bgeo"])
        self.assertEqual((self.folder / "f_0.bgeo").read_bytes(), (self.folder / "f_2.bgeo").read_bytes())
        run = self.convert("f_{}.bgeo", "-o", "g_{}.xyz", "--resume")
        self.assertNotIn("radius", run.err)
        self.assert_xyz("g_1.xyz", self.chosen(lambda s, p, v: s == "O"))
        with (self.folder / "in.xyz").open("rb") as xyz:
            out = self.convert("-", "--input-format", "xyz", "--format", "xyz", "-o", "-", stdin=xyz).out
        self.convert("in.xyz", "-o", "plain.xyz")
        self.assertEqual(out, (self.folder / "plain.xyz").read_bytes())

    def test_names_that_a_format_does_not_allow(self):
        (self.folder / "odd.csv").write_text("x,y,z,c_stress[1],odd name,T\n0,0,0,1,2,3\n1,0,0,4,5,6\n")
        run = self.convert("odd.csv", "-o", "out.xyz")
        self.assertIn("note[attribute-renamed]: out.xyz: the writer renames the attribute 'odd name' to 'odd_name'", run.err)
        ((_, data),) = read_xyz(self.folder / "out.xyz")
        self.assertEqual(data["odd_name"], [(2,), (5,)])

    def test_positions_that_are_not_finite(self):
        (self.folder / "nan.csv").write_text("x,y,z,T\n0,0,0,1\nnan,0,0,2\n2,0,0,3\n")
        self.assert_fails(2, self.run_program("nan.csv", "-o", "out.xyz"), "expected finite positions", "--nan")
        run = self.written("nan.csv", "--nan", "outside", "-o", "out.xyz")
        self.assertIn("left out 1 particle whose position is not finite", run.err)
        ((_, data),) = read_xyz(self.folder / "out.xyz")
        self.assertEqual(data["T"], [(1,), (3,)])

    def test_nothing_chosen(self):
        self.assert_fails(2, self.run_program("in.xyz", "--species", "Xe", "-o", "out.xyz"), "chooses none of 500 particles")
        self.assert_fails(2, self.run_program("in.xyz", "--roi", "11,0,0,12,1,1", "--periodic", "none", "-o", "out.xyz"),
                          "none of 500 particles lies in the region", "--roi")
        (self.folder / "out.xyz").write_text("old")
        self.convert("in.xyz", "--species", "Xe", "--empty", "skip", "-o", "out.xyz")
        self.assertNotIn("out.xyz", self.files())
        self.convert("in.xyz", "--species", "Xe", "--empty", "write", "-o", "out.xyz")
        self.assertTrue((self.folder / "out.xyz").read_text().startswith("0\n"))

    def test_options_of_surfaces_and_fields_are_refused(self):
        for options in (("--iso", "0.5"), ("--radius", "1"), ("--particles", "sph"), ("--smooth", "3"), ("--blur", "1"),
                        ("--attribute", "charge"), ("--resolution", "20"), ("--cap",), ("--html", "a.html"), ("--half",),
                        ("--roi", "0,0,0,1,1,1", "--roi-snap")):
            self.assert_fails(1, self.run_program("in.xyz", *options, "-o", "out.bgeo"), options[0] if len(options) < 3 else options[2])
        self.assert_fails(1, self.run_program("demo:sphere", "-o", "out.bgeo"), "expected particles")
        self.assert_fails(1, self.run_program("in.xyz", "-o", "out_{iso}.bgeo"), "{iso}")
        self.assertNotIn("out.bgeo", self.files())


if __name__ == "__main__":
    main()
