"""Attributes and colors of meshes that go to their file part by part: bytes, figures and messages of whole meshes."""

import itertools
import json
import random
import re
import struct

from support import SOURCE, ProgramTest, main

# Both need the mesh in memory, and change nothing; the first one takes less time.
WHOLE = ("--drop-components", 1)
WHOLE_BODIES = ("--require", "no-duplicates")
GYROID = ("demo:gyroid?size=80", "--iso", 0)
METABALLS = (SOURCE / "samples/metaballs.vdb", "--iso", 0.5)
NAMES = (("a.ply",), ("a.glb",), ("a.ply", "--ascii"))
WAVE = ("--attribute", "wave=demo:metaballs?size=20")
VECTORS = ("--attribute", "v=v.nrrd")
HOLES = ("--attribute", "holes=holes.npy:spacing=.1:origin=-.9,-.8,-1")
COLORS = ("--color-by", "wave=demo:metaballs?size=20:turbo")
COLORED_HOLES = ("--color-by", "holes=holes.npy:spacing=.1:origin=-.9,-.8,-1")
# Every kind of work: values alone, several attributes, colors of a given and of a found range, values that only color.
CHOICES = (WAVE, (*WAVE, *VECTORS), HOLES, (*HOLES, *WAVE), COLORS, (*WAVE, "--color-by", "wave"),
           ("--color-by", "wave=demo:metaballs?size=20:-.2,.1"), (*VECTORS, "--color-by", "v:gray"),
           (*WAVE, *COLORED_HOLES), (*VECTORS, *COLORS, "--up", "y", "--scale", 3))


def npy(shape, values):
    head = f"{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}"
    head += " " * (-(len(head) + 11) % 64) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head.encode() + struct.pack(f"<{len(values)}f", *values)


def told(run):
    """The printed lines about attributes, without times."""
    return [re.sub(r"in [0-9.]+ s .*processor time\)", "in a time", line) for line in run.err.splitlines()
            if re.search("attribute|colors|gray|wave|holes", line)]


class PartwiseAttributesTest(ProgramTest):
    def setUp(self):
        super().setUp()
        numbers = random.Random(3)
        head = ("NRRD0004\ntype: float\ndimension: 4\nsizes: 3 9 10 11\nencoding: raw\nendian: little\nkinds: vector domain domain domain\n"
                "space dimension: 3\nspace directions: none (.25,0,0) (0,.2,0) (0,0,.2)\nspace origin: (-1,-1,-1)\n\n")
        (self.folder / "v.nrrd").write_bytes(head.encode() + struct.pack("<2970f", *(numbers.uniform(-1, 2) for _ in range(2970))))
        values = [numbers.uniform(0, 5) for _ in range(16 * 17 * 18)]
        values[400] = float("nan")
        values[2500] = float("inf")
        values[3000] = 1e37
        (self.folder / "holes.npy").write_bytes(npy((16, 17, 18), values))

    def made(self, name, *arguments):
        """All that a conversion makes and tells of the attributes, and whether it wrote the mesh by parts."""
        (self.folder / "out").mkdir(exist_ok=True)
        run = self.convert(*arguments, "-v", "-o", f"out/{name}")
        files = {path.name: path.read_bytes() for path in (self.folder / "out").iterdir()}
        for path in (self.folder / "out").iterdir():
            path.unlink()
        found = {"files": files, "lines": told(run)}
        if "--report" in arguments:
            report = json.loads((self.folder / "r.json").read_text())
            found |= {key: report.get(key) for key in ("attributes", "colors", "notes", "meshes", "outputs")}
            if "--largest" in arguments or 40 in arguments:
                found["pieces"] = [{key: one[key] for key in ("before", "after")} for one in report["pieces"]]
        return found, "extracted and written" in run.err

    def assert_same(self, name, *arguments, parts=(), whole=WHOLE, by_parts=True):
        """Compares a mesh that is written by parts, with the options `parts`, with the whole mesh. Returns it."""
        (found, is_by_parts), (wanted, is_not) = self.made(name, *arguments, *parts), self.made(name, *arguments, *whole)
        self.assertEqual((is_by_parts, is_not), (by_parts, False), arguments)
        self.assertEqual(found["files"].keys(), wanted["files"].keys())
        for file, content in found.pop("files").items():
            self.assertTrue(content == wanted["files"][file], (file, arguments))
        wanted.pop("files")
        self.assertEqual(found, wanted, arguments)
        return found

    def test_bytes_and_messages_are_those_of_whole_meshes(self):
        for choice, (name, *form) in itertools.product(CHOICES, NAMES):
            with self.subTest(choice=choice, name=name, form=form):
                self.assert_same(name, *GYROID, *choice, *form)
        self.assert_same("a.gltf", *GYROID, *HOLES, *VECTORS, *COLORS)

    def test_of_any_mesh(self):
        for more in (("--method", "mt"), ("--normals", "none"), ("--normals", "none", "--cap"), ("--cap", "--method", "mt", "--normals", "none"),
                     ("--threads", 1), ("--threads", 5), ("--roi", "-.5,-.4,-.3,.9,.9,.8", "--roi-snap")):
            for choice, (name, *form) in itertools.product(((*HOLES, *VECTORS, *COLORS), CHOICES[6]), NAMES):
                with self.subTest(more=more, choice=choice, name=name, form=form):
                    is_small = name == "a.glb" and "--roi" in more  # its indices have 16 bits
                    self.assert_same(name, *GYROID, *choice, *more, *form, by_parts=not is_small)
        for choice in CHOICES[:6]:  # the normals of faces need two parts
            self.assert_same("a.ply", *GYROID, *choice, "--normals", "flat")
            self.assert_same("a.ply", *GYROID, *choice, "--normals", "flat", "--ascii")

    def test_sparse_fields_and_sparse_attributes(self):
        own = ("--attribute", "d=density", "--color-by", "d")
        for choice, (name, *form) in itertools.product(((*WAVE, *HOLES), own), NAMES):
            with self.subTest(choice=choice, name=name, form=form):
                is_small = name == "a.glb"  # its indices have 16 bits
                self.assert_same(name, *METABALLS, *choice, *form, by_parts=not is_small)
        self.assert_same("a.glb", *GYROID, "--attribute", f"d={SOURCE / 'samples/metaballs.vdb'}[density]")

    def test_of_particles(self):
        """Some vertices are out of every particle's reach, and get the values of the nearest one."""
        numbers = random.Random(4)
        rows = "".join("{},{},{},{},{}\n".format(*(numbers.uniform(0, 1) for _ in range(4)), n) for n in range(400))
        (self.folder / "p.csv").write_text("x,y,z,t,n\n" + rows)
        particles = ("p.csv", "--radius", 0.05, "--cell-size", 0.2)
        for more in (("--iso", 0.1), ("--particles", "anisotropic", "--iso", 0.02)):
            for choice in (("--attribute", "t", "--attribute", "n"), ("--color-by", "t"), ("--attribute", "n", "--color-by", "t:0,1")):
                for name, *form in NAMES:
                    with self.subTest(more=more, choice=choice, name=name, form=form):
                        self.assert_same(name, *particles, *more, *choice, *form)

    def test_report(self):
        for choice, name in itertools.product(((*WAVE, *HOLES), COLORS, (*VECTORS, *COLORS)), ("a.ply", "a.glb")):
            with self.subTest(choice=choice, name=name):
                found = self.assert_same(name, *GYROID, *choice, "--report", "r.json")
                self.assertEqual(len(found["attributes"]), len(choice) // 2)
        outside = self.assert_same("a.ply", *GYROID, *HOLES, "--report", "r.json")["attributes"][0]
        self.assertGreater(outside["outside"], 1000)
        self.assertGreater(outside["not_finite"], 10)

    def test_selected_bodies(self):
        """Counts are those of all vertices; ranges of colors, and values that glTF lacks, those of the written ones."""
        size, numbers = 73, random.Random(5)
        samples = [numbers.random() for _ in range(size**3)]
        for step in (1, size, size * size):  # means of neighbors
            samples = [(a + b) / 2 for a, b in zip(samples, samples[step:] + samples[:step])]
        (self.folder / "a.raw").write_bytes(struct.pack(f"<{size**3}f", *samples))
        heat = [numbers.uniform(0, 1) for _ in range(size**3)]
        heat[5 + 7 * size] = 50
        heat[-1] = float("nan")
        (self.folder / "heat.npy").write_bytes(npy((size, size, size), heat))
        raw = ("a.raw", "--dims", f"{size},{size},{size}", "--dtype", "f32", "--report", "r.json", "--normals", "none")
        for name in ("a.ply", "a.glb"):
            for choice in (("--attribute", "h=heat.npy"), ("--color-by", "h=heat.npy")):
                for options in (("--iso", 0.54, "--largest"), ("--iso", 0.5, "--drop-components", 40)):
                    with self.subTest(name=name, choice=choice, options=options):
                        self.assert_same(name, *raw, *options, *choice, parts=("--memory-limit", "26M"), whole=WHOLE_BODIES)

    def test_streams(self):
        for name, *form in NAMES:
            for choice in ((*HOLES, *VECTORS, *COLORS), (*WAVE, *VECTORS), (*WAVE, *COLORED_HOLES)):
                with self.subTest(name=name, form=form, choice=choice):
                    file = self.convert(*GYROID, *choice, *form, *WHOLE, "-o", name, "-v")
                    whole = (self.folder / name).read_bytes()
                    run = self.convert(*GYROID, *choice, *form, "-o", "-", "--format", name[2:], "-v")
                    self.assertIn("extracted and written", run.err)
                    self.assertTrue(run.out == whole)
                    self.assertEqual(told(run), told(file))

    def test_missing_attributes(self):
        missing = ("--attribute", "gone?=gone.npy")
        for choice in (missing, (*missing, *WAVE), ("--color-by", "gone?=gone.npy"), (*WAVE, "--color-by", "gone?=gone.npy")):
            with self.subTest(choice=choice):
                self.assert_same("a.ply", *GYROID, *choice)
                self.assert_same("a.glb", *GYROID, *choice)

    def test_memory_does_not_grow_with_the_mesh(self):
        """Of 4 million vertices: 144 MiB of mesh, and 120 MiB of values and colors."""
        size = 160
        layer = [bytes([255 * (z % 2)]) * size**2 for z in range(2)]
        (self.folder / "layers.raw").write_bytes(b"".join(layer[z % 2] for z in range(size)))
        layers = ("layers.raw", "--dims", f"{size},{size},{size}", "--iso", 100, "--normals", "none", "--spacing", .01)
        for name in ("a.ply", "a.glb"):
            for choice in ((*HOLES, *COLORS), VECTORS):
                output = (*layers, *choice, "-o", name)
                limit = ("--memory-limit", "28M")
                self.assert_fails(2, self.run_program(*output, *limit, *WHOLE_BODIES), "triangles", "--memory-limit")
                self.convert(*output)
                content = (self.folder / name).read_bytes()
                for threads in (1, 40):
                    self.convert(*output, *limit, "--threads", threads)
                    self.assertTrue((self.folder / name).read_bytes() == content)

    def test_dry_runs_expect_no_whole_mesh(self):
        def expected(*more):
            run = self.convert("demo:gyroid?size=200", "--iso", 0, "-o", "a.ply", "--dry-run", *more)
            return float(re.search(r"([0-9.]+) MiB", run.out.decode() + run.err)[1])

        self.assertLess(expected(*WAVE, *VECTORS), expected() + 8)
        self.assertGreater(expected(*WAVE, *VECTORS, *WHOLE_BODIES), expected(*WHOLE_BODIES) + 30)


if __name__ == "__main__":
    main()
