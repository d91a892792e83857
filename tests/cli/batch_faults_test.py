"""Sequences where something goes wrong: disks that fill up, inputs and folders that change, signals, readers that leave."""

import hashlib
import json
import os
import resource
import select
import shutil
import signal
import subprocess
import time

from support import PROGRAM, ProgramTest, Run, forbid_unnamed_files, main, needs_program

SIZE = 64
LAST = 30
# Meshes that grow with the frame, so that some fit where others do not.
GROWING = ("demo:sphere?size={}", "--frames", "8-48x8", "--iso", "0", "--mkdir")
# Runs a command as a user whom the permissions of files bind.
ORDINARY = ["setpriv", "--bounding-set=-dac_override,-dac_read_search"] if os.geteuid() == 0 else []


def waves(shift):
    """SIZE³ bytes of waves: a surface of many triangles, another one for each shift."""
    rows = [bytes((7 * x + start) % 64 for x in range(SIZE)) for start in range(64)]
    return b"".join(rows[(11 * y + 13 * z + shift) % 64] for z in range(SIZE) for y in range(SIZE))


def short(data):
    """Size and hash, which say where files differ as well as their bytes would, and in less text."""
    return len(data), hashlib.sha256(data).hexdigest()


def with_files_up_to(size):
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


class BatchFaultsTest(ProgramTest):
    arguments = ("in_{:02}.raw", "--dims", f"{SIZE},{SIZE},{SIZE}", "--iso", "1.5", "--mkdir", "--jobs", "1")

    def write_frame(self, number):
        (self.folder / f"in_{number:02}.raw").write_bytes(waves(5 * number))

    def write_frames(self, last=LAST):
        for number in range(1, last + 1):
            self.write_frame(number)

    def content(self, folder="out"):
        """Of all files, hidden ones too, but the manifests."""
        return {path.name: short(path.read_bytes()) for path in (self.folder / folder).iterdir() if path.suffix != ".manifest"}

    def undisturbed(self, *arguments, name="{:02}.ply"):
        run = self.run_program(*(arguments or self.arguments), "-o", f"whole/{name}")
        self.assertEqual(run.code, 0, run.err)
        return self.content("whole")

    def recorded(self):
        """Frames of the manifest; a line that is not whole ends it, as it does for the program."""
        frames = []
        for line in (self.folder / "out/isoextract.manifest").read_text().splitlines(keepends=True)[1:]:
            if not line.endswith("\n"):
                break
            frames.append(json.loads(line.partition(" ")[2])["frame"])
        return frames

    def resume(self, whole, *arguments):
        run = self.run_program(*(arguments or self.arguments), "-o", "out/{:02}.ply", "--resume")
        self.assertEqual(run.code, 0, run.err)
        self.assertEqual(self.content(), whole)
        return run

    def stopped(self, *arguments, output="out/{:02}.ply", **options):
        """A run on the way that has done some frames and not all, held by SIGSTOP."""
        arguments = arguments or self.arguments
        for _ in range(20):
            shutil.rmtree(self.folder / "out", ignore_errors=True)
            process = subprocess.Popen([PROGRAM, *arguments, "-o", output], cwd=self.folder, stdin=subprocess.DEVNULL,
                                       stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, **options)
            while process.poll() is None and not list((self.folder / "out").glob("[0-9]*.ply")):
                time.sleep(0.001)
            process.send_signal(signal.SIGSTOP)
            if process.poll() is None and not (self.folder / f"out/{LAST - 5:02}.ply").exists():
                self.addCleanup(process.kill)
                return process
            process.kill()
            process.communicate()
        self.fail("20 runs were over before they could be stopped")

    def went_on(self, process):
        process.send_signal(signal.SIGCONT)
        _, err = process.communicate(timeout=60)
        return process.returncode, err.decode()

    def test_frames_that_are_too_large_leave_nothing(self):
        whole = self.undisturbed(*GROWING)
        limit = sorted(size for size, _ in whole.values())[3]  # three are smaller, one is as large
        run = self.run_program(*GROWING, "-o", "out/{:02}.ply", preexec_fn=with_files_up_to(limit))
        self.assertEqual(run.code, 5, run.err)
        fit = {name: mesh for name, mesh in whole.items() if mesh[0] <= limit}
        self.assertEqual((len(fit), len(whole)), (4, 6))
        self.assertEqual(self.content(), fit)
        self.assertEqual(sorted(self.recorded()), [8, 16, 24, 32])
        self.assertRegex(run.err, r"isoextract: error: 2 frames: .*; first: frame \d+; all: ")
        self.assertIn("2 of 6 frames done, 4 kept", self.resume(whole, *GROWING).err)

    def test_a_manifest_that_cannot_grow_ends_the_run(self):
        arguments = ("demo:sphere?size=4&time=0.{:02}", "--frames", "10-40", "--iso", "0", "--mkdir", "--jobs", "2")
        whole = self.undisturbed(*arguments)
        limit = 3000
        self.assertLess(max(size for size, _ in whole.values()), limit)
        run = self.run_program(*arguments, "-o", "out/{:02}.ply", preexec_fn=with_files_up_to(limit))
        self.assertEqual(run.code, 4, run.err)
        self.assertIn("out/isoextract.manifest: cannot write", run.err)
        there = self.content()
        self.assertLess(len(there), len(whole))
        self.assertEqual(there, {name: whole[name] for name in there})
        recorded = self.recorded()
        self.assertTrue(0 < len(recorded) <= len(there), recorded)
        self.assertIn(f", {len(recorded)} kept", self.resume(whole, *arguments).err)

    def test_a_disk_that_is_full(self):
        # In a namespace of its own, which takes the mount with it.
        alone = ["unshare", "-m"] if os.geteuid() == 0 else ["unshare", "-rm"]
        mount = 'mount -t tmpfs -o size="$1" none out'
        (self.folder / "out").mkdir()
        tried = subprocess.run([*alone, "bash", "-c", mount, "-", "64k"], cwd=self.folder, capture_output=True, text=True,
                               check=False)
        if tried.returncode != 0:
            self.skipTest(f"no small disk can be made here: {tried.stderr.strip()}")
        whole = self.undisturbed(*GROWING)
        size = f"{sum(size for size, _ in whole.values()) * 2 // 3 // 1024}k"
        script = f'{mount} && shift && "$@"; code=$?; cp -a out/. kept; exit $code'
        (self.folder / "kept").mkdir()
        for jobs in ("1", "3"):
            run = Run(subprocess.run([*alone, "bash", "-c", script, "-", size, PROGRAM, *GROWING, "-o", "out/{:02}.ply",
                                      "--jobs", jobs], cwd=self.folder, capture_output=True, timeout=60, check=False))
            self.assertIn(run.code, (4, 5), run.err)
            self.assertIn("No space left", run.err.replace("no space", "No space"))
            shutil.rmtree(self.folder / "out")
            (self.folder / "kept").rename(self.folder / "out")
            there = self.content()
            self.assertTrue(0 < len(there) < len(whole), there.keys())
            self.assertEqual(there, {name: whole[name] for name in there})
            self.assertTrue(set(self.recorded()) <= {int(name[:2]) for name in there})
            self.resume(whole, *GROWING)
            shutil.rmtree(self.folder / "out")
            (self.folder / "out").mkdir()
            (self.folder / "kept").mkdir()

    def test_an_input_that_is_gone_when_its_turn_comes(self):
        self.write_frames()
        whole = self.undisturbed()
        process = self.stopped()
        (self.folder / f"in_{LAST}.raw").unlink()
        code, err = self.went_on(process)
        self.assertEqual(code, 5, err)
        self.assertIn(f"frame {LAST}: in_{LAST}.raw: cannot read the file", err)
        self.assertIn(f"1 of {LAST} frames failed", err)
        self.assertEqual(self.content(), {name: mesh for name, mesh in whole.items() if name != f"{LAST}.ply"})
        self.write_frame(LAST)
        self.assertIn(f"1 of {LAST} frames done", self.resume(whole).err)

    def test_an_input_that_is_cut_off_while_it_is_read(self):
        self.write_frames(3)
        # An option that needs the whole mesh: it is complete before the cut.
        arguments = (*self.arguments, "--iso", "40.5", "--drop-components", "1")
        whole = self.undisturbed(*arguments, name="{frame:02}_{iso}.ply")
        # The program waits with the rest of its first mesh of frame 2 until the pipe is read.
        (self.folder / "out").mkdir()
        pipe = self.folder / "out/02_1.5.ply"
        os.mkfifo(pipe)
        with open(os.open(pipe, os.O_RDONLY | os.O_NONBLOCK), "rb") as mesh:
            process = subprocess.Popen([PROGRAM, *arguments, "-o", "out/{frame:02}_{iso}.ply"], cwd=self.folder,
                                       stdin=subprocess.DEVNULL, stderr=subprocess.PIPE)
            self.addCleanup(process.kill)
            self.assertTrue(select.select([mesh], [], [], 60)[0], "nothing was written")
            os.set_blocking(mesh.fileno(), True)
            os.truncate(self.folder / "in_02.raw", 4096)
            self.assertEqual(short(mesh.read()), whole["02_1.5.ply"])
        _, err = process.communicate(timeout=60)
        pipe.unlink()
        self.assertEqual(process.returncode, 5, err)
        self.assertIn(b"frame 2: in_02.raw: the file became shorter", err)
        self.assertEqual(self.content(), {name: mesh for name, mesh in whole.items() if not name.startswith("02")})
        self.assertEqual(self.recorded(), [1, 3])
        self.write_frame(2)
        run = self.run_program(*arguments, "-o", "out/{frame:02}_{iso}.ply", "--resume")
        self.assertIn("1 of 3 frames done, 2 kept", run.err)
        self.assertEqual(self.content(), whole)

    def test_an_input_that_is_another_one_is_done_again(self):
        self.write_frames(4)
        self.run_program(*self.arguments, "-o", "out/{:02}.ply")
        path = self.folder / "in_02.raw"
        before = path.stat()
        path.write_bytes(waves(77))  # as long as it was, and as old
        os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
        (self.folder / "in_04.raw").write_bytes((self.folder / "in_01.raw").read_bytes())
        whole = self.undisturbed()
        self.assertNotEqual(self.content(), whole)
        self.assertIn("2 of 4 frames done, 2 kept", self.resume(whole).err)

    @needs_program("setpriv")
    def test_an_input_that_may_not_be_read(self):
        self.write_frames(3)
        whole = self.undisturbed()
        (self.folder / "in_02.raw").chmod(0)
        run = Run(subprocess.run([*ORDINARY, PROGRAM, *self.arguments, "-o", "out/{:02}.ply"], cwd=self.folder,
                                 capture_output=True, timeout=60, check=False))
        self.assertEqual(run.code, 5, run.err)
        self.assertIn("frame 2: in_02.raw: cannot read the file: Permission denied", run.err)
        self.assertEqual(sorted(self.content()), ["01.ply", "03.ply"])
        (self.folder / "in_02.raw").chmod(0o644)
        self.resume(whole)

    def test_pipes_and_links_that_lead_nowhere_are_no_frames_to_wait_for(self):
        self.write_frames(4)
        whole = self.undisturbed()
        for number in (2, 3):
            (self.folder / f"in_{number:02}.raw").unlink()
        os.mkfifo(self.folder / "in_02.raw")
        (self.folder / "in_03.raw").symlink_to("nowhere")
        run = self.run_program(*self.arguments, "-o", "out/{:02}.ply")
        self.assertEqual(run.code, 5, run.err)
        self.assertIn("frame 2: in_02.raw: expected a regular file, found a pipe", run.err)
        self.assertIn("frame 3: in_03.raw: cannot read the file", run.err)
        self.assertEqual(self.content(), {name: whole[name] for name in ("01.ply", "04.ply")})

    @needs_program("setpriv")
    def test_a_folder_that_may_not_be_written(self):
        self.write_frames(2)
        out = self.folder / "out"
        out.mkdir(0o555)
        command = [*ORDINARY, PROGRAM, *self.arguments, "-o", "out/{:02}.ply"]
        run = Run(subprocess.run(command, cwd=self.folder, capture_output=True, timeout=60, check=False))
        self.assert_fails(4, run, "out/isoextract.manifest", "Permission denied")
        self.assertEqual(self.content(), {})
        out.rmdir()
        out.write_text("a file")
        run = self.run_program(*self.arguments, "-o", "out/{:02}.ply")
        self.assert_fails(4, run, "out: ")
        self.assertEqual(out.read_text(), "a file")

    def test_a_folder_that_is_taken_away(self):
        self.write_frames()
        whole = self.undisturbed()
        process = self.stopped()
        shutil.rmtree(self.folder / "out")
        code, err = self.went_on(process)
        self.assertEqual(code, 5, err)
        self.assertRegex(err, r"frame \d+: out/\d+\.ply: there is no folder out\n")
        self.assertRegex(err, rf"\d+ frames: .*there is no folder out; first: frame \d+; all: \d+-{LAST}\n")
        self.assertFalse((self.folder / "out").exists())
        self.assertIn(f"{LAST} of {LAST} frames done", self.resume(whole).err)

    def test_a_second_run_waits_its_turn(self):
        self.write_frames()
        whole = self.undisturbed()
        process = self.stopped()
        before = self.content()
        for shard in ((), ("--shard", "1/2")):
            run = self.run_program(*self.arguments, "-o", "out/{:02}.ply", *shard)
            self.assert_fails(4, run, "out: another run writes into this folder")
        self.assertEqual(self.content(), before)
        self.assertEqual(self.went_on(process)[0], 0)
        self.assertEqual(self.content(), whole)
        process = self.stopped()
        process.kill()
        process.communicate()
        self.resume(whole)

    def test_shards_share_a_folder_and_no_part_of_it(self):
        self.write_frames()
        whole = self.undisturbed()
        process = self.stopped(*self.arguments, "--shard", "1/2")
        for shard in ((), ("--shard", "1/2")):
            run = self.run_program(*self.arguments, "-o", "out/{:02}.ply", *shard)
            self.assert_fails(4, run, "out: another run writes into this folder")
        self.assertEqual(self.run_program(*self.arguments, "-o", "out/{:02}.ply", "--shard", "2/2").code, 0)
        self.assertEqual(self.went_on(process)[0], 0)
        self.assertEqual(self.run_program("merge", "out").code, 0)
        self.assertEqual(self.content(), whole)

    def test_a_signal_ends_a_run_and_leaves_nothing_half_written(self):
        self.write_frames()
        whole = self.undisturbed()
        for number in (signal.SIGINT, signal.SIGTERM):
            for prepare in (None, forbid_unnamed_files):
                process = self.stopped(preexec_fn=prepare)
                process.send_signal(number)
                code, err = self.went_on(process)
                self.assertEqual(code, -number, err)
                there = self.content()
                self.assertLess(len(there), LAST)
                self.assertEqual(there, {name: whole[name] for name in there})
                self.resume(whole)

    def test_a_reader_of_the_progress_that_leaves(self):
        self.write_frames(6)
        whole = self.undisturbed()
        begin = b'{"schema":"isoextract/progress/1","event":"begin","frames":6}\n'
        for options, first in (("--progress json", begin), ("-v", b"frame 1: in_01.raw: ")):
            shutil.rmtree(self.folder / "out", ignore_errors=True)
            command = f'"$@" {options} 2>&1 | head -n 1; exit ${{PIPESTATUS[0]}}'
            done = subprocess.run(["bash", "-c", command, "-", PROGRAM, *self.arguments, "-o", "out/{:02}.ply"],
                                  cwd=self.folder, capture_output=True, timeout=60, check=False)
            self.assertEqual(done.returncode, 0)
            self.assertTrue(done.stdout.startswith(first), done.stdout)
            self.assertEqual(done.stdout.count(b"\n"), 1)
            self.assertEqual(self.content(), whole)

    def test_closed_streams(self):
        self.write_frames(3)
        whole = self.undisturbed()
        for redirection in ("2>&-", ">&-", ">&- 2>&- <&-"):
            for options in ("--progress json", ""):
                shutil.rmtree(self.folder / "out", ignore_errors=True)
                done = subprocess.run(["bash", "-c", f'"$@" {options} {redirection}', "-", PROGRAM, *self.arguments, "-o",
                                       "out/{:02}.ply"], cwd=self.folder, capture_output=True, timeout=60, check=False)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(self.content(), whole)

    def test_a_reader_of_the_plan_that_leaves(self):
        # More text than a pipe holds.
        command = '"$@" --dry-run | head -n 1; exit ${PIPESTATUS[0]}'
        done = subprocess.run(["bash", "-c", command, "-", PROGRAM, "demo:sphere?size=8&time=0.{}", "--frames", "1000-4000",
                               "--iso", "0", "-o", "{}.ply"], cwd=self.folder, capture_output=True, timeout=60,
                              check=False)
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn(b"frame 1000: ", done.stdout)
        self.assertIn(b"the reader closed the pipe", done.stderr)
        self.assertEqual(self.files(), [])


if __name__ == "__main__":
    main()
