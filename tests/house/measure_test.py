"""The pages of docs/measurements are what their JSON gives, and a page that is not is found: measure_test.py PROJECT_FOLDER"""

import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(sys.argv[1]).resolve()
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "scripts"))

from measuring import page_cache, pages, record, tables  # noqa: E402


class MeasureTest(unittest.TestCase):
    def setUp(self):
        self.home = pathlib.Path(tempfile.mkdtemp(prefix="isoextract-house-"))
        self.addCleanup(shutil.rmtree, self.home)
        self.folder = self.home / "measurements"
        shutil.copytree(ROOT / "docs" / "measurements", self.folder)

    def measure(self, *arguments):
        return subprocess.run([sys.executable, ROOT / "scripts" / "measure", *arguments, "--folder", self.folder],
                              capture_output=True, text=True, check=False)

    def expect(self, *parts):
        done = self.measure("pages", "--check")
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        for part in parts:
            self.assertIn(part, done.stdout)

    def change(self, name, how):
        path = self.folder / name
        document = json.loads(path.read_text())
        how(document)
        path.write_text(json.dumps(document))

    def test_the_pages_are_what_their_json_gives(self):
        done = self.measure("pages", "--check")
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))

    def test_every_measurement_is_there(self):
        names = [path.stem for path in self.folder.glob("*.json")]
        self.assertEqual(sorted(names), sorted(pages.MEASUREMENTS))
        self.assertEqual(sorted(names), sorted(line.split()[0] for line in subprocess.run(
            [sys.executable, ROOT / "scripts" / "measure", "list"], capture_output=True, text=True, check=True
        ).stdout.splitlines()))

    def test_another_figure_in_the_json_is_found_and_pages_fixes_it(self):
        self.change("topology.json", lambda document: document["figures"]["rows"][0]["right"].update(uniform=1))
        self.expect("topology.md")
        self.assertEqual(self.measure("pages").returncode, 0)
        self.assertEqual(self.measure("pages", "--check").returncode, 0)

    def test_another_commit_is_found_on_the_page_and_in_the_index(self):
        self.change("stability.json", lambda document: document.update(commit="0123456789abcdef"))
        self.expect("stability.md", "README.md")
        self.measure("pages")
        self.assertIn("`0123456789ab`", (self.folder / "stability.md").read_text())
        self.assertIn("not all of one commit", (self.folder / "README.md").read_text())

    def test_a_page_that_was_edited_is_found(self):
        path = self.folder / "simplify.md"
        path.write_text(path.read_text().replace("1", "2", 1))
        self.expect("simplify.md")

    def test_a_picture_of_another_run_is_found(self):
        path = self.folder / "error-time.svg"
        path.write_text(path.read_text() + "\n")
        self.expect("error-time.svg: not the file that was measured")

    def test_a_header_that_lacks_something_is_found(self):
        self.change("speed.json", lambda document: document.pop("machine"))
        self.expect("speed.json", "machine")

    def test_what_is_no_measurement_is_found(self):
        (self.folder / "old.json").write_text("{}")
        (self.folder / "threads.json").unlink()
        self.expect("old.json: belongs to no measurement", "threads.json: not there", "threads.md: belongs to no")

    def test_a_trial_run_does_not_replace_figures(self):
        self.change("stability.json", lambda document: document.update(quick=False))
        before = (self.folder / "stability.json").read_bytes()
        done = self.measure("run", "stability", "--quick", "--isoextract", "nowhere", "--bench", "nowhere")
        self.assertEqual(done.returncode, 1)
        self.assertIn("stability.json is of a whole run", done.stderr)
        self.assertEqual((self.folder / "stability.json").read_bytes(), before)
        self.assertIn("no measurement 'sped'", self.measure("run", "sped").stderr)

    def test_pages_of_trial_runs_say_so(self):
        for quick in (True, False):
            self.change("stability.json", lambda document: document.update(quick=quick))
            self.measure("pages")
            self.assertEqual("trial run" in (self.folder / "stability.md").read_text(), quick)

    def test_a_checkout_with_changes_is_told_from_a_clean_one(self):
        repository = self.home / "repository"
        (repository / "docs" / "measurements").mkdir(parents=True)
        git = ["git", "-C", repository, "-c", "user.name=x", "-c", "user.email=x@example.org"]
        (repository / "a").write_text("1")
        for command in (["init", "-q"], ["add", "a"], ["commit", "-q", "-m", "x"]):
            subprocess.run([*git, *command], check=True)
        self.addCleanup(setattr, record, "ROOT", record.ROOT)
        record.ROOT = repository
        (repository / "docs" / "measurements" / "speed.json").write_text("{}")
        digest, dirty = record.commit()
        self.assertEqual((len(digest), dirty), (40, False))
        (repository / "b").write_text("1")
        self.assertEqual(record.commit(), (digest, True))
        (repository / "b").unlink()
        (repository / "a").write_text("2")
        self.assertEqual(record.commit(), (digest, True))

    def test_how_much_of_a_file_is_in_the_page_cache(self):
        path = self.home / "file"
        path.write_bytes(bytes(1 << 20))
        self.assertEqual(page_cache.resident(path), 1)
        left = page_cache.evict(path)  # what stays depends on the file system, but not its meaning
        self.assertEqual(left, page_cache.resident(path))
        path.read_bytes()
        self.assertEqual(page_cache.resident(path), 1)

    def test_numbers(self):
        for value, text in ((1234567, "1,234,567"), (1234.5, "1,234"), (12.345, "12.3"), (0.000123, "0.000123"), (0.0, "0"),
                            (1.5e-9, "1.5e-09"), (None, "–"), (99.96, "100"), (999.6, "1,000")):
            self.assertEqual(tables.number(value), text)
        with self.assertRaises(ValueError):
            tables.table(["a", "b"], [["only one"]])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
