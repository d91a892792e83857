"""stdout carries data only, stderr the rest: pipes, quietness, terminals."""

import os
import pty
import re
import select
import signal
import subprocess
import time

from support import PROGRAM, SPHERE, ProgramTest, main, read_glb, read_ply


def output_on_terminal(arguments, folder, stdout=subprocess.DEVNULL, sleep=0.0, **variables):
    """What the program writes to stderr where that is a terminal, and its exit code. Early in its work it is made to
    sleep, so that the work takes long on fast machines too."""
    ours, theirs = pty.openpty()
    environment = {**os.environ, "TERM": "xterm", **variables}
    options = {"stdout": theirs if stdout == "terminal" else stdout}
    with subprocess.Popen([PROGRAM, *arguments], cwd=folder, stdin=subprocess.DEVNULL, stderr=theirs, env=environment,
                          **options) as process:
        os.close(theirs)
        if sleep > 0:
            time.sleep(0.2)
            process.send_signal(signal.SIGSTOP)
            time.sleep(sleep)
            process.send_signal(signal.SIGCONT)
        text = b""
        while select.select([ours], [], [], 60)[0]:
            try:
                part = os.read(ours, 65536)
            except OSError:  # the other side is closed
                break
            if not part:
                break
            text += part
        code = process.wait(timeout=60)
    os.close(ours)
    return text.decode(errors="replace"), code


class StreamsTest(ProgramTest):
    def test_stdout_has_the_bytes_of_the_file(self):
        for form in ("ply", "glb", "obj", "stl"):
            self.convert(SPHERE, "--iso", "0", "-o", f"file.{form}")
            run = self.convert(SPHERE, "--iso", "0", "-o", "-", "--format", form)
            self.assertEqual(run.out, (self.folder / f"file.{form}").read_bytes())
            self.assertIn("-> standard output: ", run.err)
        read_glb(self.convert(SPHERE, "--iso", "0", "-o", "-", "--format", "glb").out)

    def test_a_pipe_can_be_read_while_it_is_written(self):
        run = subprocess.run(["bash", "-c", '"$0" demo:gyroid?size=64 --iso 0 -q -o - --format ply | cat', PROGRAM],
                             cwd=self.folder, capture_output=True, check=True)
        self.assertEqual(run.stderr, b"")
        self.assertGreater(len(read_ply(run.stdout).triangles), 1000)

    def test_stdout_gets_nothing_where_a_later_surface_fails(self):
        run = self.run_program("demo:gyroid?size=64", "--iso", "0", "--iso", "9", "-o", "-", "--format", "obj")
        self.assert_fails(2, run, "no surface at iso 9")
        self.assertEqual(run.out, b"")

    def test_a_reader_that_stops_early_is_an_error_and_no_crash(self):
        command = '"$0" demo:gyroid?size=96 --iso 0 -q -o - --format obj | head -n 1; exit ${PIPESTATUS[0]}'
        run = subprocess.run(["bash", "-c", command, PROGRAM], cwd=self.folder, capture_output=True, check=False)
        self.assertEqual(run.returncode, 4, run.stderr)
        self.assertEqual(run.stdout.count(b"\n"), 1)
        self.assertTrue(run.stderr.startswith(b"isoextract: error: "), run.stderr)

    def test_reports_to_a_full_disk_are_errors(self):
        for arguments in (("info", SPHERE), ("help",), ("--version",), ("generate", "man")):
            with open("/dev/full", "wb") as full:
                run = self.run_program(*arguments, stdout=full)
            self.assert_fails(4, run, "no space left")

    def test_closed_streams_do_not_mix_with_files(self):
        self.convert(SPHERE, "--iso", "0", "-o", "open.ply")
        for redirection in ("2>&-", ">&-", "<&-", ">&- 2>&- <&-"):
            command = f'"$0" demo:sphere?size=24 --iso 0 -v -o closed.ply {redirection}'
            run = subprocess.run(["bash", "-c", command, PROGRAM], cwd=self.folder, capture_output=True, check=False)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertEqual((self.folder / "closed.ply").read_bytes(), (self.folder / "open.ply").read_bytes())
        for arguments in ("info demo:sphere?size=24", "demo:sphere?size=24 --iso 0 -o - --format ply"):
            run = subprocess.run(["bash", "-c", f'"$0" {arguments} >&-', PROGRAM], cwd=self.folder,
                                 capture_output=True, check=False)
            self.assertEqual(run.returncode, 4, run.stderr)

    def test_a_conversion_tells_one_line_a_file(self):
        run = self.convert(SPHERE, "--iso", "0", "-o", "out.glb")
        self.assertEqual(run.out, b"")
        self.assertRegex(run.err, r"^demo:sphere\?size=24 iso 0 -> out\.glb: \d+ triangles, \d+ vertices, [\d.]+ KiB; closed; "
                                  r"world coordinates, turned from z up to y up; \d+\.\d\d s\n$")

    def test_the_line_of_a_file_says_whether_the_mesh_is_closed(self):
        gyroid = "demo:gyroid?size=24"
        half = ("--roi", "-1,-1,-1,0,1,1")
        for arguments, told in (((SPHERE, "--iso", "0"), "; closed; "),
                                ((gyroid, "--iso", "0"), "; open at the data boundary (--cap closes it); "),
                                ((gyroid, "--iso", "0", "--cap"), "; closed; "),
                                ((SPHERE, "--iso", "0", *half), "; open at the boundary of --roi (--cap closes it); "),
                                ((SPHERE, "--iso", "0", *half, "--cap"), "; closed; "),
                                ((SPHERE, "--iso", "0", "--iso", "-0.9", "--iso", "0.2"),
                                 "; open at the data boundary at iso -0.9 (--cap closes it); "),
                                ((SPHERE, "--iso", "9", "--empty", "write"), "; empty; ")):
            self.assertIn(told, self.convert(*arguments, "-o", "out.glb").err)
        self.write_raw("nan.raw", (6, 6, 6), lambda x, y, z: float("nan") if (x, y, z) == (3, 2, 2) else float(x))
        raw = ("nan.raw", "--dims", "6,6,6", "--dtype", "f32", "--iso", "2.5", "--nan", "hole", "-o", "out.ply")
        self.assertIn("; open at the data boundary (--cap closes it); without 8 cells around NaN samples; ", self.convert(*raw).err)
        self.assertIn("; open; without 8 cells around NaN samples", self.convert(*raw, "--cap").err)

    def test_explain_tells_of_caps_where_there_is_something_to_cap(self):
        for arguments, told in (((SPHERE, "--iso", "0"), None), ((SPHERE, "--iso", "0", "--cap"), None),
                                (("demo:gyroid?size=24", "--iso", "0"), "caps where the surface reaches the data boundary"),
                                ((SPHERE, "--iso", "0", "--inside", "below"), "caps at the data boundary, all of which is inside")):
            err = self.convert(*arguments, "--explain", "-o", "out.ply").err
            self.assertEqual("; --cap makes them" in err, told is not None, err)
            self.assertIn(told or "", err)

    def test_quiet_is_silent(self):
        for arguments in ((SPHERE, "--iso", "0"), (SPHERE, "--iso", "9", "--empty", "skip"),
                          (SPHERE, "--iso", "0", "--up", "y", "-o", "out.ply")):
            self.assertEqual(self.convert(*arguments, "-q").err, "")

    def test_every_command_can_be_quiet(self):
        self.convert(SPHERE, "--iso", "0", "-q", "-o", "out.ply")
        for arguments in (("info", SPHERE), ("verify", SPHERE, "--iso", "0", "out.ply"), ("compare", "out.ply", "out.ply"),
                          ("bench", "demo:sphere", "--sizes", "8,16", "--repeats", "1", "--json", "bench.json"),
                          ("stability", "--list"), ("devices",), ("help", "exit-codes"), ("generate", "man")):
            run = self.run_program(*arguments, "-q")
            self.assertEqual((run.code, run.err), (0, ""), arguments)
            self.assertNotEqual(run.out, b"")

    def test_quiet_still_tells_errors(self):
        self.assert_fails(2, self.run_program(SPHERE, "--iso", "9", "-q"), "no surface")

    def test_verbose_tells_stages_and_memory(self):
        err = self.convert(SPHERE, "--iso", "0", "-v").err
        for part in ("read in ", "extracted in ", "written in ", "peak memory "):
            self.assertIn(part, err)

    def test_verbose_tells_many_labels_in_a_line_for_each_stage(self):
        self.write_raw("map.raw", (12, 12, 12), lambda x, y, z: 1 + x // 4 + 3 * (y // 4) + 9 * (z // 4), "B")
        map_of_27 = ("map.raw", "--dims", "12,12,12", "--smooth", "3", "-v", "-o", "out.glb", "--labels")
        err = self.convert(*map_of_27, "all").err
        (line,) = [line for line in err.splitlines() if "extracted for " in line]
        found = re.fullmatch(r"map\.raw: extracted for 27 labels in ([\d.]+) s \([\d.]+ s of processor time\): "
                             r"([\d.]+) s to compare samples, ([\d.]+) s to make the meshes", line)
        self.assertIsNotNone(found, line)
        whole, compare, make = (float(seconds) for seconds in found.groups())
        self.assertAlmostEqual(whole, compare + make, delta=0.01)
        (line,) = [line for line in err.splitlines() if "smoothed for " in line]
        self.assertRegex(line, r"^map\.raw: smoothed for 27 labels in [\d.]+ s, the sum over the labels$")
        err = self.convert(*map_of_27, "5").err
        self.assertRegex(err, r"(?m)^map\.raw label 5: extracted in .+ s to compare samples, .+ s to count, ")
        self.assertRegex(err, r"(?m)^map\.raw label 5: smoothed in ")

    def test_verbose_counts_labels_and_not_their_bodies(self):
        self.write_raw("map.raw", (12, 12, 12), lambda x, y, z: 0 if x % 4 == 3 or y % 4 == 3 else 1 + y // 4, "B")
        bodies = ("map.raw", "--dims", "12,12,12", "--split-components", "--normals", "area", "-v", "-o", "out.glb", "--labels")
        err = self.convert(*bodies, "1").err
        self.assertEqual(err.count("map.raw label 1: normals computed in "), 3, err)
        self.assertRegex(self.convert(*bodies, "all").err, r"(?m)^map\.raw: normals computed for 3 labels in ")

    def test_equal_lines_of_many_labels_are_one(self):
        self.write_raw("map.raw", (12, 12, 12), lambda x, y, z: 1 + x // 4 + 3 * (y // 4) + 9 * (z // 4), "B")
        map_of_27 = ("map.raw", "--dims", "12,12,12", "--require", "printable", "-o", "out.glb", "--labels")
        self.assertRegex(self.convert(*map_of_27, "all").err, r"(?m)^  no triangles intersect at 27 labels; [\d.]+ s$")
        err = self.convert(*map_of_27, "1,11").err
        self.assertEqual(err.count("no triangles intersect"), 1, err)
        self.assertIn("at 2 labels", err)
        self.assertIn("  no triangles intersect at label 11; ", self.convert(*map_of_27, "11").err)

    def test_explain_tells_what_was_left_out(self):
        err = self.convert("demo:sphere?size=64", "--iso", "0", "--explain", "-o", "out.ply").err
        self.assertRegex(err, r"left out: [1-9]\d* of [1-9]\d* bricks \(.+\), which the iso value does not cross")
        self.assertRegex(err, r"262144 samples, each once")
        self.assertIn("normals, which the options do not request", err)

    def test_no_escape_sequences_without_a_terminal(self):
        run = self.convert("demo:marschner-lobb?size=96", "--iso", "0.5", "--threads", "1")
        self.assertNotIn("\x1b", run.err)
        self.assertNotIn("\r", run.err)

    def test_progress_on_a_terminal(self):
        arguments = ["demo:marschner-lobb?size=256", "--iso", "0.5", "--threads", "1", "-o", "out.ply"]
        text, code = output_on_terminal(arguments, self.folder, sleep=1.2)
        self.assertEqual(code, 0, text)
        self.assertRegex(text, r"\[#*\.*\] +\d+ % ")
        summary = text[text.rindex("\x1b[K") + len("\x1b[K"):]  # what stands after the last erasing
        self.assertRegex(summary, r"^demo:marschner-lobb\?size=256 iso 0\.5 -> out\.ply: ")
        text, code = output_on_terminal([*arguments, "-q"], self.folder, sleep=1.2)
        self.assertEqual((text, code), ("", 0))

    def test_short_work_shows_no_progress_on_a_terminal(self):
        text, code = output_on_terminal([SPHERE, "--iso", "0"], self.folder)
        self.assertEqual(code, 0)
        self.assertNotIn("\x1b", text)

    def test_colors_on_a_terminal_unless_refused(self):
        arguments = ["none.vdb", "--iso", "0"]
        text, code = output_on_terminal(arguments, self.folder)
        self.assertEqual(code, 2)
        self.assertIn("isoextract: \x1b[1;31merror:\x1b[0m none.vdb", text)
        self.assertIn("\x1b[1;31m", output_on_terminal(arguments, self.folder, NO_COLOR="")[0])
        for variables in ({"NO_COLOR": "1"}, {"TERM": "dumb"}):
            text, code = output_on_terminal(arguments, self.folder, **variables)
            self.assertIn("isoextract: error: none.vdb", text)
            self.assertNotIn("\x1b", text)

    def test_binary_data_does_not_go_to_a_terminal(self):
        arguments = [SPHERE, "--iso", "0", "-o", "-", "--format"]
        text, code = output_on_terminal([*arguments, "ply"], self.folder, stdout="terminal")
        self.assertEqual(code, 1)
        self.assertIn("terminal", text)
        text, code = output_on_terminal([*arguments, "ply", "--ascii"], self.folder, stdout="terminal")
        self.assertEqual(code, 0)
        self.assertIn("end_header", text)


if __name__ == "__main__":
    main()
