"""Names that a terminal would obey, in every command: in its text, its messages, its hints and its JSON."""

import json
import re
import struct

from support import SPHERE, ProgramTest, main

# An escape sequence, a line that looks like a message, DEL, a C1 control, a line separator, a change of direction; and
# what shells and gnuplot read.
NAME = "a\x1b[31m\nisoextract: error: forged\x7f\u009b2J\u2028\u202e'$(touch pwned)\"b"
RAW = ("--dims", "6x6x6", "--dtype", "f32")
NOT_SHOWN = re.compile("[\x00-\x09\x0b-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069]")


class HostileNamesTest(ProgramTest):
    def setUp(self):
        super().setUp()
        values = [2.2 - ((x - 2.5)**2 + (y - 2.5)**2 + (z - 2.5)**2)**0.5 for z in range(6) for y in range(6) for x in range(6)]
        self.volume = struct.pack("<216f", *values)
        (self.folder / f"{NAME}.raw").write_bytes(self.volume)

    def try_command(self, *arguments):
        """Whatever comes of it, nothing that is shown is obeyed, and no line is one of the name's."""
        run = self.run_program(*arguments)
        self.assertGreaterEqual(run.code, 0, arguments)
        for name, text in (("stdout", run.text), ("stderr", run.err)):
            found = NOT_SHOWN.search(text)
            self.assertIsNone(found, f"{arguments}: {name} has {found and found.group()!r}:\n{text!r}")
            self.assertNotRegex(text, "(?m)^isoextract: error: forged", f"{arguments}: {name}")
        return run

    def done(self, *arguments):
        run = self.try_command(*arguments)
        self.assertEqual(run.code, 0, f"{arguments}: {run.err}")
        return run

    def failed(self, *arguments):
        run = self.try_command(*arguments)
        self.assertNotEqual(run.code, 0, arguments)
        return run

    def check_json(self, text, has_name=True):
        """A document that names the file as it is, and shows nothing of it."""
        self.assertIsNone(NOT_SHOWN.search(text), text)
        if has_name:
            self.assertIn(NAME, self.strings_of(json.loads(text)))

    def strings_of(self, value):
        if isinstance(value, dict):
            return "\0".join([*value, *(self.strings_of(part) for part in value.values())])
        if isinstance(value, list):
            return "\0".join(self.strings_of(part) for part in value)
        return value if isinstance(value, str) else ""

    def convert_all(self):
        raw = f"{NAME}.raw"
        for form in ("glb", "gltf", "ply", "obj", "stl", "drc"):
            self.done(raw, *RAW, "--iso", "0", "-o", f"{NAME}.{form}", "--explain", "--report", f"{NAME}.json", "--error")
            self.check_json((self.folder / f"{NAME}.json").read_text())
        self.done(raw, *RAW, "--iso", "0", "-o", f"{NAME}.glb", "--verbose")

    def test_convert(self):
        raw = f"{NAME}.raw"
        self.convert_all()
        self.check_json((self.folder / f"{NAME}.gltf").read_text())
        self.done(raw, *RAW, "--iso", "0", "-o", f"{NAME}.png", "--size", "32x32")
        self.done(raw, *RAW, "--iso", "0", "-o", f"{NAME}.ply", "--html", f"{NAME}.html", "--contact-sheet", f"{NAME}_sheet.png")
        self.assertIsNone(NOT_SHOWN.search((self.folder / f"{NAME}.html").read_text().replace("\t", "")))
        self.done(raw, *RAW, "--iso", "0", "--iso", "99", "--empty", "skip", "-o", f"{NAME}.glb")
        for arguments in ((f"{NAME}.nrrd", "--iso", "0"), (NAME, "--iso", "0"), (raw, "--iso", "0"), (raw, *RAW),
                          (raw, *RAW, "--iso", "99"), (raw, *RAW, "--iso", "0", "--iso", "1", "-o", "a.ply"),
                          (raw, *RAW, "--iso", "0", "--iso", "1", "--format", "ply"),
                          (raw, *RAW, "--iso", "0", "--split-components", "--format", "ply"), (raw, *RAW, "--iso", NAME),
                          (raw, *RAW, "--iso", "0", "-o", NAME), (raw, *RAW, "--iso", "0", "-o", f"{NAME}/a.ply"),
                          (raw, *RAW, "--iso", "0", "-o", f"/nowhere/{NAME}.ply"), (raw, *RAW, "--iso", "0", f"-o={NAME}.ply"),
                          (raw, *RAW, "--iso", "0", "--format", NAME), (raw, *RAW, "--iso", "0", "--report", raw),
                          (raw, *RAW, "--iso", "0", "--html", raw), (raw, *RAW, "--iso", "0", "--grid", NAME),
                          (raw, *RAW, "--iso", "0", "--attribute", NAME), (raw, *RAW, "--iso", "0", "--attribute", f"a={NAME}.npy"),
                          (raw, *RAW, "--iso", "0", "--color-by", NAME), (raw, *RAW, "--iso", "0", "--color-by", f"{NAME}:{NAME}"),
                          (raw, *RAW, "--labels", "1", "--label-names", f"{NAME}.txt"), (raw, *RAW, "--iso", "0", "--roi", NAME),
                          (raw, *RAW, "--iso", "0", f"--{NAME}"), (raw, *RAW, "--iso", "0", "--", f"--iso={NAME}"),
                          (raw, f"{NAME}.ply", *RAW, "--iso", "0"), (f"--{NAME}",), (f"-{NAME}",), ("demo:" + NAME, "--iso", "0"),
                          (SPHERE, "--iso", "0", "--config", f"{NAME}.toml"), (raw, *RAW, "--iso", "0", "--device", NAME),
                          (raw, *RAW, "--iso", "0", "--backend", "gpu", "--device", NAME)):
            self.failed(*arguments)
        for text in ("iso = [", f'"{NAME}" = 1'.replace("\n", "\\n").replace("\x1b", "\\u001b").replace("\x7f", "\\u007f"),
                     'input-format = "what"'):
            (self.folder / f"{NAME}.toml").write_text(text)
            self.failed(SPHERE, "--iso", "0", "--config", f"{NAME}.toml")

    def test_sequences(self):
        folder = self.folder / NAME
        folder.mkdir()
        for frame in range(3):
            (folder / f"{NAME}_{frame}.raw").write_bytes(self.volume if frame != 1 else b"short")
        pattern = f"{NAME}/{NAME}_{{}}.raw"
        run = self.done(pattern, *RAW, "--iso", "0", "-o", f"{NAME}/o_{{}}.ply", "--dry-run")
        self.assertIn(r"manifest: a\x1b[31m\nisoextract: error: forged\x7f\u009b2J\u2028\u202e'$(touch pwned)" + '"b/', run.text)
        besides = ("--table", f"{NAME}.json", "--html", f"{NAME}.html", "--plot", f"{NAME}.svg", "--report", f"{NAME}_{{}}.json")
        self.failed(pattern, *RAW, "--iso", "0", "-o", f"{NAME}/o_{{}}.ply", *besides)
        for name in (f"{NAME}.json", f"{NAME}_0.json", f"{NAME}_1.json"):
            self.check_json((self.folder / name).read_text())
        for name in (f"{NAME}.html", f"{NAME}.svg"):
            self.assertIsNone(NOT_SHOWN.search((self.folder / name).read_text().replace("\t", "")), name)
        self.assertIsNone(NOT_SHOWN.search((folder / "isoextract.manifest").read_text()))
        run = self.failed(pattern, *RAW, "--iso", "0", "-o", f"{NAME}/o_{{}}.ply", "--progress", "json", "--verbose")
        for line in run.err.splitlines():
            if line.startswith("{"):
                self.check_json(line, has_name="input" in json.loads(line))
        self.failed(pattern, *RAW, "--iso", "0", "-o", f"{NAME}/o_{{}}.ply", "--resume")
        self.failed(pattern, *RAW, "--iso", "0", "-o", f"{NAME}.glb", "--animate")
        (folder / f"{NAME}_1.raw").write_bytes(self.volume)
        self.done(pattern, *RAW, "--iso", "0", "-o", f"{NAME}.glb", "--animate")
        (folder / "other.nrrd").write_bytes(b"NRRD")
        (folder / "notes.txt").write_text("")
        for arguments in ((NAME, "--iso", "0"), (f"{NAME}/", "--iso", "0", "-o", "a.ply"), (f"{NAME}/none_{{}}.raw", "--iso", "0"),
                          (pattern, *RAW, "--iso", "0", "--frames", NAME), (pattern, *RAW, "--iso", "0", "-o", f"{NAME}.ply"),
                          (pattern, *RAW, "--iso", "0", "-o", "{" + NAME + "}.ply"), (f"{NAME}/*.raw", "--iso", "0"),
                          (pattern, *RAW, "--iso-table", f"{NAME}.csv", "-o", "a_{}.ply"), ("info", NAME), ("verify", NAME, "--iso", "0"),
                          ("check", NAME), ("compare", NAME, NAME), ("render", NAME, "-o", "a.png"), ("bench", NAME, "--iso", "0"),
                          ("merge", NAME), ("merge", f"{NAME}/none")):
            self.try_command(*arguments)

    def test_other_commands(self):
        self.convert_all()
        raw = f"{NAME}.raw"
        self.done("info", raw, *RAW)
        self.check_json(self.done("info", raw, *RAW, "--json").text)
        for form in ("glb", "ply", "stl"):
            mesh = f"{NAME}.{form}"
            self.done("verify", raw, *RAW, "--iso", "0", mesh)
            self.failed("verify", raw, *RAW, "--iso", "0.5", mesh, "--json")
            self.failed("verify", raw, *RAW, "--iso", "0.5", mesh)
            self.done("compare", mesh, f"{NAME}.obj", "--verbose")
            self.check_json(self.done("compare", mesh, f"{NAME}.obj", "--json").text)
            self.failed("compare", mesh, f"{NAME}.obj", "--max-distance", "-1")
            self.done("check", mesh, "--require", "printable", "--weld")
            self.check_json(self.done("check", mesh, "--json", "--report", f"{NAME}.json").text)
            self.check_json((self.folder / f"{NAME}.json").read_text())
            self.done("render", mesh, "-o", f"{NAME}.png", "--size", "32x32", "--json", f"{NAME}.json", "--backend", "cpu", "--verbose")
            self.check_json((self.folder / f"{NAME}.json").read_text())
        (self.folder / f"{NAME}.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        self.done("compare", f"{NAME}.obj", f"{NAME}.glb")
        self.failed("compare", f"{NAME}.obj", f"{NAME}.glb", "--max-distance", "0")
        self.failed("check", f"{NAME}.obj", "--require", "closed,manifold")
        self.done("render", raw, *RAW, "--iso", "0", "-o", f"{NAME}.png", "--size", "32x32", "--backend", "cpu")
        self.done("bench", raw, *RAW, "--iso", "0", "--repeats", "1", "--csv", f"{NAME}.csv", "--json", f"{NAME}.json",
                  "--backends", "cpu", "--threads", "1")
        self.check_json((self.folder / f"{NAME}.json").read_text())
        self.done("simulate", "water", "--size", "8x8", "--steps", "10", "-o", f"{NAME}_{{}}.nrrd")
        self.done("simulate", "jet", "--count", "40", "--frames", "2", "-o", f"{NAME}_{{}}.ply")
        missing = f"{NAME}.none"
        for arguments in (("info", missing), ("info", missing, "--json"), ("verify", raw, *RAW, "--iso", "0", missing),
                          ("verify", missing, "--iso", "0", f"{NAME}.ply"), ("verify", f"{NAME}.ply", raw, "--iso", "0"),
                          ("compare", missing, f"{NAME}.ply"), ("compare", raw, f"{NAME}.ply"), ("check", missing), ("check", raw),
                          ("check", f"{NAME}.ply", "--require", NAME), ("check", f"{NAME}.ply", "--report", f"{NAME}.ply"),
                          ("check", f"{NAME}.ply", missing), ("render", missing, "-o", "a.png"),
                          ("render", f"{NAME}.ply", "-o", missing), ("render", raw, *RAW, "--tf", missing, "-o", "a.png"),
                          ("bench", missing, "--iso", "0"), ("bench", raw, *RAW), ("bench", raw, *RAW, "--iso", "0", "--plot", missing),
                          ("bench", f"{NAME}.glb", "--iso", "0"), ("stability", "--cases", NAME), ("simulate", NAME),
                          ("simulate", "water", "-o", missing), ("simulate", "jet", "-o", missing), ("merge", missing),
                          ("help", NAME), ("generate", NAME), ("devices", NAME), ("formats", NAME), (NAME, SPHERE, "--iso", "0"),
                          ("infoo" + NAME, raw), ("info", raw, f"--{NAME}"), ("check", f"--{NAME}=1"), ("render", "--size", NAME)):
            self.try_command(*arguments)
        self.assertNotIn("pwned", self.files())


if __name__ == "__main__":
    main()
