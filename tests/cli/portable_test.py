"""The folder that scripts/portable makes: complete, alone on a machine without libraries, and the same program."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

from support import PROGRAM, SOURCE, SPHERE, ProgramTest, Run, main

SAMPLE = SOURCE / "samples" / "metaballs.vdb"
PACK = SOURCE / "scripts" / "portable"
LOADER = "/lib64/ld-linux-x86-64.so.2"
# Of these the machine's are taken where they are new enough: glibc, and what GPU drivers use as well.
GLIBC = re.compile(r"/(ld-linux-x86-64|libc|libm|libdl|libpthread|librt)\.so\.\d+$")
SPARE = re.compile(r"/(libstdc\+\+|libgcc_s|libz|libzstd|liblzma)\.so\.\d+$")


def changed_root():
    """The command that starts another one in a folder as if that were everything; None where it is not allowed."""
    for command in (["chroot"], ["unshare", "--map-root-user", "chroot"]):
        try:
            subprocess.run([*command, "/", "/bin/true"], capture_output=True, check=True)
            return command
        except (OSError, subprocess.CalledProcessError):
            pass
    return None


@unittest.skipUnless(shutil.which("dpkg-query") and os.path.exists(LOADER), "the folder is made on x86-64 Debian only")
class PortableTest(ProgramTest):
    @classmethod
    def setUpClass(cls):
        # Beside the program, because temporary folders may be small or not for programs. With a space in its name.
        cls.place = pathlib.Path(tempfile.mkdtemp(prefix="portable test ", dir=pathlib.Path(PROGRAM).parent))
        cls.addClassCleanup(shutil.rmtree, cls.place)
        cls.packed = cls.place / "root" / "opt" / "isoextract"
        cls.printed = subprocess.run([PACK, "--program", PROGRAM, cls.packed], stdout=subprocess.PIPE, text=True,
                                     check=True).stdout
        cls.launcher = cls.packed / "isoextract"

    def launch(self, *arguments, command=None, **options):
        options.setdefault("cwd", self.folder)
        command = [*(command or [self.launcher]), *(str(argument) for argument in arguments)]
        finished = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=120, check=False,
                                  **options)
        return Run(finished)

    def plain_mesh(self):
        self.convert(SAMPLE, "--iso", "0.5", "-o", "plain.glb")
        return (self.folder / "plain.glb").read_bytes()

    def test_every_library_is_listed_and_has_its_licence(self):
        listed = (self.packed / "README.txt").read_text()
        for path in self.packed.glob("lib/**/*.so*"):
            if path.is_dir():
                continue
            line = re.search(rf"^  {re.escape(path.name)} +(\S+) +\S+$", listed, re.MULTILINE)
            self.assertTrue(line, path.name)
            self.assertIn("opyright", (self.packed / "licences" / line[1]).read_text(errors="replace"))
            self.assertIn(f"  {path.relative_to(self.packed)}\n", self.printed)
        self.assertEqual((self.packed / "licences" / "isoextract").read_bytes(), (SOURCE / "LICENSE").read_bytes())

    def loaded(self, **environment):
        """Paths of everything that a conversion loads."""
        with tempfile.TemporaryDirectory(dir=self.folder) as logs:
            environment = {**os.environ, **environment, "LD_DEBUG": "files", "LD_DEBUG_OUTPUT": f"{logs}/log"}
            with subprocess.Popen([self.launcher, SAMPLE, "--iso", "0.5", "-o", "logged.glb"], cwd=self.folder,
                                  env=environment, stderr=subprocess.PIPE) as process:
                _, err = process.communicate(timeout=120)
            self.assertEqual(process.returncode, 0, err)
            # The shell and then the program run in this process. Each ends its start with this line.
            log = (pathlib.Path(logs) / f"log.{process.pid}").read_text()
        self.assertEqual((self.folder / "logged.glb").read_bytes(), self.plain_mesh())
        starts = log.split("transferring control: ")
        self.assertTrue(starts[-1].startswith(f"{self.packed}/lib/isoextract"), starts[-1][:200])
        return set(re.findall(r"calling init: (\S.*)$", "".join(starts[-2:]), re.MULTILINE))

    def test_only_what_drivers_need_comes_from_the_machine(self):
        paths = self.loaded()
        self.assertIn(f"{self.packed}/lib/libblosc.so.1", paths)
        for path in paths:
            self.assertTrue(path.startswith(f"{self.packed}/") or GLIBC.search(path) or SPARE.search(path), path)

    def test_nothing_comes_from_the_machine_where_that_is_asked_for(self):
        paths = self.loaded(ISOEXTRACT_LIBRARIES="bundled")
        self.assertTrue(any(GLIBC.search(path) for path in paths))
        self.assertEqual([path for path in paths if not path.startswith(f"{self.packed}/")], [])

    def test_programs_that_it_starts_get_no_library_path(self):
        # bench starts gnuplot, here a stand-in that tells its environment.
        stand_in = self.folder / "gnuplot"
        stand_in.write_text(f'#!/bin/sh\necho "path=$LD_LIBRARY_PATH" >"{self.folder}/told"\nexit 1\n')
        stand_in.chmod(0o755)
        environment = {name: value for name, value in os.environ.items() if name != "LD_LIBRARY_PATH"}
        environment["PATH"] = f"{self.folder}:{environment['PATH']}"
        self.launch("bench", "demo:sphere", "--sizes", "16", "--plot", "out.svg", env=environment)
        self.assertEqual((self.folder / "told").read_text(), "path=\n")

    def test_it_starts_through_links_and_from_anywhere(self):
        expected = self.convert("--version").out
        (self.folder / "bin").mkdir()
        os.symlink(self.launcher, self.folder / "bin" / "first")
        os.symlink("bin/first", self.folder / "second")
        os.symlink(self.packed.parent, self.folder / "folder")
        path = f"{self.packed}:{os.environ['PATH']}"
        for command, options in (
                (["./second"], {}),
                (["first"], {"cwd": "/", "env": {**os.environ, "PATH": f"{self.folder}/bin:{os.environ['PATH']}"}}),
                (["isoextract"], {"cwd": "/", "env": {**os.environ, "PATH": path}}),
                (["folder/isoextract/isoextract"], {"env": {**os.environ, "CDPATH": "/"}}),
                (["sh", "isoextract"], {"cwd": self.packed})):
            run = self.launch("--version", command=command, **options)
            self.assertEqual((run.code, run.out, run.err), (0, expected, ""), command)

    @unittest.skipUnless((pathlib.Path(PROGRAM).parent / "plugins" / "isoextract-volume-dicom.so").exists(),
                         "the plug-in for DICOM was not built")
    def test_plugins_come_along(self):
        packed = self.place / "with plugins"
        command = [PACK, "--program", PROGRAM, "--with", "dicom", packed]
        printed = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout
        self.assertRegex(printed, r"KiB  lib/plugins/isoextract-volume-dicom\.so\n")
        self.assertRegex(printed, r"KiB  lib/libgdcmMSFF\.so")
        self.assertIn("libgdcm", (packed / "README.txt").read_text())
        listed = json.loads(self.launch("formats", "--json", command=[packed / "isoextract"]).out)
        [dicom] = [entry for entry in listed if entry["id"] == "dicom"]
        self.assertEqual(dicom["plugin"], str(packed / "lib" / "plugins" / "isoextract-volume-dicom.so"))
        refused = subprocess.run([*command[:3], "--with", "nothing", packed], capture_output=True, text=True, check=False)
        self.assertEqual(refused.returncode, 3)
        self.assertIn("the plug-in nothing is not in", refused.stderr)

    def test_arguments_streams_and_exit_codes_pass(self):
        plain = self.convert(SPHERE, "--iso", "0", "-o", "-", "--format", "ply", "-q")
        run = self.launch(SPHERE, "--iso", "0", "-o", "-", "--format", "ply", "-q")
        self.assertEqual((run.code, run.out, run.err), (0, plain.out, ""))
        run = self.launch(SPHERE, "--iso", "0", "-o", "a b $HOME *.ply")
        self.assertEqual(run.code, 0, run.err)
        self.assertEqual(self.files(), ["a b $HOME *.ply"])
        for arguments in (("no such.vdb", "--iso", "1"), ("--nonsense",), (SPHERE, "--iso", "9"), ("",)):
            plain, run = self.run_program(*arguments), self.launch(*arguments)
            self.assertEqual((run.code, run.out, run.err), (plain.code, plain.out, plain.err))
        for redirection in ("2>&-", ">&-", "<&-", ">&- 2>&- <&-"):
            run = self.launch(SPHERE, "--iso", "0", "-o", "closed.ply",
                              command=["bash", "-c", f'"$0" "$@" {redirection}', self.launcher])
            self.assertEqual(run.code, 0, run.err)

    def test_it_runs_where_nothing_else_is(self):
        change = changed_root()
        if change is None:
            self.skipTest("neither chroot nor unshare is allowed here")
        root = self.packed.parents[1]
        (root / "bin").mkdir()
        (root / "volumes").mkdir()
        shutil.copy(os.path.realpath("/bin/sh"), root / "bin" / "sh")
        shutil.copy(SAMPLE, root / "volumes")
        listing = subprocess.run([LOADER, "--list", "/bin/sh"], capture_output=True, text=True, check=True).stdout
        if len(re.findall("=> /", listing)) != 1:
            self.skipTest("the shell of this machine needs more than the C library")
        arguments = ["/opt/isoextract/isoextract", "/volumes/metaballs.vdb", "--iso", "0.5", "-o", "/volumes/out.glb"]
        expected = self.plain_mesh()

        # No C library at all: the shell itself is started with the folder's.
        glibc = "/opt/isoextract/lib/glibc"
        run = self.launch(*arguments, command=[*change, root, f"{glibc}/ld-linux-x86-64.so.2", "--library-path", glibc,
                                               "/bin/sh"])
        self.assertEqual(run.code, 0, run.err)
        self.assertEqual((root / "volumes" / "out.glb").read_bytes(), expected)
        (root / "volumes" / "out.glb").unlink()

        # A C library that is new enough, and nothing beside it.
        (root / "lib64").mkdir()
        shutil.copy(LOADER, root / "lib64")
        for library in (self.packed / "lib" / "glibc").iterdir():
            shutil.copy(library, root / "lib64")
        (self.packed / "lib" / "glibc").rename(self.place / "glibc")
        self.addCleanup((self.place / "glibc").rename, self.packed / "lib" / "glibc")
        environment = {**os.environ, "LD_LIBRARY_PATH": "/lib64"}
        run = self.launch(*arguments, command=[*change, root], env=environment)
        self.assertEqual(run.code, 0, run.err)
        self.assertEqual((root / "volumes" / "out.glb").read_bytes(), expected)

    def test_packing_refuses_a_folder_it_did_not_make(self):
        (self.folder / "mine").mkdir()
        (self.folder / "mine" / "thesis.txt").write_text("all of it")
        run = Run(subprocess.run([PACK, "--program", PROGRAM, self.folder / "mine"], capture_output=True, check=False))
        self.assertEqual(run.code, 4)
        self.assertIn("was not made by this script", run.err)
        self.assertEqual(self.files(), ["mine"])
        self.assertEqual((self.folder / "mine" / "thesis.txt").read_text(), "all of it")


if __name__ == "__main__":
    main()
