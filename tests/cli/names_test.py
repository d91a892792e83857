"""What files are called: patterns of other programs, one set of all names of a run, names that shells would run."""

import json
import os
import shutil
import subprocess

from support import PROGRAM, SOURCE, ProgramTest, main

RAW = ("--dims", "6,6,6", "--iso", "50")
# Run by a shell that reads it as a command; each makes a file called pwned.
HOSTILE = ("x'$(touch pwned)'y", "$(touch pwned)", "`touch pwned`", "a;touch pwned;", "a\" ; touch pwned ; \"", "-x $(touch pwned)")


class NamesTest(ProgramTest):
    def write_frames(self, numbers, name="in_{:03}.raw"):
        """Raw files of 6 x 6 x 6 bytes with one voxel that is inside: a closed mesh each."""
        for number in numbers:
            samples = bytearray(216)
            samples[86] = 100 + number % 100
            (self.folder / name.format(number)).write_bytes(bytes(samples))

    def names(self, folder="."):
        return sorted(path.name for path in (self.folder / folder).iterdir() if path.suffix != ".manifest")

    def test_one_conversion_names_its_files_as_a_batch_does(self):
        self.write_frames((7,))
        for number, (output, made) in enumerate((("{stem}_{frame:04}_{iso}.ply", "in_007_0007_50.ply"), ("a{{b}}.ply", "a{b}.ply"),
                                                 ("m_####.ply", "m_0007.ply"), ("", "in_007.glb"), ("x_$F4.ply", "x_0007.ply"))):
            if output:  # else the slash makes the folder
                (self.folder / f"single{number}").mkdir()
            self.convert("in_007.raw", *RAW, "-o", f"single{number}/{output}", "--report", "r_{stem}_{}.json")
            self.convert("in_007.raw", *RAW, "-o", f"batch{number}/{output}", "--mkdir", "--jobs", "1")
            self.assertEqual(self.names(f"single{number}"), [made])
            self.assertEqual(self.names(f"batch{number}"), [made])
            self.assertEqual((self.folder / f"single{number}" / made).read_bytes(),
                             (self.folder / f"batch{number}" / made).read_bytes())
        self.assertIn("r_in_007_7.json", self.files())

    def test_a_grid_has_to_be_chosen_to_name_a_file_after_it(self):
        self.write_frames((1,))
        self.assert_fails(1, self.run_program("in_001.raw", *RAW, "-o", "x_{grid}.glb"), "in_001.raw: expected the name of a grid", "found none")
        self.assert_fails(1, self.run_program("in_001.raw", *RAW, "-o", "x_{grids}.glb"), "'{grids}'")
        self.assertEqual(self.files(), ["in_001.raw"])
        volume = SOURCE / "samples/metaballs.vdb"
        grid = json.loads(self.convert("info", volume, "--json").text)[0]["grids"][0]["name"]
        self.convert(volume, "--grid", grid, "--iso", "0.5", "-o", "x_{grid}.glb")
        self.assertIn(f"x_{grid}.glb", self.files())

    def test_info_suggests_a_name_that_is_that_name(self):
        samples = bytearray(216)
        samples[86] = 200
        header = "{'descr': '|u1', 'fortran_order': False, 'shape': (6, 6, 6), }".ljust(117) + "\n"
        (self.folder / "a{b}.npy").write_bytes(b"\x93NUMPY\1\0" + len(header).to_bytes(2, "little") + header.encode() + bytes(samples))
        command = json.loads(self.convert("info", "a{b}.npy", "--json").text)[0]["field"]["suggestion"]["command"]
        run = subprocess.run(["bash", "-c", command.replace("isoextract", f"'{PROGRAM}'", 1)], cwd=self.folder, capture_output=True,
                             check=False, timeout=60)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn("a{b}.glb", self.files())

    def test_numbering_of_other_programs(self):
        self.write_frames((1, 2, 12), "fire.{:04}.raw")
        for number, pattern in enumerate(("fire.#.raw", "fire.####.raw", "fire.@.raw", "fire.@@@@.raw", "fire.$F4.raw", "fire.${F4}.raw",
                                          "fire.$F.raw", "fire.%4d.raw", "fire.%04d.raw", "fire.%d.raw")):
            output = pattern.replace("fire", "m").replace("raw", "ply")
            run = self.run_program(pattern, *RAW, "-o", f"{number}/{output}", "--mkdir")
            self.assertEqual(run.code, 0, (pattern, run.err))
            wide = ["m.0001.ply", "m.0002.ply", "m.0012.ply"]
            plain = ["m.1.ply", "m.12.ply", "m.2.ply"]
            self.assertEqual(self.names(str(number)), wide if "4" in pattern or "##" in pattern or "@@" in pattern else plain, pattern)

    def test_marks_within_words_are_text(self):
        self.write_frames((1,), "take#1@home$FF{}.raw")
        self.convert("take#1@home$FF1.raw", *RAW, "-o", "cube#1@x_$FF.ply")
        self.assertIn("cube#1@x_$FF.ply", self.files())
        self.write_frames((3,), "fire.#.raw")  # a file of this very name comes first
        self.write_frames((4, 5), "fire.{}.raw")
        self.convert("fire.#.raw", *RAW, "-o", "one.ply")
        self.convert("fire.{}.raw", *RAW, "-o", "x{#}_{@}_{$}F_{}.ply")
        self.assertTrue({"one.ply", "x#_@_$F_4.ply"} <= set(self.files()))

    def test_numbering_that_is_not_known_is_named(self):
        self.write_frames((1001,), "wall.{}.raw")
        for name, mark in (("wall.<UDIM>.raw", "<UDIM>"), ("wall.<f4>.raw", "<f4>"), ("wall.$FF.raw", "$FF"), ("wall#.raw", "#"),
                           ("wall.*.raw", "*")):
            for command in ((), ("info",)):
                options = RAW[:2] if command else (*RAW, "-o", "x.ply")
                self.assert_fails(1, self.run_program(*command, name, *options), f"there is no such file, and isoextract does not expand {mark}",
                                  "write {} in place of the frame number")

    def test_reports_of_one_frame_and_the_input_of_another(self):
        self.write_frames((1,), "a.nrrd")
        self.write_frames((1,), "g1.nrrd")
        before = (self.folder / "g1.nrrd").read_bytes()
        run = self.run_program("a.nrrd", "g1.nrrd", "--input-format", "raw", *RAW, "-o", "m_{}.ply", "--report", "g{}.nrrd", "--jobs", "1")
        self.assert_fails(1, run, "g1.nrrd: the report of frame 1 needs another name: this is the input of frame 2")
        self.assertEqual((self.folder / "g1.nrrd").read_bytes(), before)
        self.assertEqual(self.names(), ["a.nrrd", "g1.nrrd"])

    def test_files_that_only_a_header_names_are_read(self):
        header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 6 6 6\nencoding: raw\ndata file: {}\n\n"
        self.write_frames((1, 2), "r_{}.json")
        for frame, data in ((1, "r_2.json"), (2, "r_1.json")):
            (self.folder / f"h_{frame}.nhdr").write_text(header.format(data))
        before = [(self.folder / f"r_{frame}.json").read_bytes() for frame in (1, 2)]
        run = self.run_program("h_{}.nhdr", "--iso", "50", "-o", "m_{}.ply", "--report", "r_{}.json")
        self.assert_fails(1, run, "this holds samples or attributes of the input; it is not overwritten")
        self.assertEqual([(self.folder / f"r_{frame}.json").read_bytes() for frame in (1, 2)], before)

    def test_the_file_of_the_options(self):
        self.write_frames((1, 2))
        single = 'input = "in_001.raw"\ndims = "6,6,6"\niso = 50\n'
        sequence = 'input = "in_{:03}.raw"\ndims = "6,6,6"\niso = 50\n'
        os.symlink("job.toml", self.folder / "link.ply")
        for text, arguments in ((single, ("-o", "job.toml", "--format", "ply")), (single, ("-o", "link.ply")),
                                (single, ("-o", "m.ply", "--report", "./job.toml")), (single, ("-o", "m.ply", "--html", "job.toml")),
                                (single, ("-o", "m.ply", "--unknown", "--report", "job.toml")),
                                (single, ("-o", "m.ply", "--iso", "50", "--iso", "50", "--report", "job.toml")),
                                (sequence, ("-o", "job.toml", "--format", "glb", "--animate")), (sequence, ("-o", "m_{}.ply", "--html", "job.toml"))):
            (self.folder / "job.toml").write_text(text)
            run = self.run_program("--config", "job.toml", *arguments)
            self.assertEqual(run.code, 1, run.err)
            self.assertEqual((self.folder / "job.toml").read_text(), text, arguments)
            self.assertEqual(self.names(), ["in_001.raw", "in_002.raw", "job.toml", "link.ply"], arguments)

    def test_two_files_of_one_name(self):
        self.write_frames((1, 2))
        for arguments, parts in ((("--html", "m_2.ply"), ("the page and the mesh of frame 2",)),
                                 (("--table", "r_1.json", "--report", "r_{}.json"), ("r_1.json: the report of frame 1 and the table would share this file",)),
                                 (("--html", "p.svg", "--plot", "./p.svg"), ("the page and the plot would share this file",))):
            run = self.run_program("in_{:03}.raw", *RAW, "-o", "m_{}.ply", *arguments)
            self.assert_fails(1, run, *parts)
        self.assertEqual(self.names(), ["in_001.raw", "in_002.raw"])
        self.convert("in_001.raw", *RAW, "-o", "/dev/null", "--format", "ply", "--report", "/dev/null")

    def test_no_file_has_the_name_of_a_manifest(self):
        self.write_frames((1, 2))
        for arguments in (("in_001.raw", "-o", "isoextract.manifest", "--format", "glb"), ("in_001.raw", "-o", "m.ply", "--report", "isoextract.2-of-3.manifest"),
                          ("in_{:03}.raw", "-o", "isoextract.{}-of-2.manifest", "--format", "ply"),
                          ("in_{:03}.raw", "-o", "m_{}.ply", "--html", "isoextract.manifest")):
            self.assert_fails(1, self.run_program(*arguments, *RAW), "only the manifest of a batch may have this name")
        self.assertEqual(self.files(), ["in_001.raw", "in_002.raw"])

    # Scripts

    def fakes(self, *names):
        """Programs that note their arguments in calls.txt, one JSON list a line, and do nothing else."""
        folder = self.folder / "fakes"
        folder.mkdir(exist_ok=True)
        for name in names:
            path = folder / name
            path.write_text("#!/usr/bin/env python3\nimport json, os, sys\n"
                            f"with open({str(self.folder / 'calls.txt')!r}, 'a') as file:\n"
                            "    file.write(json.dumps([os.path.basename(sys.argv[0]), *sys.argv[1:]]) + '\\n')\n"
                            "print('42')\n")
            path.chmod(0o755)
        return dict(os.environ, PATH=f"{folder}:{os.environ['PATH']}", ISOEXTRACT_PROGRAM=PROGRAM)

    def calls(self):
        path = self.folder / "calls.txt"
        found = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
        path.unlink(missing_ok=True)
        return found

    def run_script(self, name, *arguments, environment, root=SOURCE):
        shell = ["bash"] if name.endswith(".sbatch") else []  # which Slurm runs
        return subprocess.run([*shell, str(root / "scripts" / name), *arguments], cwd=self.folder, env=environment, stdin=subprocess.DEVNULL,
                              capture_output=True, text=True, check=False, timeout=100)

    def assert_nothing_was_run(self, what):
        self.assertEqual(list(self.folder.rglob("pwned")), [], what)

    def test_submit_passes_names_on_and_runs_none(self):
        self.write_frames((1, 2))
        environment = self.fakes("sbatch")
        for name in HOSTILE:
            (self.folder / name).mkdir(exist_ok=True)
            for output in (("-o", f"./{name}/f_{{}}.glb"), (f"--output=./{name}/f_{{}}.glb",)):
                run = self.run_script("cluster/submit", "2", "--", "in_{:03}.raw", *RAW, *output, "--frames", "1-2", environment=environment)
                self.assertEqual(run.returncode, 0, run.stderr)
                array, merge = self.calls()
                self.assertTrue(set(output) <= set(array), array)
                wrap = merge[-1].removeprefix("--wrap=")
                # As Slurm runs it.
                subprocess.run(["bash", "-c", wrap.replace(PROGRAM, str(self.folder / "fakes/sbatch"))], cwd=self.folder, check=True,
                               capture_output=True, timeout=60)
                ran = self.calls()
                self.assertEqual([ran[0][1], os.path.normpath(ran[0][2])], ["merge", name])
                self.assert_nothing_was_run(name)

    def test_submit_asks_for_the_memory_of_all_threads_of_a_task(self):
        environment = self.fakes("sbatch")
        frames = ("demo:gyroid?size=48&time=0.{:02}", "--frames", "1-2", "--iso", "0", "-o", "f_{}.ply")

        def memory(*options):
            run = self.run_script("cluster/submit", "2", *options, "--", *frames, environment=environment)
            self.assertEqual(run.returncode, 0, run.stderr)
            array = self.calls()[0]
            self.assertEqual(array[4:4 + len(options)], list(options))
            return [word for word in array if word.startswith("--mem=")]

        whole = memory("--cpus-per-task=4")
        self.assertNotEqual(whole, memory())
        for options in (("-c", "4"), ("--cpus-per-task", "4"), ("-c4",), ("--time", "1:00:00", "-c", "4"), ("-c", "1", "--cpus-per-task=4")):
            self.assertEqual(memory(*options), whole, options)
        for options in (("-c", "many"), ("--cpus-per-task=",)):
            run = self.run_script("cluster/submit", "2", *options, "--", *frames, environment=environment)
            self.assertEqual(run.returncode, 1, options)
            self.assertIn("expected a number of processors", run.stderr)

    def test_submit_gives_the_joining_job_what_says_where_it_may_run(self):
        environment = self.fakes("sbatch")
        frames = ("demo:gyroid?size=24&time=0.{:02}", "--frames", "1-2", "--iso", "0", "-o", "f_{}.ply")
        for options in (("--account=proj", "--partition=short"), ("-A", "proj", "-p", "short"), ("-Aproj", "-pshort"),
                        ("--account", "proj", "--qos", "low", "--clusters=a", "--reservation=r"), ("-M", "a", "-q", "low", "--time=1:00:00")):
            run = self.run_script("cluster/submit", "2", *options, "-c", "2", "--", *frames, environment=environment)
            self.assertEqual(run.returncode, 0, run.stderr)
            array, joining = self.calls()
            self.assertEqual(joining[-len(options) - 1:-1], list(options))
            self.assertNotIn("-c", joining)
            self.assertEqual(array[4:4 + len(options)], list(options))

    def test_submit_tells_where_only_the_joining_job_is_refused(self):
        environment = self.fakes("sbatch")
        with open(self.folder / "fakes/sbatch", "a") as fake:
            fake.write("sys.exit(any(word.startswith('--wrap=') for word in sys.argv))\n")
        run = self.run_script("cluster/submit", "2", "--", "demo:gyroid?size=24&time=0.{:02}", "--frames", "1-2", "--iso", "0", "-o", "f_{}.ply",
                              environment=environment)
        self.assertEqual(run.returncode, 1)
        self.assertIn("array 42 is submitted, the joining job is not: run isoextract merge . after it", run.stderr)

    def test_a_task_of_an_array_takes_its_part(self):
        self.write_frames(range(1, 6))
        environment = dict(self.fakes(), SLURM_ARRAY_TASK_ID="2", SLURM_ARRAY_TASK_MIN="1", SLURM_ARRAY_TASK_COUNT="5")
        for name in HOSTILE:
            run = self.run_script("cluster/shard.sbatch", "in_{:03}.raw", *RAW, "-o", f"./{name}/f_{{}}.ply", "--mkdir", environment=environment)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertEqual(self.names(name), ["f_2.ply"])
            self.assert_nothing_was_run(name)
        run = self.run_script("cluster/shard.sbatch", "in_{:03}.raw", *RAW, "-o", "part/f_{}.ply", "--mkdir", "--shard", "5/5",
                              environment=environment)
        self.assertEqual(self.names("part"), ["f_5.ply"], run.stderr)

    def test_no_script_runs_what_a_name_contains(self):
        # A copy, in a folder that has such a name itself; what they call only notes how.
        root = self.folder / "a $(touch pwned) `touch pwned` b"
        shutil.copytree(SOURCE / "scripts", root / "scripts", ignore=shutil.ignore_patterns("__pycache__"))
        (root / "tests").mkdir()
        shutil.copytree(SOURCE / "tests/support", root / "tests/support")
        (root / "build/release").mkdir(parents=True)
        (root / "build/release/build.ninja").write_text("")
        environment = self.fakes("isoextract", "apt-get", "apt", "dpkg-query", "cmake", "run-clang-tidy", "clang-format", "clang-tidy",
                                 "shellcheck", "meshlabserver", "xvfb-run", "blender", "gnuplot", "node", "npm", "nproc")
        (self.folder / "fakes/ninja").write_text("#!/bin/sh\necho no work to do\n")
        (self.folder / "fakes/ninja").chmod(0o755)
        program = root / "build/release/isoextract"
        shutil.copy(self.folder / "fakes/isoextract", program)
        environment["ISOEXTRACT_PROGRAM"] = str(program)
        for name in (HOSTILE[0], HOSTILE[3], HOSTILE[5]):
            mesh = self.folder / f"{name}.ply"
            mesh.write_text("ply\n")
            for script, arguments in (("run", (name, "-o", f"{name}.glb")), ("make_pictures", ("--data", name, "head", "smoke")),
                                      ("make_pictures", (name,)), ("lint", ("tidy", name)), ("meshlab_pipe", ("-o", name)),
                                      ("check_in_viewers.py", (str(mesh),)), ("mesh_hashes.py", (name,)), ("compare_speed.py", (name,)),
                                      ("compare_topology.py", (name,)), ("blender/check", ("--animated", name)),
                                      ("blender/pack", (f"{name}.zip",)), ("portable", ("--program", name, f"packed {name}")),
                                      ("measure", ("run", name)), ("fuzz", (name, name)), ("test", (name,)), ("setup.sh", (name,)),
                                      ("portable_launcher.sh", (name,)), ("cluster/submit", (name, "--", name)),
                                      ("colormaps.py", (name,))):
                run = self.run_script(script, *arguments, environment=environment, root=root)
                self.assert_nothing_was_run((script, name, run.stdout, run.stderr))
                if script == "run":
                    self.assertIn(["isoextract", name, "-o", f"{name}.glb"], self.calls())


if __name__ == "__main__":
    main()
