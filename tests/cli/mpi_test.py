"""Runs of several ranks under mpirun write what one process writes. Skipped without Open MPI or without the plug-in."""

import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import time
import unittest

from support import PROGRAM, SOURCE, ProgramTest, Run, main, run_limited

FRAMES = 12


def mpirun():
    """The launcher of Open MPI, or None."""
    path = shutil.which("mpirun")
    if path is None:
        return None
    version = subprocess.run([path, "--version"], capture_output=True, check=False).stdout
    return path if b"Open MPI" in version else None


LAUNCHER = mpirun()
PLUGIN = pathlib.Path(PROGRAM).parent / "plugins/isoextract-ranks-mpi.so"
# Ranks of a test share one processor. Open MPI warns of nothing then.
ENVIRONMENT = dict(os.environ, OMPI_MCA_btl_base_warn_component_unused="0", OMPI_MCA_hwloc_base_binding_policy="none")


def command_of(ranks, *arguments):
    return [LAUNCHER, "--allow-run-as-root", "--oversubscribe", "-n", str(ranks), PROGRAM,
            *(str(argument) for argument in arguments)]


def processes_of(rank, parent):
    """Process ids of this program with that rank, among the descendants of a process."""
    found = []
    for entry in pathlib.Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            environment = (entry / "environ").read_bytes().split(b"\0")
            name = os.readlink(entry / "exe")
            ancestor = int((entry / "stat").read_text().rsplit(")", 1)[1].split()[1])
        except (OSError, ValueError):
            continue
        if name == os.path.realpath(PROGRAM) and ancestor == parent and f"OMPI_COMM_WORLD_RANK={rank}".encode() in environment:
            found.append(int(entry.name))
    return found


@unittest.skipUnless(LAUNCHER and PLUGIN.exists(), "no mpirun of Open MPI, or no plug-in: scripts/setup.sh test mpi")
class MpiTest(ProgramTest):
    def run_ranks(self, ranks, *arguments, **environment):
        finished = run_limited(command_of(ranks, *arguments), cwd=self.folder, stdin=subprocess.DEVNULL,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=dict(ENVIRONMENT, **environment))
        return Run(finished)

    def assert_done(self, run):
        self.assertEqual(run.code, 0, run.err)
        return run

    def write_frames(self, count=FRAMES, size=24):
        for number in range(count):
            radius = 0.3 + 0.05 * number

            def value(x, y, z, radius=radius):
                return radius - sum((2 * c / (size - 1) - 1) ** 2 for c in (x, y, z)) ** 0.5

            self.write_raw(f"in_{number:04}.raw", (size, size, size), value)
        return ["in_{:04}.raw", "--dims", f"{size},{size},{size}", "--dtype", "f32", "--iso", "0"]


class SequenceTest(MpiTest):
    def test_ranks_share_the_frames(self):
        inputs = self.write_frames()
        self.convert(*inputs, "-o", "one/f_{:04}.glb", "--mkdir", "--table", "one.json")
        run = self.assert_done(self.run_ranks(3, *inputs, "-o", "many/f_{:04}.glb", "--mkdir", "--table", "many.json", "-v"))
        names = sorted(path.name for path in (self.folder / "one").iterdir())
        self.assertEqual(len(names), FRAMES + 1)
        self.assertEqual(sorted(path.name for path in (self.folder / "many").iterdir()), names)
        for name in names:
            if name.endswith(".glb"):
                self.assertEqual((self.folder / "one" / name).read_bytes(), (self.folder / "many" / name).read_bytes())
        # One summary, of all frames.
        self.assertEqual(run.err.count("frames done"), 1, run.err)
        self.assertIn(f"{FRAMES} of {FRAMES} frames done", run.err)
        self.assertIn("note[shard]: 3 ranks on 1 machine share the frames", run.err)
        self.assertEqual(run.out, b"")
        done = [int(count) for count in re.findall(r"rank \d: (\d+) frames?, ", run.err)]
        self.assertEqual((len(done), sum(done)), (3, FRAMES), run.err)
        self.assertIn("the slowest rank took", run.err)
        # The table is that of one process, but for times.
        one, many = (json.loads((self.folder / name).read_text()) for name in ("one.json", "many.json"))
        self.assertEqual([row["surfaces"][0]["triangles"] for row in one], [row["surfaces"][0]["triangles"] for row in many])
        self.assertEqual(sum(row["rank"] == 0 for row in many), done[0])
        # The manifest lists each frame once, so that a later run of one process keeps all.
        kept = self.convert(*inputs, "-o", "many/f_{:04}.glb", "--resume")
        self.assertIn(f"{FRAMES} kept", kept.err)

    def test_progress_in_json(self):
        inputs = self.write_frames(5)
        run = self.assert_done(self.run_ranks(2, *inputs, "-o", "f_{:04}.ply", "--progress", "json"))
        lines = [json.loads(line) for line in run.err.splitlines()]
        self.assertEqual([line["event"] for line in lines], ["begin"] + ["frame"] * 5 + ["end"])
        self.assertEqual(sum(rank["frames"] for rank in lines[-1]["ranks"]), 5)
        self.assertGreaterEqual(lines[-1]["imbalance"], 1)

    def test_a_frame_that_fails_names_its_rank(self):
        inputs = self.write_frames(6)
        (self.folder / "in_0004.raw").write_bytes(b"short")
        one = self.run_program(*inputs, "-o", "one/f_{:04}.ply", "--mkdir")
        many = self.run_ranks(3, *inputs, "-o", "many/f_{:04}.ply", "--mkdir")
        self.assertEqual(one.code, 5, one.err)
        self.assertEqual(many.code, 5, many.err)
        self.assertRegex(many.err, r"error: frame 4 on rank \d: in_0004.raw: ")
        self.assertEqual(many.err.count("1 of 6 frames failed"), 1, many.err)
        # After the cause is fixed, --resume converts the one frame.
        shutil.copy(self.folder / "in_0003.raw", self.folder / "in_0004.raw")
        again = self.assert_done(self.run_ranks(3, *inputs, "-o", "many/f_{:04}.ply", "--resume"))
        self.assertIn("1 of 6 frames done, 5 kept", again.err)

    def test_a_killed_rank_ends_the_run_and_resume_completes_it(self):
        inputs = self.write_frames(FRAMES, 40)
        arguments = [*inputs, "-o", "out/f_{:04}.ply", "--mkdir", "--error", "--threads", "1"]
        with subprocess.Popen(command_of(3, *arguments), cwd=self.folder, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=ENVIRONMENT) as run:
            folder = self.folder / "out"
            while run.poll() is None and not (folder.is_dir() and list(folder.glob("*.ply"))):
                time.sleep(0.002)
            for process in processes_of(2, run.pid):
                os.kill(process, signal.SIGKILL)
            _, err = run.communicate()
        self.assertNotEqual(run.returncode, 0, err)
        self.assertIn(b"signal 9", err)
        self.assertEqual([path.name for path in folder.iterdir() if path.name.startswith(".")], [])
        done = len(list(folder.glob("*.ply")))
        self.assertLess(done, FRAMES)
        again = self.assert_done(self.run_ranks(3, *arguments, "--resume"))
        kept = re.search(r"(\d+) kept", again.err)
        self.assertGreaterEqual(int(kept[1]) if kept else 0, 1, again.err)
        self.convert(*inputs, "-o", "one/f_{:04}.ply", "--mkdir")
        for number in range(FRAMES):
            name = f"f_{number:04}.ply"
            self.assertEqual((folder / name).read_bytes(), (self.folder / "one" / name).read_bytes())

    def test_what_needs_all_frames_is_done_by_rank_0(self):
        inputs = self.write_frames(4)
        self.convert(*inputs, "-o", "a.glb", "--animate")
        one = (self.folder / "a.glb").read_bytes()
        run = self.assert_done(self.run_ranks(2, *inputs, "-o", "a.glb", "--animate"))
        self.assertIn("rank 0 converts all frames, because --animate", run.err)
        self.assertEqual((self.folder / "a.glb").read_bytes(), one)


class VolumeTest(MpiTest):
    """One conversion on several ranks."""

    SHARED = "ranks on 1 machine share the samples"
    ALONE = "rank 0 converts alone, because "

    def assert_same(self, ranks, name, told, *arguments):
        self.convert(*arguments, "-o", f"one-{name}")
        run = self.assert_done(self.run_ranks(ranks, *arguments, "-o", f"many-{name}", "-v"))
        self.assertEqual((self.folder / f"many-{name}").read_bytes(), (self.folder / f"one-{name}").read_bytes())
        self.assertEqual(run.err.count(f"many-{name}: "), 2, run.err)  # what was written, and in which time
        if ranks > 1:
            self.assertIn(told, run.err)
            self.assertEqual(len(re.findall(r"^rank \d: [\d.]+ s$", run.err, re.M)), ranks if told == self.SHARED else 0)
        else:
            self.assertNotIn("note[shard]", run.err)
        self.assertEqual([path for path in self.files() if path.startswith(".")], [])
        return run

    def test_dense_volumes_are_shared(self):
        for ranks in (1, 2, 4):
            for method in ("mc", "mt"):
                for name in ("a.ply", "a.glb"):
                    with self.subTest(ranks=ranks, method=method, name=name):
                        self.assert_same(ranks, name, self.SHARED, "demo:gyroid?size=90", "--iso", "0.1", "--method", method,
                                         "--normals", "smooth" if ranks == 2 else "none")

    def test_samples_of_a_file(self):
        self.write_raw("a.raw", (30, 40, 50), lambda x, y, z: x + (y * z) % 7 - 0.5 * ((x * y + z) % 11))
        self.assert_same(3, "b.ply", self.SHARED, "a.raw", "--dims", "30,40,50", "--dtype", "f32", "--iso", "6", "--roi", "2,3,5,28,35,47", "--roi-snap")

    def test_caps_are_shared(self):
        for ranks in (1, 2, 3, 4):
            for method in ("mc", "mt"):
                for name in ("a.ply", "a.glb"):
                    with self.subTest(ranks=ranks, method=method, name=name):
                        self.assert_same(ranks, name, self.SHARED, "demo:gyroid?size=100", "--iso", "0.1", "--method", method,
                                         "--normals", "none", "--cap", "--roi", "-0.95,-0.9,-0.93,0.94,0.8,0.9", "--roi-snap")

    def figures_of(self, name):
        """All of a report but times, memory, threads, names and notes."""
        def figures(value):
            if isinstance(value, dict):
                return {key: figures(part) for key, part in value.items()
                        if key not in ("arguments", "notes", "path", "file", "total") and not re.search("memory|seconds|threads", key)}
            return [figures(part) for part in value] if isinstance(value, list) else value

        return figures(json.loads((self.folder / name).read_text()))

    def assert_same_report(self, ranks, name, told, *arguments):
        self.convert(*arguments, "-o", name, "--report", "one.json")
        one = (self.folder / name).read_bytes()
        run = self.assert_done(self.run_ranks(ranks, *arguments, "-o", name, "--report", "many.json"))
        self.assertIn(told if ranks > 1 else "", run.err)
        self.assertEqual((self.folder / name).read_bytes(), one)
        expected = self.figures_of("one.json")
        self.assertGreater(json.dumps(expected).count("euler"), 0)
        self.assertEqual(self.figures_of("many.json"), expected)

    def test_reports_are_shared(self):
        for ranks in (1, 2, 3, 4):
            for method, name in (("mc", "a.ply"), ("mt", "a.glb")):
                with self.subTest(ranks=ranks, method=method, name=name):
                    self.assert_same_report(ranks, name, self.SHARED, "demo:gyroid?size=100", "--iso", "0.1", "--method", method)
        self.assert_same_report(4, "b.ply", self.SHARED, "demo:gyroid?size=17", "--iso", "0")
        self.assert_same_report(3, "c.ply", self.ALONE + "an option", "demo:gyroid?size=40", "--iso", "0", "--cap")
        self.assert_same_report(3, "d.glb", self.ALONE + "the mesh is small", "demo:gyroid?size=20", "--iso", "0")

    def test_many_components_of_samples_in_a_file(self):
        def value(x, y, z):
            return (x * 7919 + y * 104729 + z * 1299709 + x * y * z * 31) % 97 - 70.5

        self.write_raw("a.raw", (30, 21, 44), value)
        arguments = ["a.raw", "--dims", "30,21,44", "--dtype", "f32", "--iso", "0"]
        for ranks in (2, 3, 4):
            self.assert_same_report(ranks, "a.ply", self.SHARED, *arguments)
        self.assert_same_report(2, "b.ply", self.SHARED, *arguments, "--memory-limit", "64M", "--require", "manifold")

    def test_requirements_are_shared(self):
        arguments = ["demo:gyroid?size=60", "--iso", "0.1", "-o", "a.ply"]
        for requirement in ("closed", "oriented,no-unused-vertices"):
            one = self.run_program(*arguments, "--require", requirement)
            (self.folder / "a.ply").unlink(missing_ok=True)
            many = self.run_ranks(3, *arguments, "--require", requirement)
            self.assertEqual(many.code, one.code, many.err)
            self.assertEqual(many.err.count("isoextract: error:"), 0 if one.code == 0 else 1, many.err)
            self.assertEqual(self.files(), ["a.ply"] if one.code == 0 else [])

    def test_more_ranks_than_slabs(self):
        self.assert_same(4, "a.ply", self.SHARED, "demo:gyroid?size=12", "--iso", "0")
        self.assert_same(4, "b.ply", self.SHARED, "demo:gyroid?size=17", "--iso", "0", "--cap", "--normals", "none")

    def test_what_cannot_be_shared_is_done_by_rank_0(self):
        for ranks in (2, 4):
            for name, why, *arguments in (
                    ("cap.ply", "an option", "demo:gyroid?size=40", "--iso", "0", "--cap", "--normals", "smooth"),
                    ("nets.ply", "only mc and mt", "demo:gyroid?size=40", "--iso", "0", "--method", "surface-nets"),
                    ("voxels.ply", "only mc and mt", "demo:gyroid?size=40", "--iso", "0", "--method", "voxels"),
                    ("simple.ply", "an option", "demo:gyroid?size=40", "--iso", "0", "--simplify", "0.1"),
                    ("small.glb", "the mesh is small", "demo:gyroid?size=20", "--iso", "0"),
                    ("text.obj", "an option", "demo:gyroid?size=20", "--iso", "0")):
                with self.subTest(ranks=ranks, name=name):
                    self.assert_same(ranks, name, self.ALONE + why, *arguments)

    def test_sparse_samples(self):
        vdb = SOURCE / "samples/metaballs.vdb"
        if not vdb.exists():
            self.skipTest(f"no {vdb}")
        self.assert_same(2, "a.ply", self.ALONE + "the samples are sparse", vdb, "--iso", "0.5")

    def test_nan_samples(self):
        def value(x, y, z):
            return float("nan") if (x, y, z) == (3, 4, 37) else x + y + z - 50.0

        self.write_raw("a.raw", (20, 20, 40), value)
        arguments = ["a.raw", "--dims", "20,20,40", "--dtype", "f32", "--iso", "0"]
        one = self.run_program(*arguments, "-o", "a.ply", "--nan", "error")
        many = self.run_ranks(3, *arguments, "-o", "a.ply", "--nan", "error")
        self.assertEqual(many.code, one.code)
        self.assertTrue(many.err.startswith(one.err), many.err)  # mpirun adds that a process failed
        self.assert_same(3, "b.ply", self.SHARED, *arguments, "--nan", "outside", "--normals", "none")
        self.assert_same(3, "c.ply", self.ALONE, *arguments, "--nan", "outside", "--normals", "smooth")
        self.assert_same(3, "d.ply", self.ALONE, *arguments, "--nan", "hole")

    def test_an_output_that_cannot_be_written(self):
        run = self.run_ranks(3, "demo:gyroid?size=40", "--iso", "0", "-o", "absent/a.ply")
        self.assertEqual(run.code, 4, run.err)
        self.assertEqual(run.err.count("error:"), 1, run.err)

    def test_a_killed_rank_leaves_no_file(self):
        with subprocess.Popen(command_of(3, "demo:gyroid?size=200", "--iso", "0", "-o", "a.ply", "--threads", "1"), cwd=self.folder,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=ENVIRONMENT) as run:
            while run.poll() is None and not self.files():
                time.sleep(0.0005)
            for process in processes_of(1, run.pid):
                os.kill(process, signal.SIGKILL)
            _, err = run.communicate()
        self.assertNotEqual(run.returncode, 0, err)
        self.assertIn(b"isoextract: error: a signal ended the run", err)
        self.assertEqual(self.files(), [])

    def test_ranks_that_wait_take_no_processor_time(self):
        def seconds(run):
            before = os.times()
            run()
            after = os.times()
            return after.children_user + after.children_system - before.children_user - before.children_system

        arguments = ["demo:gyroid?size=100", "--iso", "0", "--error", "-o", "a.ply", "--threads", "1"]
        idle = seconds(lambda: self.run_ranks(3, "--version"))
        alone = seconds(lambda: self.convert(*arguments))
        many = seconds(lambda: self.run_ranks(3, *arguments))
        self.assertLess(many, 1.5 * alone + 2 * idle)


class RanksTest(MpiTest):
    def test_stdout_of_ranks_is_refused(self):
        run = self.run_ranks(2, "demo:sphere?size=8", "--iso", "0", "-o", "-", "--format", "ply")
        self.assertEqual(run.code, 1, run.err)
        self.assertIn("stdout of several ranks passes through mpirun or srun, which may change bytes", run.err)
        self.assertNotIn("end_header", run.text)

    def test_errors_are_told_once(self):
        run = self.run_ranks(3, "none_{:04}.raw", "--iso", "0", "-o", "f_{:04}.ply")
        self.assertEqual(run.code, 2, run.err)
        self.assertEqual(run.err.count("isoextract: error:"), 1, run.err)
        run = self.run_ranks(2, "absent.vdb", "--iso", "0", "-o", "a.ply")
        self.assertEqual(run.code, 2, run.err)
        self.assertEqual(run.err.count("isoextract: error:"), 1, run.err)

    def test_other_commands_run_once(self):
        run = self.assert_done(self.run_ranks(3, "info", "demo:sphere?size=16"))
        self.assertIn("note[shard]: 3 ranks on 1 machine: rank 0 does all work of this command", run.err)
        self.assertEqual(run.text.count("demo:sphere"), self.run_program("info", "demo:sphere?size=16").text.count("demo:sphere"))
        for hides in (("-q",), ("--no-note", "shard")):
            self.assertNotIn("rank 0 does all work", self.assert_done(self.run_ranks(3, "info", "demo:sphere?size=16", *hides)).err)
        run = self.assert_done(self.run_ranks(3, "--version"))
        self.assertEqual(run.text.count("isoextract"), self.run_program("--version").text.count("isoextract"))


class LauncherTest(ProgramTest):
    def test_a_missing_plugin_names_its_package(self):
        folder = self.folder / "alone"
        folder.mkdir()
        program = folder / "isoextract"
        shutil.copy(PROGRAM, program)
        environment = dict(os.environ, OMPI_COMM_WORLD_SIZE="3", OMPI_COMM_WORLD_RANK="0")
        environment.pop("ISOEXTRACT_PLUGINS", None)
        run = Run(run_limited([program, "demo:sphere", "--iso", "0", "-o", "a.ply"], cwd=folder, env=environment,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE))
        self.assert_fails(3, run, "OMPI_COMM_WORLD_SIZE=3", "isoextract-ranks-mpi.so", "libopenmpi-dev")
        environment["OMPI_COMM_WORLD_RANK"] = "1"
        run = Run(run_limited([program, "demo:sphere", "--iso", "0", "-o", "a.ply"], cwd=folder, env=environment,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE))
        self.assertEqual((run.code, run.err), (3, ""))

    def test_one_process_of_a_launcher_is_alone(self):
        environment = dict(os.environ, OMPI_COMM_WORLD_SIZE="1", OMPI_COMM_WORLD_RANK="0", ISOEXTRACT_PLUGINS="/nowhere")
        self.convert("demo:sphere?size=16", "--iso", "0", "-o", "a.ply", env=environment)

    def test_the_program_does_not_link_mpi(self):
        linked = subprocess.run(["ldd", PROGRAM], capture_output=True, check=False).stdout
        self.assertNotIn(b"libmpi", linked)


if __name__ == "__main__":
    main()
