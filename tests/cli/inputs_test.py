"""Where volumes come from besides a file of one: stdin, files of several time steps, demo fields at a time."""

import gzip
import json
import os
import pathlib
import pty
import struct
import subprocess
import time

from support import DATA, PROGRAM, SOURCE, SPHERE, ProgramTest, main, needs_data, read_ply

DIMS = (9, 8, 7)
STEPS = 5


def ball(x, y, z, step):
    """Positive inside a ball that grows and moves with the steps."""
    return 2.0 + 0.2 * step - ((x - 4 + 0.1 * step)**2 + (y - 3.5)**2 + (z - 3)**2)**0.5


def samples(step):
    values = [ball(x, y, z, step) for z in range(DIMS[2]) for y in range(DIMS[1]) for x in range(DIMS[0])]
    return struct.pack(f"<{len(values)}f", *values)


ALL = b"".join(samples(step) for step in range(STEPS))
ZYX = ", ".join(str(n) for n in reversed(DIMS))


def npy(shape, data):
    text = f"{{'descr': '<f4', 'fortran_order': False, 'shape': ({shape}), }}\n".encode()
    return b"\x93NUMPY\1\0" + struct.pack("<H", len(text)) + text + data


def nifti(steps, data):
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3 if steps is None else 4, *DIMS, steps or 1, 1, 1, 1)
    struct.pack_into("<hh", header, 70, 16, 32)
    struct.pack_into("<8f", header, 76, *[1.0] * 8)
    struct.pack_into("<f", header, 108, 352)
    header[344:347] = b"n+1"
    return bytes(header) + data


def nrrd(fields, data, encoding="raw"):
    return (f"NRRD0005\ntype: float\n{fields}endian: little\nencoding: {encoding}\n\n").encode() + data


X, Y, Z = DIMS
NRRD_ONE = f"dimension: 3\nsizes: {X} {Y} {Z}\n"
NRRD_ALL = f"dimension: 4\nsizes: {X} {Y} {Z} {STEPS}\nkinds: domain domain domain time\n"


class SeriesTest(ProgramTest):
    def mesh(self, *arguments, **options):
        run = self.run_program(*arguments, "--iso", "0", "--format", "ply", "-o", "-", "-q", **options)
        self.assertEqual(run.code, 0, run.err)
        return run.out

    def write(self, name, data):
        (self.folder / name).write_bytes(data)
        return name

    def series(self):
        """Each name, and how a file of one step alone would be written."""
        lanes = b"".join(ALL[4 * (n + s * X * Y * Z):][:4] for n in range(X * Y * Z) for s in range(STEPS))
        fast = f"dimension: 4\nsizes: {STEPS} {X} {Y} {Z}\nkinds: list domain domain domain\n"
        yield self.write("s.npy", npy(f"{STEPS}, {ZYX}", ALL)), lambda data: npy(ZYX, data)
        yield self.write("s.nii", nifti(STEPS, ALL)), lambda data: nifti(None, data)
        yield self.write("s.nii.gz", gzip.compress(nifti(STEPS, ALL))), lambda data: gzip.compress(nifti(None, data))
        yield self.write("s.nrrd", nrrd(NRRD_ALL, ALL)), lambda data: nrrd(NRRD_ONE, data)
        yield self.write("z.nrrd", nrrd(NRRD_ALL, gzip.compress(ALL), "gzip")), lambda data: nrrd(NRRD_ONE, data)
        yield self.write("f.nrrd", nrrd(fast, lanes)), lambda data: nrrd(NRRD_ONE, data)

    def test_a_step_gives_the_mesh_of_a_file_of_that_step(self):
        for name, alone in self.series():
            meshes = set()
            for step in range(STEPS):
                self.write("one" + "".join(pathlib.Path(name).suffixes), alone(samples(step)))
                wanted = self.mesh("one" + "".join(pathlib.Path(name).suffixes))
                self.assertEqual(self.mesh(name, "--volume", step), wanted, (name, step))
                meshes.add(wanted)
            self.assertEqual(len(meshes), STEPS)

    def test_a_choice_is_asked_for(self):
        for name, _ in self.series():
            run = self.run_program(name, "--iso", "0")
            self.assert_fails(2, run, f"{name}: expected the number of one volume, because the file has 5 volumes", "--volume K, K from 0 to 4")
            run = self.run_program(name, "--iso", "0", "--volume", "5")
            self.assert_fails(2, run, "there is no volume 5", "--volume K, K from 0 to 4")
        self.assertEqual([name for name in self.files() if name.endswith(".glb")], [])

    def test_choices_that_make_no_sense(self):
        self.write("one.npy", npy(ZYX, samples(0)))
        self.mesh("one.npy", "--volume", "0")
        self.assert_fails(2, self.run_program("one.npy", "--iso", "0", "--volume", "1"), "there is no volume 1",
                          "leave --volume out")
        self.assert_fails(1, self.run_program(SPHERE, "--iso", "0", "--volume", "0"), "leave --volume out")
        for bad in ("-1", "x", "1.5", "", "99999999999999999999"):
            self.assert_fails(1, self.run_program("one.npy", "--iso", "0", f"--volume={bad}"), "--volume")
        for command in (("info", ), ("verify", )):
            iso = () if command == ("info", ) else ("--iso", "0")
            self.assert_fails(1, self.run_program(*command, "one.npy", *iso, "--volume", "all"), "--volume all")
        for command in ("info", "verify", "bench", "render"):  # which the help does not promise either
            self.assertRegex(self.convert(command, "--help").text, r"--volume K\s")
        self.assertIn("--volume K|all", self.convert("convert", "--help").text)

    def test_info_counts_and_describes_one(self):
        for name, _ in self.series():
            run = self.convert("info", name)
            self.assertIn("volumes       5, counted from 0; this report describes 0, choose another with --volume K\n", run.text)
            self.assertIn(f" {name} --volume 0 --iso ", run.text)
            (first,) = json.loads(self.convert("info", "--json", name).text)
            (last,) = json.loads(self.convert("info", "--json", name, "--volume", "4").text)
            self.assertEqual((first["grids"][0]["volumes"], first["volume"], last["volume"]), (5, 0, 4))
            self.assertAlmostEqual(first["field"]["values"]["max"], max(struct.unpack(f"<{X*Y*Z}f", samples(0))), 5)
            self.assertAlmostEqual(last["field"]["values"]["max"], max(struct.unpack(f"<{X*Y*Z}f", samples(4))), 5)
            self.assertEqual(last["field"]["suggestion"]["command"].count("--volume"), 1)
            self.assertIn("--volume 4", last["field"]["suggestion"]["command"])
        (report,) = json.loads(self.convert("info", "--json", SPHERE).text)
        self.assertEqual((report["grids"][0]["volumes"], report["volume"]), (1, None))

    def test_verify_takes_a_step(self):
        self.write("s.npy", npy(f"{STEPS}, {ZYX}", ALL))
        self.convert("s.npy", "--volume", "3", "--iso", "0", "-o", "3.ply")
        self.convert("verify", "s.npy", "--volume", "3", "--iso", "0", "3.ply")
        self.assertEqual(self.run_program("verify", "s.npy", "--volume", "2", "--iso", "0", "3.ply").code, 6)

    def test_the_report_names_the_step(self):
        self.write("s.npy", npy(f"{STEPS}, {ZYX}", ALL))
        self.convert("s.npy", "--volume", "3", "--iso", "0", "-o", "3.ply", "--report", "3.json")
        self.assertEqual(json.loads((self.folder / "3.json").read_text())["options"]["volume"], 3)

    def test_headers_that_lie(self):
        for name, data in (("short.nii", nifti(32767, samples(0))), ("short.npy", npy(f"9999, {ZYX}", samples(0))),
                           ("wraps.npy", npy("4611686018427387904, 4, 4, 4", samples(0))),
                           ("short.nii.gz", gzip.compress(nifti(32767, samples(0))))):
            self.write(name, data)
            self.assert_fails(2, self.run_program(name, "--iso", "0", "--volume", "0"), f"{name}: ", " volumes")


class StandardInputTest(ProgramTest):
    def piped(self, data, *arguments):
        """The bytes through a pipe."""
        with subprocess.Popen([PROGRAM, *(str(argument) for argument in arguments)], cwd=self.folder,
                              stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            out, err = process.communicate(data, timeout=120)
        return process.returncode, out, err.decode()

    def inputs(self):
        yield "s.npy", npy(ZYX, samples(1)), ()
        yield "4.npy", npy(f"{STEPS}, {ZYX}", ALL), ("--volume", "2")
        yield "s.nrrd", nrrd(NRRD_ONE, samples(1)), ()
        yield "z.nrrd", nrrd(NRRD_ONE, gzip.compress(samples(1)), "gzip"), ()
        yield "s.nii", nifti(None, samples(1)), ()
        yield "s.nii.gz", gzip.compress(nifti(None, samples(1))), ()
        yield "4.nii.gz", gzip.compress(nifti(STEPS, ALL)), ("--volume", "4")
        yield "s.raw", samples(1), ("--dims", f"{X},{Y},{Z}", "--dtype", "f32")
        yield "s.vdb", (SOURCE / "samples/metaballs.vdb").read_bytes(), ()

    def test_every_format_gives_the_mesh_of_its_file(self):
        for name, data, options in self.inputs():
            (self.folder / name).write_bytes(data)
            arguments = ("--iso", "0.5", *options, "-q", "--format", "ply", "-o", "-")
            wanted = self.convert(name, *arguments).out
            self.assertGreater(len(read_ply(wanted).triangles), 10)
            code, out, err = self.piped(data, "-", *arguments)
            self.assertEqual((code, err), (0, ""), name)
            self.assertEqual(out, wanted, name)
            with open(self.folder / name, "rb") as file:
                self.assertEqual(self.convert("-", *arguments, stdin=file).out, wanted, name)

    @needs_data("vdb/smoke.vdb")
    def test_a_vdb_through_a_pipe(self):
        path = DATA / "vdb/smoke.vdb"
        self.convert(path, "--iso", "0.5", "-o", "file.glb")
        code, _, err = self.piped(path.read_bytes(), "-", "--iso", "0.5", "-o", "pipe.glb")
        self.assertEqual(code, 0, err)
        self.assertEqual((self.folder / "pipe.glb").read_bytes(), (self.folder / "file.glb").read_bytes())
        self.assertIn("standard input", err)

    def test_the_rest_of_a_file_that_was_read_in_part(self):
        (self.folder / "v").write_bytes(b"x" * 10 + npy(ZYX, samples(1)))
        (self.folder / "s.npy").write_bytes(npy(ZYX, samples(1)))
        with open(self.folder / "v", "rb", buffering=0) as file:
            os.lseek(file.fileno(), 10, os.SEEK_SET)
            run = self.convert("-", "--iso", "0", "-q", "--format", "ply", "-o", "-", stdin=file)
        self.assertEqual(run.out, self.convert("s.npy", "--iso", "0", "-q", "--format", "ply", "-o", "-").out)

    def test_a_slow_pipe(self):
        data = npy(ZYX, samples(1))
        with subprocess.Popen([PROGRAM, "-", "--iso", "0", "-q", "-o", "out.ply"], cwd=self.folder,
                              stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            for at in range(0, len(data), 300):
                process.stdin.write(data[at:at + 300])
                process.stdin.flush()
                time.sleep(0.02)
            process.stdin.close()
            self.assertEqual(process.wait(timeout=60), 0, process.stderr.read())
        self.assertGreater(len(read_ply((self.folder / "out.ply").read_bytes()).triangles), 10)

    def test_info_and_verify(self):
        data = npy(ZYX, samples(1))
        code, out, err = self.piped(data, "info", "-")
        self.assertEqual((code, err), (0, ""))
        self.assertTrue(out.startswith(b"standard input\n"), out)
        self.assertIn(b"isoextract - --iso ", out)
        code, out, _ = self.piped(data, "info", "--json", SPHERE, "-")
        self.assertEqual(code, 0)
        self.assertEqual([entry["input"] for entry in json.loads(out)], [SPHERE, "-"])
        code, _, err = self.piped(data, "-", "--iso", "0", "-o", "out.ply")
        self.assertEqual(code, 0, err)
        code, _, err = self.piped(data, "verify", "-", "--iso", "0", "out.ply")
        self.assertEqual(code, 0, err)

    def fails(self, code, data, arguments, *parts):
        found, out, err = self.piped(data, *arguments)
        self.assertEqual(found, code, err)
        self.assertEqual(out, b"")
        for part in parts:
            self.assertIn(part, err)
        self.assertEqual(self.files(), [])

    def test_known_formats_that_are_not_read(self):
        by_name = (("a.EXO", "Exodus"), ("a.inr", "INRIMAGE"), ("a.mgz", "FreeSurfer"))
        for name, title in by_name:
            (self.folder / name).write_bytes(b"whatever it holds")
            run = self.run_program(name, "--iso", "0", "-o", "out.ply")
            self.assert_fails(2, run, f"{name}: its name says that it is", title, "hint: ")
            self.assert_fails(2, self.run_program("info", name), title)
        by_content = ((b"BPHYSICS" + bytes(9), "Blender"), (b"Ogawa" + bytes(9), "Alembic"))
        for content, title in by_content:
            (self.folder / "unnamed").write_bytes(content)
            run = self.run_program("unnamed", "--iso", "0", "-o", "out.ply")
            self.assert_fails(2, run, "unnamed: its content says that it is", title, "hint: ")
        # Cut off before the magic is whole, it is nothing that is known.
        (self.folder / "unnamed").write_bytes(b"BPHYSIC")
        self.assert_fails(2, self.run_program("unnamed", "--iso", "0"), "not a volume format")
        self.assertNotIn("out.ply", self.files())

    def test_what_is_no_volume(self):
        convert = ("-", "--iso", "0", "-o", "out.ply")
        whole = npy(ZYX, samples(1))
        self.fails(2, b"", convert, "standard input: it is empty")
        self.fails(2, b"x", convert, "standard input: not a volume format")
        self.fails(2, b"\x1f\x8b", convert, "standard input")
        self.fails(2, whole[:-1], convert, "standard input: expected 2016 bytes")
        self.fails(2, whole[:20], convert, "standard input")
        self.fails(2, gzip.compress(nifti(None, samples(1)))[:-20], convert, "standard input")
        self.fails(2, (SOURCE / "samples/metaballs.vdb").read_bytes()[:2000], convert, "standard input")
        self.fails(2, b"NRRD0005\ntype: float\n" + NRRD_ONE.encode() + b"encoding: raw\nendian: little\ndata file: a.raw\n",
                   convert, "standard input: the header names the data file 'a.raw'")
        self.fails(1, samples(1), (*convert, "--input-format", "raw"), "standard input", "--dims")
        pair = bytearray(nifti(None, b""))
        pair[344:347] = b"ni1"
        self.fails(2, bytes(pair), convert, "standard input", "pair")

    def test_what_makes_no_sense(self):
        data = npy(ZYX, samples(1))
        self.fails(1, data, ("-", "--iso", "0"), "-o FILE")
        self.fails(1, data, ("info", "-", "-"), "twice")
        self.fails(1, data, ("compare", "-", "a.ply"), "stdin")
        self.fails(2, data, ("-", "--iso", "0", "-o", "out.ply", "--memory-limit", "1K"), "--memory-limit")

    def test_a_terminal_is_refused(self):
        ours, theirs = pty.openpty()
        try:
            self.assert_fails(1, self.run_program("-", "--iso", "0", "-o", "out.ply", stdin=theirs), "terminal")
        finally:
            os.close(ours)
            os.close(theirs)
        self.assertEqual(self.files(), [])

    def test_a_closed_stdin_and_a_folder(self):
        for redirection in ("<&-", "< ."):
            run = subprocess.run(["bash", "-c", f'"$0" - --iso 0 -o out.ply {redirection}', PROGRAM], cwd=self.folder,
                                 capture_output=True, check=False)
            self.assertEqual(run.returncode, 2, run.stderr)
            self.assertIn(b"standard input", run.stderr)

    def test_the_redirected_input_is_not_overwritten(self):
        path = self.folder / "v.ply"
        path.write_bytes(npy(ZYX, samples(1)))
        with open(path, "rb") as file:
            self.assert_fails(1, self.run_program("-", "--iso", "0", "-o", "v.ply", stdin=file), "this is the input")
        self.assertEqual(path.read_bytes(), npy(ZYX, samples(1)))

    def test_files_of_attributes_are_not_overwritten(self):
        path = self.folder / "t.ply"
        path.write_bytes(npy(ZYX, samples(1)))
        with subprocess.Popen(["cat", path], stdout=subprocess.PIPE) as pipe:
            run = self.run_program("-", "--iso", "0", "--attribute", "t=t.ply", "-o", "t.ply", stdin=pipe.stdout)
        self.assert_fails(1, run, "t.ply: this holds samples or attributes of the input; it is not overwritten")
        self.assertEqual(path.read_bytes(), npy(ZYX, samples(1)))

    def test_a_file_of_that_name(self):
        (self.folder / "-").write_bytes(npy(ZYX, samples(1)))
        self.convert("./-", "--iso", "0", "-o", "out.ply")


class DemoTimeTest(ProgramTest):
    def mesh(self, spec):
        return self.convert(spec, "--iso", "0", "-q", "--format", "ply", "-o", "-").out

    def test_periods(self):
        for name in ("sphere", "gyroid", "metaballs"):
            still = self.mesh(f"demo:{name}?size=24")
            self.assertEqual(self.mesh(f"demo:{name}?size=24&time=0"), still)
            self.assertEqual(self.mesh(f"demo:{name}?time=1&size=24"), still)
            self.assertNotEqual(self.mesh(f"demo:{name}?size=24&time=0.25"), still)

    def test_fields_that_stand_still_say_so(self):
        run = self.run_program("demo:torus?time=0.5", "--iso", "0")
        self.assert_fails(1, run, "torus does not move", "sphere, gyroid, metaballs")

    def test_the_help_tells(self):
        text = self.convert("help", "demo").text
        self.assertIn("time=T", text)
        self.assertEqual(text.count("with time: "), 3)

    def test_the_error_of_a_field_that_moved_is_that_of_its_samples(self):
        for time_key, formula in (("", True), ("&time=0.25", False)):
            self.convert(f"demo:sphere?size=24{time_key}", "--iso", "0", "--error", "-o", "a.ply", "--report", "a.json")
            (mesh,) = json.loads((self.folder / "a.json").read_text())["meshes"]
            self.assertEqual(mesh["error"]["analytic"] is not None, formula)


class FoldersTest(ProgramTest):
    def test_what_a_folder_holds_instead(self):
        (self.folder / "scan").mkdir()
        for slice_ in ("I10", "I9", "I100"):
            (self.folder / "scan" / slice_).write_bytes(b"BPHYSICS" + bytes(400))
        run = self.run_program("scan", "--iso", "1", "-o", "a.ply")
        self.assert_fails(2, run, "no file in the folder has the extension of a volume", "I9: its content says that it is a Blender particle cache",
                          "Blender writes its particles as PLY points")
        self.assert_fails(2, self.run_program("info", "scan"), "no file in the folder has the extension of a volume", "I9: its content says that it is a Blender particle cache")
        run = self.run_program("scan/I*", "--iso", "1", "-o", "a.ply")
        self.assert_fails(1, run, "scan/I*: there is no such file, and isoextract does not expand *", "write {} in place of the frame number")
        (self.folder / "notes").mkdir()
        (self.folder / "notes/a.txt").write_text("nothing")
        run = self.run_program("notes", "--iso", "1", "-o", "a.ply")
        self.assert_fails(2, run, "no file in the folder has the extension of", "give a pattern, with the folder before it, to find files of any name")


if __name__ == "__main__":
    main()
