"""Files that plug-ins read are read in child processes: whatever a file makes of its reader is an error of that file, and
nothing is left behind."""

import os
import pathlib
import signal
import subprocess
import sys
import time

from support import PROGRAM, ProgramTest, main

PLUGINS = pathlib.Path(os.environ["ISOEXTRACT_TEST_PLUGINS"])
ISO = ("--iso", "0.5", "--cap")
CHILD = b"@child-process"


def processes_in(folder):
    """The numbers of child processes of isoextract whose working folder this is."""
    found = []
    for process in pathlib.Path("/proc").iterdir():
        try:
            if process.name.isdigit() and CHILD in (process / "cmdline").read_bytes().split(b"\0"):
                if os.readlink(process / "cwd") == str(folder):
                    found.append(int(process.name))
        except OSError:
            continue  # it has ended meanwhile
    return found


def name_of(number):
    try:
        return pathlib.Path(f"/proc/{number}/comm").read_text().strip()
    except OSError:
        return None  # it has ended meanwhile


def waiting_in(folder):
    """The reader whose deed is to wait, and the server that forked it. A reader that only lists grids does not count."""
    found = processes_in(folder)
    readers = [number for number in found if name_of(number) == "waiting"]
    return (readers[0], min(set(found) - set(readers))) if len(readers) == 1 and len(found) == 2 else None


def wait_until(condition, seconds=20):
    end = time.monotonic() + seconds
    while True:
        result = condition()
        if result or time.monotonic() > end:
            return result
        time.sleep(0.02)


class ChildTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.environment = dict(os.environ, ISOEXTRACT_PLUGINS=str(PLUGINS))

    def file(self, deed, stage="open", name="a.hostile"):
        (self.folder / name).write_text(f"hostile {stage} {deed}\n")
        return name

    def run_hostile(self, deed, *arguments, stage="open", seconds=None):
        if seconds is not None:
            self.environment["ISOEXTRACT_PLUGIN_SECONDS"] = str(seconds)
        name = self.file(deed, stage)
        return self.run_program(name, *ISO, "-o", "a.ply", *arguments, env=self.environment)

    def assert_waits(self):
        found = wait_until(lambda: waiting_in(self.folder))
        self.assertTrue(found, processes_in(self.folder))
        return found

    def assert_nothing_left(self, *files):
        self.assertEqual(self.files(), sorted(files))
        self.assertTrue(wait_until(lambda: not processes_in(self.folder)), processes_in(self.folder))

    def test_a_good_file_is_read_as_in_the_own_process(self):
        for deed in ("nothing", "sparse"):
            for way in ((), ("--in-process",)):
                run = self.run_hostile(deed, *way)
                self.assertEqual(run.code, 0, run.err)
                mesh = (self.folder / "a.ply").read_bytes()
                if way:
                    self.assertEqual(mesh, apart)
                apart = mesh
        self.assert_nothing_left("a.hostile", "a.ply")

    def test_what_ends_the_reader_is_an_error_of_the_file(self):
        for stage in ("list", "open"):
            for deed, what in (("crash", r"crashed \(signal 11\)"), ("abort", r"crashed \(signal 6\)"),
                               ("exit", "ended without an answer")):
                with self.subTest(stage=stage, deed=deed):
                    run = self.run_hostile(deed, stage=stage)
                    self.assert_fails(2, run, "a.hostile: ", "the file is damaged")
                    self.assertRegex(run.err, what)
                    self.assert_nothing_left("a.hostile")
        self.assert_fails(2, self.run_program("info", self.file("crash"), env=self.environment), "a.hostile: ", "crashed")

    def test_in_process_is_in_the_program_itself(self):
        self.assertEqual(self.run_hostile("crash", "--in-process").code, -signal.SIGSEGV)

    def test_what_never_ends_is_ended(self):
        for deed in ("wait", "spin", "chatter"):
            with self.subTest(deed):
                run = self.run_hostile(deed, seconds=1)
                self.assert_fails(2, run, "a.hostile: ", "exceeded its time limit of 1 s", "ISOEXTRACT_PLUGIN_SECONDS")
                self.assert_nothing_left("a.hostile")
        self.assert_fails(2, self.run_hostile("lie-length"), "a.hostile: ", "ended without an answer")

    def test_what_is_not_loaded_in_time_is_ended(self):
        """The user stops or kills the process that loads the plug-in: the plug-in is then not at fault."""
        for number, what in ((signal.SIGSTOP, "takes more than 1 s to load"),
                             (signal.SIGKILL, "the system killed the process that loads it, as systems do when they lack memory"),
                             (signal.SIGSEGV, "ends the process that loads it")):
            with self.subTest(number):
                self.environment["HOSTILE_LOADING"] = str(int(number))
                run = self.run_hostile("nothing", seconds=1)
                self.assert_fails(3, run, "a.hostile: ", what)
                self.assertEqual("hint: try again" in run.err, number != signal.SIGSEGV, run.err)
                self.assert_nothing_left("a.hostile")

    def test_a_stopped_server_is_ended(self):
        """The process that forks the readers is stopped, and so cannot end one whose time is over, nor itself."""
        name = self.file("wait")
        self.environment["ISOEXTRACT_PLUGIN_SECONDS"] = "3"
        program = subprocess.Popen([PROGRAM, name, *ISO, "-o", "a.ply"], cwd=self.folder, env=self.environment,
                                   stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.addCleanup(program.stderr.close)
        _, server = self.assert_waits()
        os.kill(server, signal.SIGSTOP)
        _, err = program.communicate(timeout=60)
        self.assertEqual(program.returncode, 2, err)
        self.assertIn("exceeded its time limit of 3 s", err)
        self.assert_nothing_left("a.hostile")

    def test_the_time_is_a_number(self):
        self.assert_fails(1, self.run_hostile("nothing", seconds="soon"), "ISOEXTRACT_PLUGIN_SECONDS", "'soon'")

    def test_memory_ends_at_the_limit(self):
        run = self.run_hostile("allocate", "--memory-limit", "64M")
        self.assert_fails(2, run, "a.hostile: ", "memory", "--memory-limit")
        self.assert_nothing_left("a.hostile")
        # A temporary file would hold the samples, if there were a disk for it.
        self.environment["TMPDIR"] = "/dev/shm"
        self.assert_fails(2, self.run_hostile("huge", "--memory-limit", "64M"), "2000x2000x2000", "--memory-limit")
        self.assert_fails(2, self.run_hostile("greed", "--memory-limit", "64M"), "a.hostile: ", "--memory-limit")

    def test_what_it_prints_is_a_note(self):
        run = self.run_hostile("print")
        self.assertEqual(run.code, 0, run.err)
        self.assertIn("note[", run.err)
        self.assertIn("the plug-in for hostile printed: WARN: something\\x1b[31m is odd", run.err)
        self.assertNotIn("\x1b", run.err)
        self.assertEqual(run.out, b"")
        quiet = self.run_hostile("print", "-q")
        self.assertEqual((quiet.code, quiet.err, quiet.out), (0, "", b""))
        lines = self.run_hostile("print", "--progress", "json")
        for line in lines.err.splitlines():
            self.assertFalse(line.startswith("WARN"), line)
        self.assertEqual(self.run_hostile("print-much", "-q").err, "")

    def test_the_world_is_out_of_reach(self):
        run = self.run_hostile("world")
        self.assertEqual(run.code, 0, run.err)
        self.assertIn("could do nothing", run.err)
        self.assert_nothing_left("a.hostile", "a.ply")

    def test_lies_are_refused(self):
        for deed in ("lie-blocks", "lie-places", "sparse-unsorted"):
            with self.subTest(deed):
                self.assert_fails(2, self.run_hostile(deed), "a.hostile: the plug-in for hostile returns ")
        self.assert_fails(2, self.run_hostile("lie-list", stage="list"), "returns no list of grids")
        self.assertEqual(self.run_hostile("name").code, 0)

    def test_the_batch_goes_on(self):
        for number, deed in enumerate(("nothing", "crash", "nothing", "abort", "nothing")):
            self.file(deed, name=f"f_{number}.hostile")
        for jobs in ("1", "2"):
            run = self.run_program("f_{}.hostile", *ISO, "-o", "m_{}.ply", "--jobs", jobs, env=self.environment)
            self.assertEqual(run.code, 5, run.err)
            self.assertIn("f_1.hostile: ", run.err)
            self.assertIn("f_3.hostile: ", run.err)
            meshes = {name for name in self.files() if name.endswith(".ply")}
            self.assertEqual(meshes, {"m_0.ply", "m_2.ply", "m_4.ply"})
            self.assertTrue(wait_until(lambda: not processes_in(self.folder)))

    def test_it_ends_with_the_program(self):
        for end in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
            with self.subTest(end):
                name = self.file("wait")
                program = subprocess.Popen([PROGRAM, name, *ISO, "-o", "a.ply"], cwd=self.folder, env=self.environment,
                                           stdin=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                self.assert_waits()
                program.send_signal(end)
                program.wait(timeout=60)
                self.assert_nothing_left("a.hostile")

    def test_no_process_is_left_unburied(self):
        """A program that goes on after its reader has crashed has waited for it: nothing of it is in the list."""
        for number in range(4):
            self.file("crash" if number < 3 else "wait", name=f"f_{number}.hostile")
        program = subprocess.Popen([PROGRAM, "f_{}.hostile", *ISO, "-o", "m_{}.ply", "--jobs", "1", "--progress",
                                    "json"], cwd=self.folder, env=self.environment, stdin=subprocess.DEVNULL,
                                   stderr=subprocess.PIPE, text=True)
        self.addCleanup(program.stderr.close)
        try:
            for line in program.stderr:
                if "f_2.hostile" in line and "crashed" in line:
                    break
            states = []
            for process in pathlib.Path("/proc").iterdir():
                try:
                    fields = (process / "stat").read_text().rsplit(")", 1)[1].split()
                except (OSError, IndexError):
                    continue
                if int(fields[1]) == program.pid:
                    states.append(fields[0])
            self.assertNotIn("Z", states)
            self.assertEqual(len(states), 1)  # the one that has loaded the plug-in
        finally:
            program.kill()
            program.wait(timeout=60)

    def test_a_loader_that_is_killed_takes_its_reader_along_and_is_buried(self):
        """Frames after that have another one. (One that begins at once may be lost as well.)"""
        for number in range(1, 6):
            self.file("wait", name=f"f_{number}.hostile")
        program = subprocess.Popen([PROGRAM, "f_{}.hostile", *ISO, "-o", "m_{}.ply", "--jobs", "1"], cwd=self.folder,
                                   env=self.environment, stdin=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

        def loaders():
            tasks = pathlib.Path(f"/proc/{program.pid}/task")
            return {int(number) for task in tasks.iterdir() for number in (task / "children").read_text().split()}

        try:
            reader, first = self.assert_waits()
            os.kill(first, signal.SIGKILL)
            self.assertTrue(wait_until(lambda: loaders() - {first}), "no further frame has one")
            self.assertTrue(wait_until(lambda: reader not in processes_in(self.folder)), "its reader goes on")
            self.assertNotIn(first, loaders(), "it was not waited for")
        finally:
            program.kill()
            program.wait(timeout=60)

    def test_a_program_that_its_loader_starts(self):
        """As the portable folder's launcher does: /proc/self/exe is the loader then."""
        loader = next(path for path in ("/lib64/ld-linux-x86-64.so.2", "/lib/ld-linux-aarch64.so.1") if os.path.exists(path))
        run = subprocess.run([loader, "--library-path", "/nowhere", PROGRAM, self.file("crash"), *ISO, "-o", "a.ply"],
                             cwd=self.folder, env=self.environment, capture_output=True, text=True, check=False, timeout=120)
        self.assertEqual(run.returncode, 2, run.stderr)
        self.assertIn("crashed (signal 11)", run.stderr)

    def run_where(self, missing, *arguments):
        """The program where the system lacks something: a function of support that takes it away."""
        code = ("import os, sys; sys.path.insert(0, sys.argv[1]); import support; getattr(support, sys.argv[2])();"
                "os.execv(sys.argv[3], sys.argv[3:])")
        return subprocess.run([sys.executable, "-B", "-c", code, str(pathlib.Path(__file__).parent), missing, PROGRAM,
                               *arguments, *ISO, "-o", "a.ply"], cwd=self.folder, env=self.environment,
                              capture_output=True, text=True, check=False, timeout=120)

    def test_without_shared_memory_it_says_what_helps(self):
        refused = self.run_where("forbid_shared_memory", self.file("nothing"))
        self.assertEqual(refused.returncode, 3, refused.stderr)
        self.assertIn("memfd_create", refused.stderr)
        self.assertIn("--in-process", refused.stderr)
        self.assertEqual(self.run_where("forbid_shared_memory", "a.hostile", "--in-process").returncode, 0)

    def test_a_kernel_without_filters_still_has_the_limits(self):
        run = self.run_where("forbid_filters", self.file("crash"))
        self.assertEqual(run.returncode, 2, run.stderr)
        self.assertIn("crashed (signal 11)", run.stderr)
        self.assertEqual(self.run_where("forbid_filters", self.file("nothing")).returncode, 0)


if __name__ == "__main__":
    main()
