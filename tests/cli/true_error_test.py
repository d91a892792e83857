"""--error against the true distances, found by scripts/compare_error.py: numpy, a cloud of points on the isosurface and every
triangle of the file."""

import json
import subprocess

from support import PROGRAM, SOURCE, ProgramTest, main


class TrueErrorTest(ProgramTest):
    def rows(self, *arguments):
        run = subprocess.run(["/usr/bin/python3", "-B", SOURCE / "scripts/compare_error.py", "--isoextract", PROGRAM,
                              "--points", "1500", "--json", "rows.json", *arguments],
                             cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        return json.loads((self.folder / "rows.json").read_text())

    def test_by_every_method(self):
        rows = self.rows("--fields", "turbulence", "--sizes", "10")
        self.assertEqual([(row["method"], row["direction"]) for row in rows],
                         [(method, direction) for method in ("mc", "mt", "voxels", "surface-nets")
                          for direction in ("mesh to surface", "surface to mesh")])

    def test_where_the_gradient_leads_astray(self):
        (row, *_) = self.rows("--fields", "marschner-lobb", "--sizes", "16", "--methods", "mc")
        self.assertGreater(row["figures"][1], 0.02, "there is something to be measured")


if __name__ == "__main__":
    main()
