"""What the program loads: nothing for pictures, windows or graphics cards until it is asked for, and never OpenVDB."""

import os
import re
import subprocess
import unittest

from support import PROGRAM, SPHERE, ProgramTest, main

# Libraries by the starts of their names.
UNWANTED = re.compile(r"\blib(GL|EGL|OpenGL|gbm|drm|vulkan|X11|xcb|wayland|vtk|openvdb|mpi)[A-Za-z0-9_.+-]*\.so", re.IGNORECASE)


class StartupTest(ProgramTest):
    def test_no_unwanted_library_is_loaded_at_the_start(self):
        run = subprocess.run([PROGRAM], env={**os.environ, "LD_TRACE_LOADED_OBJECTS": "1"}, capture_output=True,
                             check=True)
        loaded = run.stdout.decode()
        self.assertIn("libc.so", loaded)
        self.assertEqual([line for line in loaded.splitlines() if UNWANTED.search(line)], [])

    def test_no_second_tinygltf_is_in_it(self):
        """Draco's archive has one of another build, whose functions would be called in place of the library's."""
        symbols = subprocess.run(["nm", "--defined-only", PROGRAM], capture_output=True, text=True, check=True).stdout
        self.assertIn("isoextract", symbols)
        self.assertEqual([line for line in symbols.splitlines() if re.search(r" T .*8TinyGLTF", line)], [])

    def test_the_processor_needs_none_either(self):
        run = self.run_program(SPHERE, "--iso", "0", "--backend", "cpu", "-o", "a.ply",
                               env={**os.environ, "LD_DEBUG": "files"})
        self.assertEqual(run.code, 0)
        self.assertIn("libc.so", run.err)
        self.assertEqual([line for line in run.err.splitlines() if UNWANTED.search(line)], [])


if __name__ == "__main__":
    main()
