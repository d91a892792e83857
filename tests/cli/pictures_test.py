"""Pictures in place of meshes, contact sheets, and pages about conversions."""

import base64
import html.parser
import json
import math
import re
import shutil

from support import SPHERE, Png, ProgramTest, main, needs_program

GROUND = (234, 236, 240)  # of a preview


class Page(html.parser.HTMLParser):
    """What a page holds; fails on tags that are not closed."""

    EMPTY = {"meta", "img", "link", "br", "path", "circle", "use"}

    def __init__(self, text):
        super().__init__()
        self.open, self.images, self.rows, self.links, self.words = [], [], 0, [], ""
        self.feed(text)
        assert not self.open, self.open

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.rows += tag == "tr"
        if tag == "img":
            self.images.append(given["src"])
        self.links += [given[name] for name in ("src", "href", "xlink:href") if name in given]
        if tag not in self.EMPTY:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        if tag in self.EMPTY:
            self.handle_starttag(tag, attrs)

    def handle_endtag(self, tag):
        if tag not in self.EMPTY:
            assert self.open and self.open[-1] == tag, (tag, self.open)
            self.open.pop()

    def handle_data(self, data):
        self.words += data


class PicturesTest(ProgramTest):
    def png(self, name):
        return Png((self.folder / name).read_bytes())

    def frames(self, count):
        for frame in range(count):
            size = 0.3 + 0.1 * frame
            self.write_raw(f"f_{frame:02}_20x20x20_f32.raw", (20, 20, 20),
                           lambda x, y, z, size=size: size - ((x - 9.5)**2 + (y - 9.5)**2 + (z - 9.5)**2)**0.5 / 10)
        return "f_{:02}_20x20x20_f32.raw", "--dims", "20x20x20", "--dtype", "f32", "--iso", "0"


class PictureTest(PicturesTest):
    def test_notes_about_mesh_formats_are_not_about_pictures(self):
        run = self.convert(SPHERE, "--iso", "0", "--unit", "mm", "--to-unit", "mm", "-o", "a.png")
        self.assertNotIn("length-unit", run.err)
        self.assertIn("length-unit", self.convert(SPHERE, "--iso", "0", "--unit", "mm", "--to-unit", "mm", "-o", "a.glb").err)

    def test_a_picture_shows_the_surface(self):
        run = self.convert(SPHERE, "--iso", "0", "-o", "ball.png", "--size", "120x90")
        self.assertIn("-> ball.png: ", run.err)
        png = self.png("ball.png")
        self.assertEqual((png.width, png.height), (120, 90))
        for x, y in ((0, 0), (119, 0), (119, 89)):
            for found, expected in zip(png.pixel(x, y), GROUND):
                self.assertAlmostEqual(found, expected, delta=3)
        covered = sum(max(abs(a - b) for a, b in zip(p, GROUND)) > 12 for p in png.pixels())
        # A ball that is framed by the sphere around its box, of 3^0.5 times its radius.
        self.assertAlmostEqual(covered / (3.1416 * (45 / 3**0.5)**2), 1, delta=0.35)
        bright, dark = png.pixel(52, 35), png.pixel(68, 62)
        self.assertGreater(sum(bright), sum(dark) + 60)

    def test_the_same_picture_for_any_number_of_threads(self):
        for threads in ("1", "2"):
            self.convert(SPHERE, "--iso", "0", "-o", f"{threads}.png", "--size", "64x48", "--threads", threads)
        self.assertEqual((self.folder / "1.png").read_bytes(), (self.folder / "2.png").read_bytes())

    def test_the_camera_goes_round(self):
        self.write_raw("slab.raw", (24, 8, 8), lambda x, y, z: 1 if 2 <= x < 22 and 2 <= y < 6 and 2 <= z < 6 else 0, "B")
        widths = {}
        for azimuth in (0, 90):
            self.convert("slab.raw", "--dims", "24x8x8", "--dtype", "u8", "--iso", "0.5", "-o", "a.png", "--size", "80x80",
                         "--camera", f"{azimuth},0")
            png = self.png("a.png")
            seen = [x for x in range(80) for y in range(20, 60) if max(abs(a - b) for a, b in zip(png.pixel(x, y), GROUND)) > 12]
            widths[azimuth] = len(seen)
        # The long side, and then the short one, from so near that either fits.
        self.assertLess(widths[0], 0.6 * widths[90])

    def test_patients_are_seen_from_the_front(self):
        """+y is anterior in RAS and LAS, and posterior in LPS: pictures of the same samples without a space tell."""
        samples = bytes(9 if (x, z) == (3, 3) and y < 6 else 0 for z in range(7) for y in range(8) for x in range(7))
        for space in ("right-anterior-superior", "left-anterior-superior", "left-posterior-superior"):
            head = (f"NRRD0005\ntype: uint8\ndimension: 3\nsizes: 7 8 7\nspace: {space}\nencoding: raw\n"
                    "space directions: (1,0,0) (0,1,0) (0,0,1)\n\n")
            (self.folder / "patient.nrrd").write_bytes(head.encode() + samples)
            (self.folder / "plain.nrrd").write_bytes(head.replace(f"space: {space}", "space dimension: 3").encode() + samples)
            for command in ((), ("render",)):
                pictures = []
                for name, camera in (("patient", 35), ("patient", 10), ("plain", 35), ("plain", 10), ("plain", 215), ("plain", 190)):
                    self.convert(*command, f"{name}.nrrd", "--iso", "4", "-o", "a.png", "--size", "60x40", "--camera", f"{camera},20")
                    pictures.append(self.png("a.png").pixels())
                front = pictures[4:] if "anterior" in space else pictures[2:4]
                self.assertEqual(pictures[:2], front, (space, command))
                self.assertNotEqual(pictures[2:4], pictures[4:])

    def test_patients_are_seen_from_the_front_on_sheets_and_pages(self):
        samples = bytes(9 if (x, z) == (3, 3) and y < 6 else 0 for z in range(7) for y in range(8) for x in range(7))
        for space in ("right-anterior-superior", "left-posterior-superior"):
            head = (f"NRRD0005\ntype: uint8\ndimension: 3\nsizes: 7 8 7\nspace: {space}\nencoding: raw\n"
                    "space directions: (1,0,0) (0,1,0) (0,0,1)\n\n")
            (self.folder / "patient_1.nrrd").write_bytes(head.encode() + samples)
            (self.folder / "plain_1.nrrd").write_bytes(head.replace(f"space: {space}", "space dimension: 3").encode() + samples)
            for mesh in ("a.ply", "a.glb"):
                def drawn(name, azimuth):
                    self.convert(f"{name}_1.nrrd", "--iso", "4", "-o", mesh, "--contact-sheet", "s.png", "--html", "p.html",
                                 "--size", "60x40", "--camera", f"{azimuth},20")
                    image = re.search("data:image/png;base64,([^\"]*)", (self.folder / "p.html").read_text()).group(1)
                    page = Png(base64.b64decode(image))
                    self.assertEqual((page.width, page.height), (60, 40))
                    return self.png("s.png").pixels(), page.pixels()
                front, behind = drawn("plain", 10), drawn("plain", 190)
                self.assertNotEqual(front[1], behind[1])
                self.assertEqual(drawn("patient", 10), behind if "anterior" in space else front, (space, mesh))

    def test_kept_frames_are_seen_from_the_front(self):
        head = ("NRRD0005\ntype: uint8\ndimension: 3\nsizes: 7 8 7\nspace: right-anterior-superior\nencoding: raw\n"
                "space directions: (1,0,0) (0,1,0) (0,0,1)\n\n").encode()
        for frame in (1, 2):
            samples = bytes(9 if (x, z) == (3, 3) and y < 4 + frame else 0 for z in range(7) for y in range(8) for x in range(7))
            (self.folder / f"p_{frame}.nrrd").write_bytes(head + samples)
        arguments = ("p_{}.nrrd", "--iso", "4", "-o", "m_{}.ply", "--resume", "--contact-sheet")
        self.convert(*arguments, "first.png")
        self.assertIn("2 kept", self.convert(*arguments, "kept.png").err)
        self.assertEqual((self.folder / "first.png").read_bytes(), (self.folder / "kept.png").read_bytes())
        self.convert(*arguments, "behind.png", "--camera", "215,20")
        self.assertNotEqual(self.png("first.png").pixels(), self.png("behind.png").pixels())

    def test_one_set_of_view_options(self):
        """The camera, the field of view and the background mean the same in pictures, sheets, pages and render."""
        view = ("--size", "60x44", "--camera", "0,0,9", "--look-at", "0.3,0,0", "--fov", "30", "--background-color", "204080")
        places = {}
        for name, arguments in (("a.png", ("-o", "a.png")), ("s.png", ("-o", "a.ply", "--contact-sheet", "s.png")),
                                ("r.png", ("--tf", "none", "-o", "r.png"))):
            command = ("render",) if name == "r.png" else ()
            self.convert(*command, SPHERE, "--iso", "0", *arguments, *view)
            png = self.png(name)
            left = 4 if name == "s.png" else 0
            self.assertEqual(png.pixel(left + 55, left + 4)[:3], (0x20, 0x40, 0x80), name)
            seen = [x for x in range(60) if max(abs(a - b) for a, b in zip(png.pixel(left + x, left + 18)[:3], (0x20, 0x40, 0x80))) > 12]
            places[name] = (seen[0], seen[-1])
        self.assertAlmostEqual(sum(places["a.png"]) / 2, 29.5 - 0.3 / 9 * 22 / math.tan(math.radians(15)), delta=1)
        for name in ("s.png", "r.png"):
            for found, expected in zip(places[name], places["a.png"]):
                self.assertAlmostEqual(found, expected, delta=1, msg=name)
        self.convert(SPHERE, "--iso", "0", "-o", "w.png", *view[:-4], "--fov", "60")
        wide = self.png("w.png")
        seen = [x for x in range(60) if max(abs(a - b) for a, b in zip(wide.pixel(x, 18), GROUND)) > 12]
        self.assertLess(len(seen), 0.6 * (places["a.png"][1] - places["a.png"][0] + 1))

    def test_the_scale_bar_is_seen_on_black(self):
        for color, expected in (("black", (True, False)), ("white", (False, True)), ("none", (False, True))):
            self.convert(SPHERE, "--iso", "0", "-o", "a.png", "--size", "120x90", "--background-color", color)
            png = self.png("a.png")
            corner = [png.pixel(x, y)[:3] for x in range(4, 30) for y in range(74, 84)]
            # On a transparent background, what is not text has no color.
            bar = png.pixel(9, 81)
            self.assertEqual((min(bar[:3]) > 200, max(bar[:3]) < 60), expected, color)
            if color == "none":
                self.assertEqual((bar[3], png.pixel(119, 0)[3]), (255, 0))
            self.assertGreater(len(set(corner)), 1)

    def moving(self):
        """A ball that goes along x."""
        for frame, at in ((1, 4), (2, 10), (3, 16)):
            self.write_raw(f"m_{frame}.raw", (20, 8, 8), lambda x, y, z, at=at: 2.6 - math.dist((x, y, z), (at, 4, 4)))
        return "m_{}.raw", "--dims", "20x8x8", "--dtype", "f32", "--iso", "0", "--size", "80x60"

    def middle(self, name):
        """Where the surface is in a picture, across it; the scale bar is below."""
        png = self.png(name)
        seen = [x for x in range(80) for y in range(38) if max(abs(a - b) for a, b in zip(png.pixel(x, y), GROUND)) > 12]
        return sum(seen) / len(seen)

    def test_frames_that_are_framed_each_by_itself_are_told(self):
        moving = self.moving()
        note = "note[one-camera]: the camera of each picture looks at the center of its own surfaces, so the pictures do not show how the surfaces move: "
        for more in ((), ("--camera", "0,0"), ("--camera", "0,0,30")):
            run = self.convert(*moving, *more, "-o", "p_{}.png")
            self.assertEqual(run.err.count(note + "for one camera give --camera AZ,EL,DISTANCE and --look-at X,Y,Z\n"), 1, more)
        for name in ("p_1.png", "p_3.png"):
            self.assertAlmostEqual(self.middle(name), 40, delta=4)
        run = self.convert(*moving, "--look-at", "10,4,4", "-o", "p_{}.png")
        self.assertIn("note[one-camera]: the camera of each picture takes its distance from its own surfaces, so the pictures do not show how the surfaces grow", run.err)
        run = self.convert("m_1.raw", *moving[1:], "-o", "one.png")
        self.assertNotIn("note[one-camera]: each picture", run.err)

    def test_one_camera_for_a_sequence(self):
        moving = self.moving()
        run = self.convert(*moving, "--camera", "0,0,30", "--look-at", "10,4,4", "-o", "p_{}.png")
        self.assertNotIn("note[", run.err)
        left, middle, right = (self.middle(f"p_{k}.png") for k in (1, 2, 3))
        self.assertAlmostEqual(middle, 40, delta=2)
        self.assertLess(left, middle - 10)
        self.assertAlmostEqual(right - middle, middle - left, delta=2)

    def test_a_camera_that_sees_nothing_is_told(self):
        away = ("--camera", "0,0,30", "--look-at", "30,4,4")
        run = self.convert(*self.moving(), *away, "-o", "p_{}.png", "--report", "r_{}.json")
        self.assertIn("note[empty-picture]: 2 of 3 frames have an empty picture, because the camera sees nothing of the surfaces: 1-2\n", run.err)
        report = json.loads((self.folder / "r_1.json").read_text())
        self.assertEqual(report["options"]["picture_file"]["look_at"], [30, 4, 4])
        run = self.convert("m_1.raw", *self.moving()[1:], *away, "-o", "one.png")
        self.assertIn("note[empty-picture]: one.png: the picture is empty: no part of the surfaces is in the camera's view\n", run.err)

    def test_colors_of_vertices_are_seen(self):
        self.convert(SPHERE, "--iso", "0", "--color-by", "height=demo:sphere?size=24", "-o", "c.png", "--size", "60x45")
        self.assertEqual(self.convert(SPHERE, "--iso", "0", "--color-by", "iso", "-o", "i.png", "--size", "60x45").code, 0)

    def test_stdout_and_format(self):
        run = self.convert(SPHERE, "--iso", "0", "-o", "-", "--format", "png", "--size", "32x24")
        self.assertEqual(Png(run.out).width, 32)
        self.assertEqual(self.files(), [])

    def test_what_makes_no_sense_is_refused(self):
        for arguments, words in ((("-o", "a.png", "--ascii"), "--ascii applies to mesh files"),
                                 (("-o", "a.png", "--draco"), "--draco applies to mesh files"),
                                 (("-o", "a.glb", "--size", "9x9"), "--size applies to pictures"),
                                 (("-o", "a.glb", "--camera", "1,2"), "--camera applies to pictures"),
                                 (("-o", "a.glb", "--look-at", "1,2,3"), "--look-at applies to pictures"),
                                 (("-o", "a.png", "--size", "0x9"), "--size: expected a width and a height"),
                                 (("-o", "a.png", "--size", "99999x9"), "--size: expected a width and a height"),
                                 (("-o", "a.png", "--camera", "x"), "--camera: expected")):
            self.assert_fails(1, self.run_program(SPHERE, "--iso", "0", *arguments), words)
        self.assertEqual(self.files(), [])

    def test_no_surface_leaves_no_picture(self):
        self.assert_fails(2, self.run_program(SPHERE, "--iso", "99", "-o", "a.png"), "no surface")
        self.assertEqual(self.files(), [])

    def test_frames_become_pictures(self):
        arguments = self.frames(3)
        self.convert(*arguments, "-o", "p_{:02}.png", "--size", "40x30")
        names = [name for name in self.files() if name.startswith("p_")]
        self.assertEqual(names, ["p_00.png", "p_01.png", "p_02.png"])
        before = (self.folder / "p_01.png").stat().st_mtime_ns
        self.convert(*arguments, "-o", "p_{:02}.png", "--size", "40x30", "--resume")
        self.assertEqual((self.folder / "p_01.png").stat().st_mtime_ns, before)


class ContactSheetTest(PicturesTest):
    def test_a_frame_without_a_surface_has_the_same_words_in_every_run(self):
        arguments = (*self.frames(3), "--empty", "skip", "-o", "m_{:02}.ply", "--resume", "--contact-sheet")
        self.write_raw("f_01_20x20x20_f32.raw", (20, 20, 20), lambda x, y, z: -1)
        self.convert(*arguments, "first.png")
        run = self.convert(*arguments, "kept.png")
        self.assertIn("3 kept from an earlier run", run.err)
        self.assertEqual((self.folder / "first.png").read_bytes(), (self.folder / "kept.png").read_bytes())

    def test_frames_are_side_by_side(self):
        self.convert(*self.frames(4), "-o", "m_{:02}.ply", "--contact-sheet", "all.png")
        sheet = self.png("all.png")
        self.assertEqual(sheet.width % 324, 4)
        columns = sheet.width // 324
        covered = []
        for n in range(4):
            x0, y0 = 4 + n % columns * 324, 4 + n // columns * ((sheet.height - 4) // -(-4 // columns))
            part = [sheet.pixel(x0 + x, y0 + y) for y in range(0, 200, 4) for x in range(0, 320, 4)]
            covered.append(sum(max(abs(a - b) for a, b in zip(p, GROUND)) > 12 for p in part))
        # One camera for all: the ball is seen to grow.
        self.assertEqual(covered, sorted(covered))
        self.assertGreater(covered[3], 2 * covered[0])

    def test_what_makes_no_sense_is_refused(self):
        frames = self.frames(2)
        for arguments, words in ((("-o", "m_{:02}.ply", "--contact-sheet", "a.jpg"), "ends in .png"),
                                 (("-o", "m_{:02}.png", "--contact-sheet", "a.png"), "--contact-sheet shows the written meshes"),
                                 (("-o", "m.glb", "--animate", "--contact-sheet", "a.png"), "writes all frames into one file")):
            self.assert_fails(1, self.run_program(*frames, *arguments), words)
        self.assertEqual([name for name in self.files() if not name.endswith(".raw")], [])


class PageTest(PicturesTest):
    def page(self, name):
        text = (self.folder / name).read_text()
        page = Page(text)
        # It needs no other file.
        self.assertEqual([link for link in page.links if not link.startswith(("data:", "#"))], [])
        self.assertNotRegex(text, r"url\((?!#|['\"]?#)")
        return page

    def test_a_page_of_one_conversion(self):
        self.convert(SPHERE, "--iso", "0", "--error", "-o", "a&b.glb", "--html", "page.html")
        page = self.page("page.html")
        self.assertEqual(len(page.images), 1)
        picture = Png(base64.b64decode(page.images[0].removeprefix("data:image/png;base64,")))
        self.assertEqual((picture.width, picture.height), (960, 720))
        for words in ("a&b.glb", "Distances of the meshes", "left out", "Versions", "isoextract"):
            self.assertIn(words, page.words)

    @needs_program("gnuplot")
    def test_a_page_of_a_sequence(self):
        self.convert(*self.frames(3), "-o", "m_{:02}.glb", "--html", "page.html")
        page = self.page("page.html")
        self.assertEqual(len(page.images), 3)
        text = (self.folder / "page.html").read_text()
        self.assertIn("<svg", text)
        for frame in range(3):
            self.assertIn(f"m_{frame:02}.glb", page.words)
        triangles = [int(n) for n in re.findall(r"<td>0</td><td>(\d+)</td>", text)]
        self.assertEqual(len(triangles), 3)
        self.assertEqual(triangles, sorted(triangles))

    def test_long_names_are_not_cut(self):
        name = "an/" * 3 + "input_with_a_long_name_" * 6 + ".raw"
        (self.folder / "an/an/an").mkdir(parents=True)
        self.write_raw("a.raw", (8, 8, 8), lambda x, y, z: x - 2.5).rename(self.folder / name)
        self.convert(name, "--dims", "8x8x8", "--dtype", "f32", "--iso", "0", "-o", "out.ply", "--html", "page.html")
        text = (self.folder / "page.html").read_text()
        self.assertIn(name, text)
        for rule in ("pre{[^}]*white-space:pre-wrap", r"td.words:not\(:first-child\){overflow-wrap:anywhere"):
            self.assertRegex(text, rule)
        for table in re.finditer("<table", text):
            self.assertTrue(text[:table.start()].rstrip().endswith('<div class="scroll">'), text[table.start() - 60:table.start()])

    @needs_program("gnuplot")
    def test_frames_that_failed_are_on_the_page(self):
        arguments = self.frames(3)
        (self.folder / "f_01_20x20x20_f32.raw").write_bytes(b"short")
        run = self.run_program(*arguments, "-o", "m_{:02}.glb", "--html", "page.html")
        self.assertEqual(run.code, 5, run.err)
        page = self.page("page.html")
        self.assertEqual(len(page.images), 3)  # that of the frame that failed says so
        self.assertIn("failed: ", page.words)
        text = (self.folder / "page.html").read_text()
        self.assertEqual(len(re.findall(r"<svg.*?>failed</text>", text, re.DOTALL)), 1)  # in the key of the plot
        self.convert_failing(*arguments, "-o", "n_{:02}.ply", "--contact-sheet", "all.png")
        self.assertGreater(self.ink(self.png("all.png"), 1), 100)  # words where the mesh would be

    def convert_failing(self, *arguments):
        run = self.run_program(*arguments)
        self.assertEqual(run.code, 5, run.err)
        return run

    def ink(self, sheet, n):
        """Dark pixels in the middle of the n-th picture of a sheet."""
        columns = sheet.width // 324
        x0, y0 = 4 + n % columns * 324 + 60, 4 + n // columns * ((sheet.height - 4) // -(-3 // columns)) + 100
        return sum(max(sheet.pixel(x0 + x, y0 + y)) < 60 for y in range(40) for x in range(200))

    def open_frames(self, count):
        """Planes, which leave the data: no mesh is closed."""
        for frame in range(count):
            self.write_raw(f"p_{frame}.raw", (8, 8, 8), lambda x, y, z, frame=frame: x - 2.5 - 0.5 * frame)
        return "p_{}.raw", "--dims", "8x8x8", "--dtype", "f32"

    @needs_program("gnuplot")
    def test_figures_that_no_frame_has(self):
        frames = self.open_frames(3)
        nothing = ">no surface is closed: none has a volume<"
        for name in ("page.html", "plot.svg"):
            option = "--html" if name == "page.html" else "--plot"
            with self.subTest(option):
                self.convert(*frames, "--iso", "0", "-o", "m_{}.ply", option, name)
                self.assertEqual((self.folder / name).read_text().count(nothing), 1)
                skipped = self.convert(*frames, "--iso", "99", "--empty", "skip", "-o", "m_{}.ply", option, name)
                self.assertNotIn("gnuplot", skipped.err)
                for words in (">no frame has a surface<", nothing):
                    self.assertIn(words, (self.folder / name).read_text())
                failed = self.convert_failing(*frames, "--iso", "99", "-o", "m_{}.ply", option, name)
                self.assertNotIn("gnuplot", failed.err)
                self.assertIn(">no frame has a surface<", (self.folder / name).read_text())
                self.assertIn(">failed<", (self.folder / name).read_text())
        self.convert(*frames, "--iso", "0", "-o", "m_{}.ply", "--plot", "plot.png")
        self.assertGreater(self.png("plot.png").width, 800)

    def svg_texts(self, name):
        """Place, size and content of the words of a picture by gnuplot."""
        text = (self.folder / name).read_text()
        found = re.findall(r'<g transform="translate\(([\d.]+),([\d.]+)\)(?: rotate\(([-\d.]+)\))?"[^>]*font-size="([\d.]+)"'
                           r'[^>]*text-anchor="(\w+)"[^>]*>\s*<text>(.*?)</text>', text, re.DOTALL)
        words = []
        for x, y, turn, size, anchor, content in found:
            content = re.sub(r"<.*?>", "", content)
            width, height = 0.6 * float(size) * len(content), float(size)
            x, y = float(x), float(y)
            if turn and float(turn) != 0:
                words.append((content, x - height, y - width / 2, x, y + width / 2))
            else:
                left = {"start": x, "middle": x - width / 2, "end": x - width}[anchor]
                words.append((content, left, y - height, left + width, y))
        return words

    @needs_program("gnuplot")
    def test_words_of_plots_do_not_overlap(self):
        for frame in range(12):
            self.write_raw(f"q_{frame}.raw", (12, 12, 12), lambda x, y, z, frame=frame: 30000 *
                           (5.7 - 0.1 * frame - ((x - 5.5)**2 + (y - 5.5)**2 + (z - 5.5)**2)**0.5))
        self.convert("q_{}.raw", "--dims", "12x12x12", "--dtype", "f32", "--spacing", "1000,1000,1000", "--iso", "0", "--iso",
                     "30000", "--iso", "60000.5", "-o", "m_{}.glb", "--plot", "plot.svg")
        words = self.svg_texts("plot.svg")
        self.assertGreater(len(words), 20)
        self.assertEqual(sum(content == "iso 60000.5" for content, *_ in words), 1)
        for i, (first, *a) in enumerate(words):
            for second, *b in words[:i]:
                apart = a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]
                self.assertTrue(apart, f"{first} at {a} and {second} at {b}")

    def test_names_of_the_page_are_checked(self):
        shutil.copy(self.write_raw("a.raw", (4, 4, 4), lambda x, y, z: x), self.folder / "b.raw")
        for name in ("", "-", "a.raw", "out.glb"):
            run = self.run_program("a.raw", "--dims", "4x4x4", "--dtype", "f32", "--iso", "1.5", "-o", "out.glb", "--html", name)
            self.assertEqual(run.code, 1, run.err)
        self.assertEqual(self.files(), ["a.raw", "b.raw"])


if __name__ == "__main__":
    main()
