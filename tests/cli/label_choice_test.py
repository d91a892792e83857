"""Many labels: 64-bit ids as they are, which labels are chosen, a file for each, and what is printed of thousands."""

import collections
import gzip
import itertools
import json
import re
import struct

from support import ProgramTest, main, read_glb, read_stl

LARGE = 720575940600000017  # an id of a connectome; the next integers are the same double
TABLE = ('1 255 0 0 1 1 1 "Hippocampus left"\n2 0 255 0 1 1 1 "Hippocampus right"\n'
         '3 0 0 255 1 1 1 "Skull"\n4 0 0 255 1 1 1 "a/b"\n')


def volume_of(mesh):
    """Of a closed mesh."""
    total = 0
    for triangle in mesh.triangles:
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (mesh.vertices[v] for v in triangle)
        total += ax * (by * cz - bz * cy) - ay * (bx * cz - bz * cx) + az * (bx * cy - by * cx)
    return total / 6


def open_edges(mesh):
    edges = collections.Counter()
    for a, b, c in mesh.triangles:
        edges.update(((a, b), (b, c), (c, a)))
    return sum(count != edges[b, a] for (a, b), count in edges.items())


class LabelChoiceTest(ProgramTest):
    def setUp(self):
        super().setUp()
        # Slabs of 1 to 6 planes of 5 x 4 voxels, labeled 1 to 6.
        self.slabs = [label for label in range(1, 7) for _ in range(label)]
        self.write_raw("slabs.raw", (5, 4, 21), lambda x, y, z: self.slabs[z], "B")
        self.map = ("slabs.raw", "--dims", "5,4,21", "--method", "voxels")
        (self.folder / "names.txt").write_text(TABLE)

    def names(self, *arguments):
        run = self.convert(*self.map, *arguments, "-o", "out.glb")
        return list(read_glb((self.folder / "out.glb").read_bytes())), run

    def write_ids(self, kind, ids, dims):
        """The ids, x fastest, as 64-bit integers."""
        data = struct.pack(f"<{len(ids)}{'Q' if kind[0] == 'u' else 'q'}", *ids)
        if kind.endswith("npy"):
            header = f"{{'descr': '<{kind[0]}8', 'fortran_order': False, 'shape': {dims[::-1]}, }}".ljust(117) + "\n"
            (self.folder / "ids.npy").write_bytes(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode() + data)
            return "ids.npy"
        if kind.endswith("nrrd"):
            word = "uint64" if kind[0] == "u" else "int64"
            head = (f"NRRD0004\ntype: {word}\ndimension: 3\nsizes: {dims[0]} {dims[1]} {dims[2]}\n"
                    f"endian: little\nencoding: gzip\n\n")
            (self.folder / "ids.nrrd").write_bytes(head.encode() + gzip.compress(data))
            return "ids.nrrd"
        head = bytearray(352)
        struct.pack_into("<i", head, 0, 348)
        struct.pack_into("<8h", head, 40, 3, *dims, 1, 1, 1, 1)
        struct.pack_into("<hh", head, 70, 1280 if kind[0] == "u" else 1024, 64)
        struct.pack_into("<8f", head, 76, 1, 1, 1, 1, 1, 1, 1, 1)
        struct.pack_into("<f", head, 108, 352)
        head[344:348] = b"n+1\0"
        (self.folder / "ids.nii").write_bytes(bytes(head) + data)
        return "ids.nii"

    def test_ids_of_64_bits_are_exact(self):
        """The meshes are those of small labels, and every place that has the id has all its digits."""
        dims = (7, 6, 5)
        small = [(x // 2 + 3 * (y // 3) + z // 2) % 4 for z, y, x in itertools.product(range(5), range(6), range(7))]
        self.write_raw("small.raw", dims, lambda x, y, z: small[x + 7 * (y + 6 * z)], "B")
        self.convert("small.raw", "--dims", "7,6,5", "--labels", "all", "-o", "s_{label}.stl")
        for kind in ("u.npy", "i.npy", "u.nrrd", "i.nrrd", "u.nii", "i.nii"):
            with self.subTest(kind=kind):
                ids = [label and LARGE + label for label in small]
                name = self.write_ids(kind, ids, dims)
                everything = (name, "--labels", "all", "--space", "index", "-o", "{label}.stl")
                run = self.convert(*everything, "--report", "r.json")
                self.assertNotIn("note[labels", run.err)
                self.assertIn(f"label {LARGE + 1}, {LARGE + 2}, {LARGE + 3} -> {{label}}.stl (3 files): ", run.err)
                report = json.loads((self.folder / "r.json").read_text())
                for section in ("extractions", "meshes", "relaxations"):
                    self.assertEqual([entry["iso"] for entry in report[section]], [LARGE + n for n in (1, 2, 3)])
                self.convert(*everything, "--table", "t.csv")
                self.assertIn(f",{LARGE + 2},", (self.folder / "t.csv").read_text())
                for n in (1, 2, 3):
                    made = read_stl((self.folder / f"{LARGE + n}.stl").read_bytes())
                    expected = read_stl((self.folder / f"s_{n}.stl").read_bytes())
                    self.assertEqual(made.vertices, expected.vertices)
                one = self.convert(name, "--labels", str(LARGE + 2), "--space", "index", "-o", "one.glb")
                self.assertIn(f" label {LARGE + 2} -> one.glb", one.err)
                self.assert_fails(2, self.run_program(name, "--labels", str(LARGE + 4), "-o", "none.glb"),
                                  f"no sample has label {LARGE + 4}")

    def test_ranges_names_and_exclusions(self):
        for chosen, labels in (("2-4", "234"), ("2-4,6,!3", "246"), ("!5,!1-2", "346"), ("all,!6", "12345"), ("6-9,1", "16"),
                               ("5,2", "52")):
            with self.subTest(chosen=chosen):
                self.assertEqual(self.names("--labels", chosen)[0], [f"slabs label {label}" for label in labels])
        table = ("--label-names", "names.txt")
        self.assertEqual(self.names("--labels", "Hippocampus*,6", *table)[0],
                         ["Hippocampus left", "Hippocampus right", "slabs label 6"])
        self.assertEqual(self.names("--labels", "1-3,!Skull", *table)[0], ["Hippocampus left", "Hippocampus right"])
        self.assertEqual(self.names("--labels", "?kull", *table)[0], ["Skull"])
        names, run = self.names("--labels", "1,Kidney*,30-40", *table)
        self.assertEqual(names, ["Hippocampus left"])
        self.assertIn("note[labels-unmatched]: slabs.raw: no label matches 'Kidney*' or '30-40'", run.err)
        (self.folder / "more.txt").write_text(TABLE.replace("Skull", "Spleen").replace("a/b", "Skull"))
        run = self.run_program(*self.map, "--roi", "0,0,0,4,3,2", "--labels", "1,Skull", "--label-names", "more.txt", "-o", "x.glb")
        self.assert_fails(2, run, "slabs.raw: no sample has the label 'Skull'", "--empty skip")
        for wrong, hint in (("skull", "did you mean 'Skull'?"), ("Scull", "did you mean 'Skull'?"),
                            ("Kidney", "the names are Hippocampus left, Hippocampus right, ")):
            run = self.run_program(*self.map, "--labels", f"1,{wrong}", *table, "-o", "x.glb")
            self.assert_fails(2, run, f"slabs.raw: no label is '{wrong}'", hint, "--empty skip")
            names, run = self.names("--labels", f"1,{wrong}", *table, "--empty", "skip")
            self.assertEqual(names, ["Hippocampus left"])
            self.assertIn(f"note[labels-unmatched]: slabs.raw: no label matches '{wrong}'", run.err)
        self.assert_fails(2, self.run_program(*self.map, "--labels", "Kidney*", "-o", "x.glb"),
                          "the choice includes none of the 6 labels in the file")
        for wrong in ("1,", "!", "4-2", ""):
            self.assert_fails(1, self.run_program(*self.map, "--labels", wrong, "-o", "x.glb"), "1-40,Hippocampus*,!Skull")

    def test_the_hint_for_a_text_that_is_no_label(self):
        table = ("--label-names", "names.txt")
        for wrong, names, hint in (
                ("1e3", (), "did you mean 1000? If not, "), ("2.0", table, "did you mean 2? If not, "),
                ("1.5", (), "labels are whole numbers"), ("1.5", table, "labels are whole numbers"),
                ("inf", table, "labels are whole numbers"), ("-nan", (), "labels are whole numbers"),
                ("9" * 30, (), "labels are whole numbers from -2^63 to 2^63 - 1"),
                ("1e999", (), "labels are whole numbers"), ("Skull", (), "the labels have no names: give their numbers")):
            with self.subTest(wrong=wrong, names=names):
                run = self.run_program(*self.map, f"--labels={wrong}", *names, "-o", "x.glb")
                self.assert_fails(2, run, f"slabs.raw: no label is '{wrong}'", f"  hint: {hint}")
        for wrong in ("200", "-7", str(2**53 + 1)):  # numbers among terms that make a set
            for names in ((), table):
                run = self.run_program(*self.map, "--labels", f"1-2,{wrong}", *names, "-o", "x.glb")
                self.assert_fails(2, run, f"slabs.raw: no label is '{wrong}'\n  hint: use --empty skip")
        (self.folder / "numbers.txt").write_text(TABLE.replace("Skull", "1.5"))  # a name, all the same
        self.assertEqual(self.names("--labels", "1.5", "--label-names", "numbers.txt")[0], ["1.5"])

    def test_the_old_file_of_a_choice_without_labels_is_removed_and_told(self):
        for chosen in ("Kidney*", "30-40", "99"):
            (self.folder / "x.glb").write_bytes(b"old")
            run = self.run_program(*self.map, "--labels", chosen, "-o", "x.glb")
            self.assert_fails(2, run)
            self.assertIn("x.glb", self.files())
            run = self.convert(*self.map, "--labels", chosen, "--empty", "skip", "-o", "x.glb")
            self.assertIn("the conversion did not write x.glb and removed the old x.glb", run.err)
            self.assertEqual(run.err.count("note[no-surface]"), 1)
            self.assertNotIn("x.glb", self.files())
            run = self.convert(*self.map, "--labels", chosen, "--empty", "skip", "-o", "x.glb")
            self.assertIn("the conversion did not write x.glb\n", run.err)

    def test_the_result_names_the_file_of_the_only_label(self):
        table = ("--label-names", "names.txt")
        run = self.convert(*self.map, "--labels", "Skull", *table, "-o", "of_{name}.stl")
        self.assertIn(" -> of_Skull.stl: ", run.err)
        run = self.convert(*self.map, "--labels", "2,3", "-o", "of_{label}.stl")
        self.assertIn(" -> of_{label}.stl (2 files): ", run.err)

    def test_a_label_by_its_name_goes_to_a_format_of_one_surface(self):
        table = ("--label-names", "names.txt")
        self.convert(*self.map, "--labels", "Skull", *table, "-o", "name.stl")
        names, _ = self.names("--labels", "Skull", *table)
        self.assertEqual(names, ["Skull"])
        number = re.search(r"^\s*(\d+).*Skull", TABLE, re.M)[1]
        self.convert(*self.map, "--labels", number, *table, "-o", "number.stl")
        self.assertEqual((self.folder / "name.stl").read_bytes(), (self.folder / "number.stl").read_bytes())
        self.convert(*self.map, "--labels", "Skull", *table, "--split-components", "-o", "body_{piece}.stl")
        self.assertEqual((self.folder / "body_1.stl").read_bytes(), (self.folder / "name.stl").read_bytes())
        (self.folder / "twice.txt").write_text(TABLE.replace("Hippocampus left", "Skull"))
        bodies = (*self.map, "--labels", "Skull", "--label-names", "twice.txt", "--split-components", "-o")
        self.assert_fails(1, self.run_program(*bodies, "two_{piece}.stl"), "several labels have the name 'Skull'", "{label}")
        self.assertEqual([name for name in self.files() if name.startswith("two_")], [])
        self.convert(*bodies, "two_{name}_{piece}.stl")
        for names, chosen, message in ((table, "Sk*", "one stl file holds one surface, but labels Sk* can give several"),
                                       (("--label-names", "twice.txt"), "Skull", "the format stl holds one mesh, found 2")):
            self.assert_fails(1, self.run_program(*self.map, "--labels", chosen, *names, "-o", "several.stl"), message)
            self.assertFalse((self.folder / "several.stl").exists())

    def test_a_file_that_is_not_written_is_told(self):
        for empty in ("skip", "write"):
            for chosen, reason in (("Kidney*", "the choice includes none of the 6 labels in the file"),
                                   ("77-79", "the choice includes none of the 6 labels in the file")):
                run = self.convert(*self.map, "--labels", chosen, "--empty", empty, "-o", "x.glb")
                self.assertIn(f"note[no-surface]: slabs.raw: {reason}; the conversion did not write x.glb", run.err)
                self.assertFalse((self.folder / "x.glb").exists())

    def test_small_labels_are_left_out(self):
        names, run = self.names("--labels", "all", "--labels-min-voxels", "61")
        self.assertEqual(names, ["slabs label 4", "slabs label 5", "slabs label 6"])
        self.assertIn("note[labels-small]: slabs.raw: no mesh for 3 of 6 labels (1, 2, 3): they have fewer than 61 voxels",
                      run.err)
        names, run = self.names("--labels", "all", "--labels-min-voxels", "20")
        self.assertEqual(len(names), 6)
        self.assertNotIn("labels-small", run.err)
        names, _ = self.names("--labels", "1,5", "--labels-min-voxels", "21", "--roi", "0,0,0,4,3,20")
        self.assertEqual(names, ["slabs label 5"])
        self.assert_fails(2, self.run_program(*self.map, "--labels", "1,2", "--labels-min-voxels", "99", "-o", "x.glb"),
                          "slabs.raw: 2 labels chosen, none with as many voxels as required")
        self.assert_fails(1, self.run_program(*self.map, "--iso", "1", "--labels-min-voxels", "9", "-o", "x.glb"),
                          "--labels-min-voxels needs --labels")

    def test_verbose_prints_a_table(self):
        """Of each label: voxels, their volume in the units of the mesh, triangles, closed, name."""
        _, run = self.names("--labels", "all", "--label-names", "names.txt", "--spacing", "0.5,1,3", "-v")
        rows = [line.split(None, 5) for line in run.err.splitlines()]
        begin = next(i for i, row in enumerate(rows) if "voxels" in row and "closed" in row)
        table = rows[begin + 1:begin + 7]
        for label, row in enumerate(table, 1):
            row = row[-6:]
            self.assertEqual([float(word) for word in row[:3]], [label, 20 * label, 30 * label])
            self.assertEqual(row[3:5], ["12", "yes"])
        self.assertEqual([row[-1] for row in table[:4]], ["Hippocampus left", "Hippocampus right", "Skull", "a/b"])
        _, run = self.names("--labels", "all", "--label-names", "names.txt")
        self.assertNotIn("voxels", run.err)
        self.assertIn("slabs.raw label 1 (Hippocampus left), 2 (Hippocampus right), 3 (Skull), 4 (a/b), 5, 6 -> ", run.err)

    def test_background(self):
        self.write_raw("zero.raw", (4, 4, 4), lambda x, y, z: 0 if x < 2 else 7, "B")
        for background, labels in (((), [7]), (("--background", "7"), [0]), (("--background", "5"), [0, 7])):
            for method in ("voxels", "surface-nets"):
                run = self.convert("zero.raw", "--dims", "4,4,4", "--labels", "all", "--method", method, *background, "-o", "z.glb")
                names = list(read_glb((self.folder / "z.glb").read_bytes()))
                self.assertEqual(names, [f"zero label {label}" for label in labels], run.err)
        self.assert_fails(1, self.run_program(*self.map, "--iso", "1", "--background", "9", "-o", "x.glb"),
                          "--background needs --labels")

    def test_a_file_for_each_label(self):
        run = self.convert(*self.map, "--labels", "all", "--label-names", "names.txt", "-o", "o_{label}_{name}.stl")
        self.assertEqual(sorted(path.name for path in self.folder.glob("o_*")),
                         ["o_1_Hippocampus left.stl", "o_2_Hippocampus right.stl", "o_3_Skull.stl", "o_4_a_b.stl",
                          "o_5_label 5.stl", "o_6_label 6.stl"])
        self.assertEqual(run.err.count("triangles"), 1, "one line for all")
        for label in range(1, 7):
            (path,) = self.folder.glob(f"o_{label}_*")
            self.convert(*self.map, "--labels", label, "-o", "one.stl")
            self.assertEqual(path.read_bytes()[80:], (self.folder / "one.stl").read_bytes()[80:])
            self.assertAlmostEqual(volume_of(read_stl(path.read_bytes())), 20 * label, places=3)
        self.convert(*self.map, "--labels", "2,3", "-o", "l_{label}.glb", "--resume")
        again = self.convert(*self.map, "--labels", "2,3", "-o", "l_{label}.glb", "--resume")
        self.assertIn("l_2.glb", {path.name for path in self.folder.iterdir()}, again.err)
        self.assert_fails(1, self.run_program(*self.map, "--iso", "2.5", "-o", "{label}.glb"),
                          "expected labels for {label} or {name} in the output name, found none")
        (self.folder / "l_4.raw").write_bytes((self.folder / "slabs.raw").read_bytes())
        self.convert(*self.map, "--labels", "all", "--split-components", "-o", "p_{label}_{piece}.stl")
        self.assertEqual(len(list(self.folder.glob("p_*_1.stl"))), 6)

    def test_a_label_does_not_overwrite_the_input(self):
        (self.folder / "in_3.raw").write_bytes((self.folder / "slabs.raw").read_bytes())
        run = self.run_program("in_3.raw", "--format", "ply", *self.map[1:], "--labels", "all", "-o", "in_{label}.raw")
        self.assertNotEqual(run.code, 0)
        self.assertEqual((self.folder / "in_3.raw").read_bytes(), (self.folder / "slabs.raw").read_bytes())

    def test_thousands_of_labels_take_one_line(self):
        """Every label has its closed mesh with the volume of its voxels, whatever their number."""
        side, blocks = 3, 11

        def label(x, y, z):
            return 1 + x // side + blocks * (y // side + blocks * (z // side))

        self.write_raw("blocks.raw", (side * blocks,) * 3, label, "H")
        dims = ",".join([str(side * blocks)] * 3)
        run = self.convert("blocks.raw", "--dims", dims, "--dtype", "u16", "--labels", "all", "--relax", "0", "-o", "b.glb")
        self.assertIn(f"blocks.raw {blocks ** 3} labels from 1 to {blocks ** 3} -> b.glb: ", run.err)
        self.assertLess(len(run.err), 300)
        meshes = read_glb((self.folder / "b.glb").read_bytes())
        self.assertEqual(list(meshes), [f"blocks label {n + 1}" for n in range(blocks ** 3)])
        for mesh in meshes.values():
            self.assertEqual((len(mesh.triangles), open_edges(mesh)), (12 * side * side, 0))
            self.assertAlmostEqual(volume_of(mesh), side ** 3, places=2)
        explained = self.convert("blocks.raw", "--dims", dims, "--dtype", "u16", "--labels", "all", "--explain", "-o", "b.glb")
        self.assertNotIn("iso value", explained.err)


if __name__ == "__main__":
    main()
