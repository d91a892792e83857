"""The sample volumes are what make_samples writes: samples_test.py MAKE_SAMPLES SAMPLES_FOLDER"""

import pathlib
import subprocess
import sys
import tempfile
import unittest

TOOL = sys.argv[1]
SAMPLES = pathlib.Path(sys.argv[2])


class SamplesTest(unittest.TestCase):
    def test_the_same_bytes(self):
        with tempfile.TemporaryDirectory(prefix="isoextract-house-") as folder:
            subprocess.run([TOOL, folder], check=True)
            made = {path.name: path.read_bytes() for path in pathlib.Path(folder).iterdir()}
        kept = {path.name: path.read_bytes() for path in SAMPLES.iterdir() if path.suffix in (".nrrd", ".vdb")}
        self.assertEqual(sorted(made), sorted(kept))
        for name, content in made.items():
            self.assertTrue(content == kept[name], f"{name} differs: scripts/make_samples writes it afresh")
            self.assertLess(len(content), 200_000, name)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
