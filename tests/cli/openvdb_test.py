"""Grids of VDB files that plug-ins around OpenVDB read: opened only for them, and said to be missing where they are."""

import json
import pathlib
import shutil
import subprocess
import unittest

from support import PROGRAM, ProgramTest, main, read_ply
from vdb_files import frustum, grid, vdb

VOXELS = {(x, y, z): 1.0 for x in range(3, 7) for y in range(3, 7) for z in range(3, 7)}
PLUGIN = pathlib.Path(PROGRAM).parent / "plugins" / "isoextract-volume-openvdb.so"


class OpenVdbTest(ProgramTest):
    def setUp(self):
        super().setUp()
        (self.folder / "bent.vdb").write_bytes(vdb(grid("bent", VOXELS, transform=frustum())))

    def test_the_program_itself_is_not_linked_with_it(self):
        linked = subprocess.run(["ldd", PROGRAM], check=True, capture_output=True, text=True).stdout
        self.assertIn("libtbb", linked)
        self.assertNotIn("openvdb", linked)

    def test_what_is_missing_is_named(self):
        alone = self.folder / "alone" / "isoextract"
        alone.parent.mkdir()
        shutil.copy(PROGRAM, alone)
        run = subprocess.run([alone, "bent.vdb", "--iso", "0.5", "-o", "bent.ply"], cwd=self.folder, check=False,
                             capture_output=True, text=True)
        self.assertEqual(run.returncode, 3, run.stderr)
        for part in ("bent.vdb: the grid 'bent' lies in a frustum", "isoextract-volume-openvdb.so", "ISOEXTRACT_PLUGINS"):
            self.assertIn(part, run.stderr)
        self.assertFalse((self.folder / "bent.ply").exists())

    def test_points_are_particles_where_they_are_alone_or_named(self):
        alone = self.folder / "alone" / "isoextract"
        alone.parent.mkdir()
        shutil.copy(PROGRAM, alone)
        points = grid("drops", kind="ptdataidx32_5_4_3")
        (self.folder / "points.vdb").write_bytes(vdb(points))
        (self.folder / "both.vdb").write_bytes(vdb(grid("density", VOXELS), points))

        def run(*arguments):
            return subprocess.run([alone, *arguments], cwd=self.folder, check=False, capture_output=True, text=True)

        for arguments in (("points.vdb", "-o", "a.ply"), ("info", "points.vdb"), ("points.vdb", "--grid", "drops"),
                          ("both.vdb", "--grid", "drops", "-o", "a.ply")):
            ended = run(*arguments)
            self.assertEqual(ended.returncode, 3, ended.stderr)
            self.assertIn("isoextract-particles-openvdb.so", ended.stderr)
        # Names are chosen as those of volumes are.
        (self.folder / "several.vdb").write_bytes(vdb(grid("density", VOXELS), points, points))
        for arguments in (("both.vdb", "--grid", "/drops"), ("several.vdb", "--grid", "drops[1]")):
            ended = run(*arguments, "-o", "a.ply")
            self.assertEqual(ended.returncode, 3, ended.stderr)
            self.assertIn("isoextract-particles-openvdb.so", ended.stderr)
        ended = run("several.vdb", "--grid", "drops", "-o", "a.ply")
        self.assertEqual(ended.returncode, 2, ended.stderr)
        self.assertIn("several.vdb: 2 grids are named 'drops'", ended.stderr)
        self.assertIn("drops[1]", ended.stderr)
        ended = run("both.vdb", "--iso", "0.5", "-o", "a.ply")
        self.assertEqual(ended.returncode, 0, ended.stderr)
        self.assertIn("both.vdb[density]", ended.stderr)
        ended = run("both.vdb", "--grid", "density", "--radius", "1", "-o", "a.ply")
        self.assertEqual(ended.returncode, 1, ended.stderr)
        self.assertIn("found a volume", ended.stderr)

    def vectors(self):
        """Grids whose trees the program does not read; their headers state the type."""
        (self.folder / "vectors.vdb").write_bytes(vdb(grid("velocity", kind="vec3s_5_4_3"), grid("flags", kind="bool_5_4_3"),
                                                      grid("words", kind="string_5_4_3")))
        return "vectors.vdb"

    def test_info_says_what_needs_a_missing_plugin(self):
        alone = self.folder / "alone" / "isoextract"
        alone.parent.mkdir()
        shutil.copy(PROGRAM, alone)

        def info(*arguments):
            run = subprocess.run([alone, "info", *arguments], cwd=self.folder, check=False, capture_output=True, text=True)
            self.assertEqual(run.returncode, 0, run.stderr)
            return run.stdout

        for text in (info(self.vectors()), info("bent.vdb")):
            self.assertIn("needs the plug-in for openvdb, which is not installed", text)
            self.assertNotIn("its placement is not usable", text)
        listed = json.loads(info("vectors.vdb", "--json"))[0]["grids"]
        self.assertEqual([entry["scalar"] for entry in listed], [False, False, False])
        self.assertEqual(listed[0]["plugin"], {"id": "openvdb", "is_there": False,
                                               "grids": [f"velocity[{part}]" for part in ("x", "y", "z", "length")]})
        self.assertIsNone(listed[2]["plugin"])
        self.assertIn("isoextract cannot extract a surface from this type", info("vectors.vdb"))  # from strings, for good

    @unittest.skipUnless(PLUGIN.exists(), "the plug-ins around OpenVDB were not built")
    def test_info_says_what_convert_reads(self):
        text = self.convert("info", self.vectors()).text
        self.assertIn("the plug-in for openvdb reads it as velocity[x], velocity[y], velocity[z], velocity[length]", text)
        self.assertEqual(text.count("isoextract cannot extract a surface"), 1)  # from the strings
        self.assertIn("choose one grid with --grid NAME", text)
        text = self.convert("info", "bent.vdb").text
        self.assertNotIn("isoextract cannot extract a surface", text)
        self.assertNotIn("not usable", text)
        self.assertIn("extents", text)
        listed = json.loads(self.convert("info", "bent.vdb", "--json").text)[0]
        self.assertTrue(listed["grids"][0]["scalar"])
        self.assertIsNone(listed["grids"][0]["problem"])
        self.assertEqual(listed["field"]["format"], "OpenVDB")

    @unittest.skipUnless(PLUGIN.exists(), "the plug-ins around OpenVDB were not built")
    def test_a_frustum_becomes_a_mesh(self):
        run = self.convert("bent.vdb", "--iso", "0.5", "-o", "bent.ply")
        self.assertIn("lies in a frustum; the reader resamples it trilinearly to cubic voxels with a spacing of", run.err)
        mesh = read_ply((self.folder / "bent.ply").read_bytes())
        self.assertEqual(mesh.open_edges(), 0)
        # The box of the frustum is 1 by 1 in the world at its near end, twice that 1 further on. The block is in its
        # middle: from 2.5 to 6.5 of 9 voxels.
        low, high = mesh.bounds()
        for axis in range(2):
            self.assertAlmostEqual(low[axis], -high[axis], places=3)
            self.assertAlmostEqual(high[axis], 2 / 9 * (1 + 6.5 / 9), delta=0.05)
        self.assertAlmostEqual(low[2], 2.5 / 9, delta=0.05)
        self.assertAlmostEqual(high[2], 6.5 / 9, delta=0.05)


if __name__ == "__main__":
    main()
