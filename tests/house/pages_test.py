"""The pages that people read: their links lead somewhere, the README stays short, every page of docs can be found from
it, and papers are cited by author and title: pages_test.py PROJECT_FOLDER"""

import pathlib
import re
import sys
import unittest

ROOT = pathlib.Path(sys.argv[1]).resolve()
sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent))

from rules import project_files  # noqa: E402

README_LINES = 100
# What only those knew who gave them these names.
PRIVATE_NAMES = re.compile(r"\b[Ss]eeds?( papers?)? S[0-9]\b|\bDESIGN\b|\bS[1-5]'s\b")


def pages():
    return [path for path in project_files(ROOT) if path.suffix == ".md"]


def without_code(text):
    text = re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)
    return re.sub(r"`[^`\n]*`", "`", text)


def links(path):
    """Targets of the links and pictures of a page that lie in the project: a path, and the heading after '#'."""
    for target in re.findall(r'(?:\]\(|<img src=")([^)"\s]+)', without_code(path.read_text())):
        if not re.match(r"[a-z]+:", target):
            file, _, heading = target.partition("#")
            yield target, (path.parent / file).resolve() if file else path, heading


def anchors(path):
    """As GitHub makes them of headings."""
    found = re.findall(r"^#+ (.*)$", re.sub(r"^```.*?^```", "", path.read_text(), flags=re.M | re.S), re.M)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in found}


class PagesTest(unittest.TestCase):
    def test_links_lead_somewhere(self):
        count = 0
        for page in pages():
            for target, path, heading in links(page):
                self.assertTrue(path.exists(), f"{page.relative_to(ROOT)}: {target}")
                self.assertTrue(path.is_relative_to(ROOT), f"{page.relative_to(ROOT)}: {target}")
                if heading:
                    self.assertIn(heading, anchors(path), f"{page.relative_to(ROOT)}: {target}")
                count += 1
        self.assertGreater(count, 20)

    def test_the_readme_is_short(self):
        self.assertLessEqual(len((ROOT / "README.md").read_text().splitlines()), README_LINES)

    def test_every_page_can_be_found(self):
        found, left = set(), [ROOT / "README.md"]
        while left:
            page = left.pop()
            if page in found or page.suffix != ".md":
                continue
            found.add(page)
            left += [path for _, path, _ in links(page)]
        lost = [page.relative_to(ROOT) for page in pages() if page not in found and page.is_relative_to(ROOT / "docs")]
        self.assertEqual(lost, [])

    def test_papers_are_cited_by_author_and_title(self):
        for path in project_files(ROOT):
            if path.suffix == ".md" or path.relative_to(ROOT).parts[0] in ("src", "shaders", "plugins", "man"):
                for number, line in enumerate(path.read_text().splitlines(), 1):
                    self.assertIsNone(PRIVATE_NAMES.search(line), f"{path.relative_to(ROOT)}:{number}: {line}")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
