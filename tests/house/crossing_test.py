"""An include that crosses the table of rooms does not compile: each room's real compile command is given a file that
includes one header of another room."""

import json
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import unittest

import rules

SOURCE = pathlib.Path(sys.argv[1]).resolve()
BUILD = pathlib.Path(sys.argv[2]).resolve()


def preprocessors():
    """The first compile command of each room's library, without its input and output, told to preprocess only."""
    commands = {}
    for entry in json.loads((BUILD / "compile_commands.json").read_text()):
        library = re.search(r" -o src/(\w+)/CMakeFiles/isoextract_\1\.dir/", entry["command"])
        if not library:
            continue
        words = shlex.split(entry["command"])
        while "ccache" in words[0]:
            words = words[1:]
        output = words.index("-o")
        del words[output : output + 2]
        words[words.index("-c") :] = ["-E", "-o", "/dev/null"]
        commands.setdefault(library[1], words)
    return commands


class CrossingTest(unittest.TestCase):
    def test_only_the_rooms_of_the_table_can_be_included(self):
        commands = preprocessors()
        headers = {room: sorted((SOURCE / "src" / room).glob("*.hpp")) for room in commands}
        self.assertEqual(sorted(commands), sorted(path.name for path in (SOURCE / "src").iterdir() if path.is_dir()))
        crossings = 0
        with tempfile.TemporaryDirectory(prefix="isoextract-house-") as folder:
            for room, command in commands.items():
                for other in (other for other in commands if headers[other]):
                    header = f"{other}/{headers[other][0].name}"
                    allowed = other in rules.reach(room)
                    with self.subTest(room=room, includes=header):
                        probe = pathlib.Path(folder) / "probe.cpp"
                        probe.write_text(f'#include "{header}"\n')
                        done = subprocess.run([*command, probe], cwd=BUILD, capture_output=True, text=True)
                        self.assertEqual(done.returncode == 0, allowed, done.stderr)
                        if not allowed:
                            self.assertRegex(done.stderr, f"{header}.*(No such file|not found)")
                            crossings += 1
        self.assertGreaterEqual(crossings, 12)

    def test_what_lies_below_a_room_cannot_be_included_by_others(self):
        commands = preprocessors()
        probed = 0
        with tempfile.TemporaryDirectory(prefix="isoextract-house-") as folder:
            probe = pathlib.Path(folder) / "probe.cpp"
            for room, command in commands.items():
                for other in sorted(rules.reach(room) & set(commands)):
                    own = sorted((SOURCE / "src" / other).glob("*/*.hpp"))
                    if not own:
                        continue
                    header = own[0].relative_to(SOURCE / "src").as_posix()
                    with self.subTest(room=room, includes=header):
                        probe.write_text(f'#include "{header}"\n')
                        done = subprocess.run([*command, probe], cwd=BUILD, capture_output=True, text=True)
                        self.assertEqual(done.returncode == 0, room == other, done.stderr)
                        probed += room != other
        self.assertGreaterEqual(probed, 6)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
