"""Tables as spreadsheets write them: semicolons, decimal commas, byte order marks, a line that tells the separator."""

import json

from support import ProgramTest, main

POINTS = [(0.5 * (i % 3), 0.5 * (i // 3 % 3), 0.5 * (i // 9)) for i in range(27)]


class SpreadsheetsTest(ProgramTest):
    def write(self, name, text):
        (self.folder / name).write_bytes(text.encode())

    def write_frames(self, numbers):
        for number in numbers:
            samples = bytearray(216)
            samples[86] = 100 + number
            (self.folder / f"in_{number:03}.raw").write_bytes(bytes(samples))

    def test_iso_values(self):
        self.write_frames((1, 2))
        frames = ("in_{:03}.raw", "--dims", "6,6,6", "-o", "{}_{iso}.ply", "--iso-table", "iso.csv")
        for text in ("frame;iso\r\n1;50,5\r\n2;60,25\r\n", "\ufeffsep=;\r\nframe;iso\r\n1;50,5\r\n2;60,25\r\n", "frame\tiso\n1\t50,5\n2\t60,25\n",
                     "frame,iso\n1,50.5\n2,60.25\n", "frame;iso;of\n1;50.5;a,b\n2;60.25;c\n", "sep=,\nframe,iso\n1,50.5\n2,60.25\n"):
            self.write("iso.csv", text)
            self.convert(*frames)
            for name in ("1_50.5.ply", "2_60.25.ply"):
                (self.folder / name).unlink()
        # What may be a thousands separator is no decimal mark.
        for text, found in (("frame;iso\n1;50,5\n2;60.25\n", "iso.csv:3: expected an iso value with the decimal mark ','"), ("frame;iso\n1;1.050,5\n", "found '1.050,5'"),
                            ("frame;iso\n1;1,050.5\n", "found '1,050.5'"), ("frame,iso\n1,50,5\n", "expected 2 fields")):
            self.write("iso.csv", text)
            self.assert_fails(2, self.run_program(*frames), found)

    def test_particles(self):
        points = [tuple(f"{value:g}" for value in point) for point in POINTS]
        commas = [tuple(value.replace(".", ",") for value in point) for point in points]
        self.write("point.csv", "x,y,z\n" + "".join(",".join(point) + "\n" for point in points))
        self.convert("point.csv", "--radius", "0.4", "-o", "point.ply")
        for number, text in enumerate(("x;y;z\r\n" + "".join(";".join(point) + "\r\n" for point in commas),
                                       "\ufeffsep=;\r\nx;y;z\r\n" + "".join(";".join(point) + "\r\n" for point in commas),
                                       "x\ty\tz\n" + "".join("\t".join(point) + "\n" for point in commas),
                                       "x;y;z;name\n" + "".join(";".join(point) + ";a,b\n" for point in commas),
                                       "".join(";".join(point) + "\n" for point in commas))):
            self.write("comma.csv", text)
            run = self.convert("comma.csv", "--radius", "0.4", "-o", f"{number}.ply")
            self.assertIn("note[decimal-commas]: the numbers of the table have decimal commas, not points", run.err)
            self.assertEqual((self.folder / f"{number}.ply").read_bytes(), (self.folder / "point.ply").read_bytes(), text)
            self.assertIn("27", self.convert("info", "comma.csv").text)
        self.write("point.csv", "x;y;z;name\n" + "".join(";".join(point) + ";a,b\n" for point in points))
        run = self.convert("point.csv", "--radius", "0.4", "-o", "text.ply")
        self.assertNotIn("commas", run.err)
        self.assertEqual((self.folder / "text.ply").read_bytes(), (self.folder / "point.ply").read_bytes())

    def test_headers_of_houdini(self):
        """Components behind a point, nothing or in brackets; semicolons and decimal commas."""
        points = [tuple(f"{value:g}" for value in point) for point in POINTS]
        self.write("plain.csv", "x,y,z\n" + "".join(",".join(point) + "\n" for point in points))
        self.convert("plain.csv", "--radius", "0.4", "-o", "plain.ply")
        for number, names in enumerate((("P.x", "P.y", "P.z", "Cd.r", "Cd.g", "Cd.b"), ("Px", "Py", "Pz", "Cd[r]", "Cd[g]", "Cd[b]"),
                                        ("P[x]", "P[y]", "P[z]", "Cd_r", "Cd_g", "Cd_b"))):
            for separator in (",", ";"):
                rows = [separator.join((*point, "0.25", "0.5", "1")) for point in points]
                if separator == ";":
                    rows = [row.replace(".", ",") for row in rows]
                self.write("h.csv", "\n".join((separator.join(names), *rows)) + "\n")
                self.convert("h.csv", "--radius", "0.4", "-o", f"{number}.ply")
                self.assertEqual((self.folder / f"{number}.ply").read_bytes(), (self.folder / "plain.ply").read_bytes(), names)
                (attribute,) = json.loads(self.convert("info", "h.csv", "--json").text)[0]["particles"]["attributes"]
                self.assertEqual((attribute["name"], attribute["components"]), ("Cd", 3))
        self.write("h.csv", "P.x;P.y;P.z;m\n1.000,5;0;0;1\n")
        self.assert_fails(2, self.run_program("h.csv", "--radius", "0.4", "-o", "h.ply"), "line 2: expected a number as 'P.x', found '1.000,5'")

    def test_particles_with_two_decimal_marks(self):
        for rows, found in (("0,5;0;0\n1.5;0;0\n", "line 3: expected a number as 'x', with the same decimal mark as the numbers before"),
                            ("0,5;0;0\n1.250,5;0;0\n", "line 3: expected a number as 'x'"), ("0.5;0;0\n0;1,5;0\n", "line 3: expected a number as 'y'")):
            self.write("mixed.csv", "x;y;z\n" + rows)
            self.assert_fails(2, self.run_program("mixed.csv", "--radius", "0.4", "-o", "m.ply"), found)


if __name__ == "__main__":
    main()
