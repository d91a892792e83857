#!/usr/bin/env python3
"""docs/messages.md has every error and note of the code, and the scan of the code finds what it should.

    messages_test.py REPOSITORY
"""

import pathlib
import re
import subprocess
import sys
import unittest

sys.dont_write_bytecode = True
ROOT = pathlib.Path(sys.argv.pop()) if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

from wording import message_calls  # noqa: E402

PLANTED = """
Result<int> f() {
  if (a) return fail(ErrorCode::no_surface, fmt::format("{}: no \\"voxel\\" above {:.3g} "
                     "of {}", file, iso, g(1, 2)), {Remedy::lower, Setting::iso});
  if (b) return tl::unexpected(Error{ErrorCode::output, path + ": the disk is full", "free some space"});
  // fail(ErrorCode::usage, "in a comment")
  if (c) throw DamagedMesh("expected a face");
  if (d) return refuse_usage("two of one", fmt::format("leave {} out", name));
  if (e) return fail(ErrorCode::input, fmt::format("{}{} {} bad", a, b, n == 1 ? "is" : "are"),
                     {{Remedy::leave_out, Setting::grid, "it has no name"}, {Remedy::set, Setting::mesh_format, names},
                      {Remedy::leave_out, Setting::raw_layout}});
  return fail(ErrorCode::usage, text);
}
"""


class Messages(unittest.TestCase):
    def test_page_has_all_messages(self):
        run = subprocess.run([ROOT / "scripts/messages", "check"], capture_output=True, text=True)
        self.assertEqual(run.returncode, 0, run.stderr)

    def test_scan_finds_calls_with_code_and_hint(self):
        found = list(message_calls.errors_of("room", PLANTED, message_calls.Hints(ROOT)))
        self.assertEqual([(error.text, error.code, error.hints) for error in found],
                         [('…: no "voxel" above … of …', 2, {"give a smaller --iso V"}),
                          ("…: the disk is full", 4, {"free some space"}),
                          ("expected a face", 2, set()),
                          ("two of one", 1, {"leave … out"}),
                          # As step_words() of cli/remedies.cpp prints them.
                          ("… are bad", 2, {"leave --grid out: it has no name; use --format …; leave out --dims and --dtype"})])

    def test_scan_misses_few_calls(self):
        # Calls whose message is a variable cannot be listed; the functions that make such texts are listed themselves.
        calls = listed = 0
        for path in (ROOT / "src").rglob("*.cpp"):
            source = path.read_text()
            calls += len(re.findall(r"\bfail\(ErrorCode::", source))
            listed += len(list(message_calls.errors_of("room", source, message_calls.Hints(ROOT))))
        self.assertGreater(listed, 0.9 * calls)

    def test_each_note_id_is_used(self):
        ids = re.findall(r"Word\{NoteId::(\w+),", (ROOT / "src/base/note.hpp").read_text())
        sources = "".join(path.read_text() for path in (ROOT / "src").rglob("*.cpp") if path.name != "note_guide.cpp")
        self.assertGreater(len(ids), 50)
        self.assertEqual([name for name in ids if f"NoteId::{name}" not in sources], [])


if __name__ == "__main__":
    unittest.main()
