"""What is installed: the program with its man page, completions and the headers for plug-ins, and plug-ins found there."""

import os
import pathlib
import shutil
import subprocess

from support import SOURCE, ProgramTest, main

BUILD = os.environ["ISOEXTRACT_BINARY_DIR"]
PLUGINS = pathlib.Path(os.environ["ISOEXTRACT_TEST_PLUGINS"])

# Those that were built, which depends on the libraries that CMake found.
PLUGIN_FILES = sorted(f"lib/isoextract/plugins/{path.name}" for path in (pathlib.Path(BUILD) / "plugins").glob("isoextract-*"))


class InstallTest(ProgramTest):
    def setUp(self):
        super().setUp()
        subprocess.run(["cmake", "--install", BUILD, "--prefix", self.folder / "usr"], check=True, capture_output=True)

    def installed(self, *arguments):
        return subprocess.run([self.folder / "usr/bin/isoextract", *arguments], cwd=self.folder, check=False,
                              capture_output=True, text=True)

    def test_what_there_is(self):
        usr = self.folder / "usr"
        files = sorted(str(path.relative_to(usr)) for path in usr.rglob("*") if path.is_file())
        self.assertEqual(files, [
            "bin/isoextract", "include/isoextract/grid_tools_plugin.h", "include/isoextract/particle_plugin.h",
            "include/isoextract/plugin_samples.h", "include/isoextract/ranks_plugin.h", "include/isoextract/volume_plugin.h",
            "include/isoextract/volume_reader.hpp", *PLUGIN_FILES,
            "share/bash-completion/completions/isoextract", "share/fish/vendor_completions.d/isoextract.fish",
            "share/man/man1/isoextract.1", "share/zsh/site-functions/_isoextract"])
        self.assertEqual((usr / "share/man/man1/isoextract.1").read_text(), (SOURCE / "man/isoextract.1").read_text())
        for shell, name in (("bash", "bash-completion/completions/isoextract"),
                            ("zsh", "zsh/site-functions/_isoextract"), ("fish", "fish/vendor_completions.d/isoextract.fish")):
            self.assertEqual((usr / "share" / name).read_text(), self.installed("generate", shell).stdout)

    def test_plugins_beside_it_are_found(self):
        (self.folder / "a.tvol").write_text("textvolume\na 2 2 2\n-1 1 1 1 1 1 1 1\n")
        refused = self.installed("a.tvol", "--iso", "0", "-o", "a.ply")
        self.assertEqual(refused.returncode, 2, refused.stderr)
        folder = self.folder / "usr/lib/isoextract/plugins"
        folder.mkdir(parents=True, exist_ok=True)
        for suffix in (".so", ".txt"):
            shutil.copy(PLUGINS / f"isoextract-volume-text{suffix}", folder)
        done = self.installed("a.tvol", "--iso", "0", "-o", "a.ply")
        self.assertEqual(done.returncode, 0, done.stderr)


if __name__ == "__main__":
    main()
