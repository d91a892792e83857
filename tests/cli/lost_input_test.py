"""An input that is cut off while its samples are in use: a message and an exit code, and no output that looks whole."""

import json
import os
import select
import signal
import subprocess
import unittest

from support import PROGRAM, ProgramTest, main, read_ply

SIZE = 96


class LostInputTest(ProgramTest):
    def start(self, *arguments):
        return subprocess.Popen([PROGRAM, *arguments], cwd=self.folder, stdin=subprocess.DEVNULL,
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)

    def open_pipe(self, name):
        os.mkfifo(self.folder / name)
        return open(os.open(self.folder / name, os.O_RDONLY | os.O_NONBLOCK), "rb")

    def wait_for_bytes(self, pipe):
        self.assertTrue(select.select([pipe], [], [], 60)[0], "nothing was written")
        os.set_blocking(pipe.fileno(), True)

    def cut_off(self, *options):
        """Cuts off the input while the first of two surfaces goes to a pipe. Returns what the pipe got, and the report."""
        # Waves, so that the first mesh is larger than what a pipe holds: the program waits with the rest of it until
        # the file is cut off, and looks for the second surface afterwards.
        self.write_raw("a.raw", (SIZE, SIZE, SIZE), lambda x, y, z: (x * 7 + y * 11 + z * 13) % 64)
        with self.open_pipe("a1.5.ply") as pipe:
            with self.start("a.raw", "--dims", f"{SIZE},{SIZE},{SIZE}", "--dtype", "f32", "--iso", "1.5",
                            "--iso", "40.5", "-o", "a{iso}.ply", "--report", "a.json", *options) as process:
                self.wait_for_bytes(pipe)
                os.truncate(self.folder / "a.raw", 4096)
                written = pipe.read()
                _, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 2, err)
        last = err.decode().splitlines()[-2:]
        self.assertTrue(last[0].startswith("isoextract: error: a.raw: the file became shorter"), err)
        self.assertTrue(last[1].startswith("  hint: "), err)
        self.assertEqual(self.files(), ["a.json", "a.raw", "a1.5.ply"])
        report = json.loads((self.folder / "a.json").read_text())
        self.assertEqual((report["status"], report["error"]["exit_code"]), ("failed", 2))
        self.assertIn(report["error"]["message"], last[0])
        return written, report

    def test_a_file_cut_off_between_two_surfaces(self):
        written, report = self.cut_off("--drop-components", "1")  # needs the whole mesh before its first byte
        self.assertGreater(len(read_ply(written).triangles), 100000)
        self.assertEqual([entry["path"] for entry in report["files"]], ["a1.5.ply"])

    def test_a_file_cut_off_while_a_mesh_is_made_and_written(self):
        _, report = self.cut_off()
        self.assertEqual(report["files"], [])

    def test_another_bus_error_ends_the_program_as_always(self):
        with self.open_pipe("a.ply") as pipe:
            with self.start("demo:gyroid?size=96", "--iso", "0", "-o", "a.ply") as process:
                self.wait_for_bytes(pipe)
                process.send_signal(signal.SIGBUS)
                _, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, -signal.SIGBUS)
        self.assertNotIn(b"the file", err)


if __name__ == "__main__":
    main()
