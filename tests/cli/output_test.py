"""Files: what cannot be read or written, what is never left behind, what does not depend on the number of threads."""

import os
import subprocess

from support import DATA, PROGRAM, SPHERE, ProgramTest, Run, main, needs_data, read_glb, read_ply

FORMATS = ("glb", "gltf", "ply", "obj", "stl")


class OutputTest(ProgramTest):
    def test_pieces_need_data_files_of_their_own(self):
        run = self.run_program("demo:gyroid?size=24", "--iso", "0.8", "--cap", "--split-components", "--format", "gltf",
                               "-o", "a.{piece}")
        self.assert_fails(1, run, "a.bin: all bodies would share this file", "put {piece} before the extension")
        self.assertEqual(self.files(), [])

    def test_inputs_that_cannot_be_read(self):
        (self.folder / "text.vdb").write_text("This is not a volume.\n")
        (self.folder / "empty.nrrd").write_bytes(b"")
        (self.folder / "folder").mkdir()
        before = self.files()
        for name in ("missing.vdb", "text.vdb", "empty.nrrd", "folder", "/dev/null"):
            run = self.run_program(name, "--iso", "0", "-o", "out.glb")
            self.assert_fails(2, run, name)
            self.assertEqual(self.files(), before)

    def test_raw_file_of_the_wrong_size(self):
        self.write_raw("a.raw", (4, 4, 4), lambda x, y, z: x)
        run = self.run_program("a.raw", "--dims", "4,4,5", "--dtype", "f32", "--iso", "0", "-o", "out.glb")
        self.assert_fails(2, run, "a.raw", "320", "256")

    def test_raw_file_without_dims(self):
        self.write_raw("a.raw", (4, 4, 4), lambda x, y, z: x)
        run = self.run_program("a.raw", "--iso", "0")
        self.assertIn(run.code, (1, 2))
        self.assertIn("--dims", run.err)

    def test_memory_limit(self):
        run = self.run_program("demo:sphere?size=128", "--iso", "0", "--memory-limit", "1M")
        self.assert_fails(2, run, "8 MiB", "1 MiB", "--memory-limit")

    def test_outputs_that_cannot_be_written(self):
        (self.folder / "sphere.glb").mkdir()
        for name in (".", "missing/out.glb", "/proc/out.glb"):  # the first is sphere.glb in the folder, and so is a folder
            run = self.run_program(SPHERE, "--iso", "0", "-o", name)
            self.assert_fails(4, run, "sphere.glb: expected a file, found a folder" if name == "." else name)
            self.assertEqual(self.files(), ["sphere.glb"])

    def test_an_output_that_cannot_be_written_is_found_before_the_work(self):
        run = self.run_program("missing.vdb", "--iso", "0", "-o", "missing/out.glb")
        self.assert_fails(4, run)

    def test_full_disk(self):
        for form in ("ply", "glb", "stl", "obj"):
            run = self.run_program(SPHERE, "--iso", "0", "--format", form, "-o", "/dev/full")
            self.assert_fails(4, run, "/dev/full", "no space left")
            with open("/dev/full", "wb") as full:
                run = self.run_program(SPHERE, "--iso", "0", "--format", form, "-o", "-", stdout=full)
            self.assert_fails(4, run, "no space left")

    def test_a_file_size_limit_leaves_the_old_file(self):
        for name in ("out.glb", "out.gltf", "out.ply", "out.obj", "out.stl"):
            path = self.folder / name
            path.write_text("old")
            command = 'ulimit -f 4; trap "" XFSZ; exec "$0" demo:sphere?size=64 --iso 0 -o "$1"'
            run = subprocess.run(["bash", "-c", command, PROGRAM, name], cwd=self.folder, capture_output=True, check=False)
            self.assertEqual(run.returncode, 4, run.stderr)
            self.assertEqual(self.files(), [name])
            self.assertEqual(path.read_text(), "old")
            path.unlink()

    def test_no_permission(self):
        self.folder.chmod(0o555)
        self.addCleanup(self.folder.chmod, 0o755)
        # Root may write everywhere, unless it gives that up.
        ordinary = ["setpriv", "--bounding-set=-dac_override"] if os.geteuid() == 0 else []
        run = Run(subprocess.run([*ordinary, PROGRAM, SPHERE, "--iso", "0", "-o", "out.glb"], cwd=self.folder,
                                 capture_output=True, timeout=120, check=False))
        self.assert_fails(4, run, "out.glb", "permission")

    def test_failures_leave_an_existing_output_alone(self):
        path = self.folder / "out.ply"
        path.write_text("precious")
        for arguments in ((SPHERE, "--iso", "9"), ("missing.vdb", "--iso", "0"), (SPHERE, "--iso", "x"),
                          (SPHERE, "--iso", "0", "--roi", "5,5,5,6,6,6")):
            self.assertNotEqual(self.run_program(*arguments, "-o", "out.ply").code, 0)
            self.assertEqual(path.read_text(), "precious")
            self.assertEqual(self.files(), ["out.ply"])

    def test_a_killed_run_leaves_nothing(self):
        process = subprocess.Popen([PROGRAM, "demo:random?size=256", "--iso", "0", "-o", "out.obj"], cwd=self.folder,
                                   stderr=subprocess.DEVNULL)
        try:
            process.wait(timeout=0.7)
        except subprocess.TimeoutExpired:
            process.terminate()
            process.wait(timeout=30)
            self.assertEqual(self.files(), [])

    def test_an_existing_output_is_replaced(self):
        (self.folder / "out.ply").write_text("old")
        self.convert(SPHERE, "--iso", "0", "-o", "out.ply")
        self.assertGreater(len(read_ply((self.folder / "out.ply").read_bytes()).triangles), 0)

    def test_the_input_is_never_overwritten(self):
        path = self.write_raw("a.ply", (4, 4, 4), lambda x, y, z: x)
        (self.folder / "link.ply").symlink_to("a.ply")
        os.link(path, self.folder / "a.bin")
        before = path.read_bytes()
        raw = ("a.ply", "--input-format", "raw", "--dims", "4,4,4", "--dtype", "f32", "--iso", "1.5")
        for out in ("a.ply", "./a.ply", "link.ply", "a.gltf"):
            self.assert_fails(1, self.run_program(*raw, "-o", out), "this is the input")
            self.assertEqual(path.read_bytes(), before)

    def test_the_data_file_of_a_header_is_never_overwritten(self):
        path = self.write_raw("a.bin", (4, 4, 4), lambda x, y, z: x)
        (self.folder / "a.nhdr").write_text("NRRD0005\ntype: float\ndimension: 3\nsizes: 4 4 4\nencoding: raw\n"
                                            "endian: little\ndata file: a.bin\n\n")
        (self.folder / "link.ply").symlink_to("a.bin")
        os.link(path, self.folder / "hard.ply")
        before = path.read_bytes()
        for arguments in (("-o", "a.gltf"), ("-o", "link.ply"), ("-o", "hard.ply"), ("-o", "b.ply", "--report", "a.bin")):
            run = self.run_program("a.nhdr", "--iso", "1.5", "-q", *arguments)
            self.assert_fails(1, run, "this holds samples or attributes of the input")
            self.assertEqual(path.read_bytes(), before)
        self.assertEqual(self.files(), ["a.bin", "a.nhdr", "hard.ply", "link.ply"])

    def test_default_name(self):
        self.convert(SPHERE, "--iso", "0")
        self.convert(SPHERE, "--iso", "0", "--format", "ply")
        (self.folder / "below").mkdir()
        self.write_raw("below/scan.1.raw", (4, 4, 4), lambda x, y, z: x)
        self.convert("below/scan.1.raw", "--dims", "4,4,4", "--dtype", "f32", "--iso", "1.5")
        self.assertEqual(self.files(), ["below", "scan.1.glb", "sphere.glb", "sphere.ply"])

    def test_format_overrides_the_extension(self):
        self.convert(SPHERE, "--iso", "0", "-o", "out.dat", "--format", "ply")
        read_ply((self.folder / "out.dat").read_bytes())
        run = self.convert(SPHERE, "--iso", "0", "-o", "out.stl", "--format", "ply")
        self.assertIn("note[format-not-by-name]: out.stl: isoextract writes ply because of --format", run.err)
        read_ply((self.folder / "out.stl").read_bytes())
        self.convert(SPHERE, "--iso", "0", "-o", "out.PLY")
        read_ply((self.folder / "out.PLY").read_bytes())

    def test_gltf_names_both_its_files(self):
        run = self.convert(SPHERE, "--iso", "0", "-o", "out.gltf")
        self.assertEqual(self.files(), ["out.bin", "out.gltf"])
        self.assertIn("out.gltf", run.err)

    def test_ascii_holds_the_same_mesh(self):
        self.convert(SPHERE, "--iso", "0", "-o", "b.ply")
        self.convert(SPHERE, "--iso", "0", "--ascii", "-o", "a.ply")
        binary, text = (read_ply((self.folder / name).read_bytes()) for name in ("b.ply", "a.ply"))
        self.assertIn(b"format ascii", (self.folder / "a.ply").read_bytes())
        self.assertEqual(text.triangles, binary.triangles)
        self.convert(SPHERE, "--iso", "0", "--ascii", "-o", "a.stl")
        self.assertTrue((self.folder / "a.stl").read_bytes().startswith(b"solid"))

    def test_same_bytes_for_any_number_of_threads(self):
        for method in ("mc", "mt"):
            for form in FORMATS:
                bytes_of = set()
                for threads in (1, 2, 7):
                    name = f"out.{form}"
                    self.convert("demo:gyroid?size=48", "--iso", "0.1", "--method", method, "--normals",
                                 "flat" if form == "stl" else "smooth", "--cap", "--threads", threads, "-o", name)
                    data = (self.folder / name).read_bytes()
                    if form == "gltf":
                        data += (self.folder / "out.bin").read_bytes()
                    bytes_of.add(data)
                self.assertEqual(len(bytes_of), 1, f"{method} {form}")

    @needs_data("vdb/smoke.vdb")
    def test_a_vdb_has_the_same_bytes_for_any_number_of_threads(self):
        bytes_of = set()
        for threads in (1, 2, 7):
            self.convert(DATA / "vdb/smoke.vdb", "--iso", "0.5", "--threads", threads, "-o", "out.glb")
            bytes_of.add((self.folder / "out.glb").read_bytes())
        self.assertEqual(len(bytes_of), 1)
        (mesh,) = read_glb(bytes_of.pop()).values()
        self.assertEqual(mesh.open_edges(), 0)

    @needs_data("vdb/c42_gas_seq/fluid_data_0010.vdb")
    def test_a_missing_choice_of_grid_lists_the_grids(self):
        path = DATA / "vdb/c42_gas_seq/fluid_data_0010.vdb"
        run = self.run_program(path, "--iso", "0.5", "-o", "out.glb")
        self.assert_fails(2, run, "--grid", "density")
        self.assert_fails(2, self.run_program(path, "--iso", "0.5", "--grid", "densty"), "densty", "density")
        self.convert(path, "--iso", "0.5", "--grid", "density", "-o", "out.glb")
        self.assertEqual(self.files(), ["out.glb"])


if __name__ == "__main__":
    main()
