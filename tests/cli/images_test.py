"""TIFF, OpenEXR and PNG images: volumes of pages, stacks of files, placement, components, damaged files.

The files are written by tifffile and Pillow; OpenEXR's are those of the test data, and one written here byte by byte.
"""

import json
import struct

from support import DATA, ProgramTest, main, needs_data, needs_modules, read_ply

needs_modules("numpy", "tifffile", "PIL")

import numpy  # noqa: E402
import tifffile  # noqa: E402
from PIL import Image  # noqa: E402


def ball(shape=(9, 12, 14), dtype="u2", radius=3.6):
    """Distances from the middle, [z, y, x], as numbers of the type."""
    z, y, x = numpy.indices(shape)
    middle = [(n - 1) / 2 for n in shape]
    distance = numpy.sqrt((z - middle[0]) ** 2 + (y - middle[1]) ** 2 + (x - middle[2]) ** 2)
    return numpy.maximum(100 + 20 * (radius - distance), 0).astype(dtype)


class ImagesTest(ProgramTest):
    def mesh_bytes(self, name, *options):
        self.convert(name, "--iso", "100", "-o", "out.ply", *options)
        return (self.folder / "out.ply").read_bytes()

    def same_as_npy(self, name, volume, *options):
        """The mesh of the file is that of the same samples in NumPy's format."""
        numpy.save(self.folder / "same.npy", volume)
        self.assertEqual(self.mesh_bytes(name, *options), self.mesh_bytes("same.npy"), name)

    def info(self, *arguments):
        run = self.run_program("info", "--json", *arguments)
        self.assertEqual(run.code, 0, run.err)
        return json.loads(run.out)[0]

    def test_pages_are_slices(self):
        volume = ball()
        cases = {
            "plain.tif": (volume, {}),
            "big.tif": (volume, {"bigtiff": True, "byteorder": ">"}),
            "deflate.tif": (volume, {"compression": "zlib", "predictor": True, "rowsperstrip": 5}),
            "tiles.tif": (volume.astype("f4"), {"tile": (16, 16), "compression": "zlib"}),
            "half.tif": (volume.astype("f2"), {}),
            "double.tif": (volume.astype("f8"), {"compression": "lzma"}),
            "signed.tif": (volume.astype("i4"), {"byteorder": ">"}),
            "byte.tif": (volume.astype("u1"), {"rowsperstrip": 1}),
        }
        for name, (samples, options) in cases.items():
            with self.subTest(name):
                tifffile.imwrite(self.folder / name, samples, photometric="minisblack", metadata=None, **options)
                self.same_as_npy(name, samples)

    def test_compressions_of_another_writer(self):
        volume = ball(dtype="u1")
        pages = [Image.fromarray(page) for page in volume]
        for compression in ("tiff_lzw", "packbits", "tiff_adobe_deflate", "zstd"):
            with self.subTest(compression):
                pages[0].save(self.folder / "c.tif", save_all=True, append_images=pages[1:], compression=compression)
                self.same_as_npy("c.tif", volume)

    def test_imagej_places_and_names_channels(self):
        stack = numpy.stack([ball(), ball(radius=2.5)], axis=1)[numpy.newaxis]  # [t, z, c, y, x]
        stack = numpy.concatenate([stack, stack // 2])
        tifffile.imwrite(self.folder / "ij.tif", stack, imagej=True, resolution=(1 / 0.25, 1 / 0.5),
                         metadata={"axes": "TZCYX", "spacing": 1.5, "unit": "um", "finterval": 2.5})
        found = self.info("ij.tif", "--grid", "channel1", "--volume", "1")
        self.assertEqual(found["field"]["format"], "ImageJ TIFF")
        self.assertEqual([grid["name"] for grid in found["grids"]], ["channel0", "channel1"])
        self.assertEqual(found["grids"][0]["volumes"], 2)
        self.assertEqual(found["field"]["length_unit"], "um")
        numpy.save(self.folder / "one.npy", stack[0, :, 1])
        self.assertEqual(self.mesh_bytes("ij.tif", "--grid", "channel1", "--volume", "0"),
                         self.mesh_bytes("one.npy", "--spacing", "0.25,0.5,1.5"))
        self.assert_fails(2, self.run_program("ij.tif", "--iso", "100", "-o", "x.ply", "--volume", "0"), "channel0",
                          "--grid")

    def test_imagej_calibrates_values(self):
        volume = ball()
        tifffile.imwrite(self.folder / "signed.tif", volume + 32768, metadata=None, photometric="minisblack",
                         description=f"ImageJ=1.53c\nimages={len(volume)}\nslices={len(volume)}\ncf=0\nc0=-32768.0\nc1=1.0\n")
        self.same_as_npy("signed.tif", volume)

    def test_imagej_of_more_than_4_gib_has_one_page(self):
        volume = ball()
        tifffile.imwrite(self.folder / "all.tif", volume[0], metadata=None, byteorder=">",
                         description=f"ImageJ=1.53c\nimages={len(volume)}\nslices={len(volume)}\nunit=pixel\n")
        data = bytearray((self.folder / "all.tif").read_bytes())
        with tifffile.TiffFile(self.folder / "all.tif") as file:
            offset = file.pages[0].dataoffsets[0]
        # The first plane moves to the end, and the others follow it without pages of their own.
            where = file.pages[0].tags["StripOffsets"].valueoffset
        self.assertEqual(struct.unpack_from(">I", data, where)[0], offset)
        struct.pack_into(">I", data, where, len(data))
        data += volume.astype(">u2").tobytes()
        (self.folder / "all.tif").write_bytes(data)
        self.same_as_npy("all.tif", volume)
        (self.folder / "all.tif").write_bytes(data[:-100])
        self.assert_fails(2, self.run_program("all.tif", "--iso", "100", "-o", "x.ply"), "9 planes", "room for 8")

    def test_ome_places_orders_and_names(self):
        volume = ball()
        for axes in ("CTZYX", "TZCYX", "ZCTYX"):
            with self.subTest(axes):
                sizes = {"C": 2, "T": 1, "Z": len(volume)}
                image = numpy.zeros([sizes[axis] for axis in axes[:3]] + list(volume.shape[1:]), "u2")
                place = [0 if axis == "T" else 1 if axis == "C" else slice(None) for axis in axes[:3]]
                image[tuple(place)] = volume
                tifffile.imwrite(self.folder / "a.ome.tif", image, metadata={
                    "axes": axes, "PhysicalSizeX": 0.2, "PhysicalSizeXUnit": "µm", "PhysicalSizeY": 0.3,
                    "PhysicalSizeYUnit": "µm", "PhysicalSizeZ": 900, "PhysicalSizeZUnit": "nm",
                    "Channel": {"Name": ["DAPI", "GFP"]}})
                found = self.info("a.ome.tif", "--grid", "GFP")
                self.assertEqual(found["field"]["format"], "OME-TIFF")
                self.assertEqual(found["field"]["length_unit"], "um")
                numpy.save(self.folder / "one.npy", volume)
                self.assertEqual(self.mesh_bytes("a.ome.tif", "--grid", "GFP"),
                                 self.mesh_bytes("one.npy", "--spacing", "0.2,0.3,0.9"))

    def test_rgb_by_component(self):
        volume = numpy.stack([ball() // 2, ball(), ball() // 3], axis=-1)
        for planar in ("contig", "separate"):
            with self.subTest(planar):
                pages = volume if planar == "contig" else numpy.moveaxis(volume, -1, 1)
                tifffile.imwrite(self.folder / "rgb.tif", pages, photometric="rgb", planarconfig=planar, metadata=None)
                self.same_as_npy("rgb.tif", volume[..., 1], "--component", "1")
                self.assert_fails(2, self.run_program("rgb.tif", "--iso", "9", "-o", "x.ply"), "3 components", "R G B")
                lengths = numpy.sqrt((volume.astype("f8") ** 2).sum(-1)).astype("f4")
                numpy.save(self.folder / "length.npy", lengths)
                self.assertEqual(self.mesh_bytes("rgb.tif", "--component", "length"), self.mesh_bytes("length.npy"))

    def test_geotiff_places_pixels_by_their_middle(self):
        heights = numpy.full((3, 8, 10), 7, "i2")
        heights[:, 2:6, 3:7] = 300
        heights[0, 0, 0] = -32768
        tags = [(33550, "d", 3, (30.0, 20.0, 2.0)), (33922, "d", 6, (0.0, 0.0, 0.0, 440000.0, 3751000.0, 5.0)),
                (34735, "H", 12, (1, 1, 0, 2, 1025, 0, 1, 1, 3076, 0, 1, 9001)), (42113, "s", 0, "-32768")]
        tifffile.imwrite(self.folder / "map.tif", heights, photometric="minisblack", metadata=None, extratags=tags)
        found = self.info("map.tif")
        self.assertEqual(found["field"]["format"], "GeoTIFF")
        self.assertEqual(found["field"]["length_unit"], "m")
        self.assertEqual(found["field"]["values"]["nan"], 1)
        self.convert("map.tif", "--iso", "150", "--nan", "outside", "--cap", "-o", "map.ply")
        mesh = read_ply((self.folder / "map.ply").read_bytes())
        x = [p[0] for p in mesh.vertices]
        y = [p[1] for p in mesh.vertices]
        share = (150 - 7) / (300 - 7)  # of the step from outside to inside, where the value is 150
        self.assertAlmostEqual(min(x), 440000 + 30 * (2 + share + 0.5), delta=0.05)
        self.assertAlmostEqual(max(y), 3751000 - 20 * (1 + share + 0.5), delta=0.3)

    def test_no_data_of_half_floats(self):
        """The tag has the value before it was rounded to a half: -9999 becomes -10000, the least double an infinity."""
        for no_data, stored in (("-9999", -9999), ("-1.7976931348623157e+308", -numpy.inf), ("0.1", 0.1)):
            heights = numpy.arange(3 * 8 * 10).reshape(3, 8, 10).astype("f2")
            heights[1, 2, 3:6] = stored
            tifffile.imwrite(self.folder / "map.tif", heights, photometric="minisblack", metadata=None,
                             extratags=[(42113, "s", 0, no_data)])
            values = self.info("map.tif")["field"]["values"]
            self.assertEqual((values["nan"], values["min"], values["max"]), (3, 0, 239), no_data)

    def test_patterns_and_folders_of_pictures_are_one_volume(self):
        volume = ball(dtype="u1")
        (self.folder / "tif").mkdir()
        (self.folder / "png").mkdir()
        for z, page in enumerate(volume):
            tifffile.imwrite(self.folder / "tif" / f"s{z + 98}.tif", page)
            Image.fromarray(page).save(self.folder / "png" / f"s_{z:03}.png")
        (self.folder / "png" / "notes.txt").write_text("no image")
        for name in ("tif/s{}.tif", "tif", "png/s_###.png", "png", "png/"):
            with self.subTest(name):
                self.same_as_npy(name, volume)
        run = self.convert("png", "--iso", "100", "-o", "x.ply", "--report", "r.json")
        self.assertIn("9 files are the slices of one volume", run.err)
        self.assertEqual(self.info("png")["field"]["box"]["max"], [13, 11, 8])
        # A sequence whose files are volumes stays one.
        tifffile.imwrite(self.folder / "t_1.tif", volume)
        tifffile.imwrite(self.folder / "t_2.tif", volume)
        self.convert("t_{}.tif", "--iso", "100", "-o", "frame_{}.ply")
        self.assertTrue({"frame_1.ply", "frame_2.ply"} <= set(self.files()))

    def test_a_listed_stack_is_one_volume(self):
        """Shells list the files of s_*.png, in the order of characters."""
        volume = ball(dtype="u1")
        (self.folder / "png").mkdir()
        for z, page in enumerate(volume):
            Image.fromarray(page).save(self.folder / "png" / f"s_{z + 5}.png")
        names = sorted(f"png/s_{z + 5}.png" for z in range(len(volume)))
        self.convert("png", "--iso", "100", "-o", "folder.ply")
        run = self.convert(*names, "--iso", "100", "-o", "list.ply")
        self.assertIn("9 files are the slices of one volume", run.err)
        self.assertEqual((self.folder / "list.ply").read_bytes(), (self.folder / "folder.ply").read_bytes())
        self.assertEqual(self.info(*names)["field"]["box"]["max"], [13, 11, 8])
        # A slice alone has no surface, so a part of the stack, or the stack with an option for frames, is refused.
        for more in (names[:4], [*names, "--frames", "5-13"]):
            run = self.run_program(*more, "--iso", "100", "-o", "frame_{}.ply")
            self.assert_fails(1, run, "expected volumes as frames, found slices of the one volume png/s_{}.png",
                              "give the pattern 'png/s_{}.png', in quotes")
        self.assertEqual([name for name in self.files() if "manifest" in name], [])

    def test_stacks_tell_what_is_missing_or_differs(self):
        volume = ball(dtype="u1")
        for z, page in enumerate(volume):
            Image.fromarray(page).save(self.folder / f"s_{z:03}.png")
        (self.folder / "s_004.png").unlink()
        run = self.run_program("s_{:03}.png", "--iso", "100", "-o", "x.ply")
        self.assert_fails(2, run, "every slice from 0 to 8", "none for 4")
        Image.fromarray(volume[4][:5]).save(self.folder / "s_004.png")
        run = self.run_program("s_{:03}.png", "--iso", "100", "-o", "x.ply")
        self.assert_fails(2, run, "s_004.png", "14 x 12 uint8", "14 x 5 uint8")
        (self.folder / "s_004.png").write_bytes((self.folder / "s_003.png").read_bytes()[:60])
        self.assert_fails(2, self.run_program("s_{:03}.png", "--iso", "100", "-o", "x.ply"), "s_004.png")
        self.assertNotIn("x.ply", self.files())

    def test_pictures_beside_volumes_are_left_alone(self):
        for k in (1, 2):
            numpy.save(self.folder / f"f_{k}.npy", ball())
            Image.fromarray(ball(dtype="u1")[4]).save(self.folder / f"preview_{k}.png")
        (self.folder / "out").mkdir()
        run = self.convert(self.folder, "--iso", "100", "-o", "out/f_{}.ply")
        self.assertEqual(sorted(path.name for path in (self.folder / "out").glob("*.ply")), ["f_1.ply", "f_2.ply"])
        self.assertIn("the program takes 2 volume files (such as f_1.npy) and skips 2 pictures (such as preview_1.png)", run.err)
        (self.folder / "notes.txt").write_text("notes")
        run = self.convert(self.folder, "--iso", "100", "-o", "out/g_{}.ply")
        self.assertIn("skips 2 pictures (such as preview_1.png) and 1 other file (notes.txt)", run.err)

    @needs_data("exr/headmr_stack/slice_0000.exr")
    def test_exr_stack_gives_the_mesh_of_the_same_raw_volume(self):
        self.convert(DATA / "exr/headmr_stack/slice_{:04}.exr", "--iso", "60", "-o", "exr.ply", "--report", "r.json")
        self.convert(DATA / "med/HeadMRVolume.raw", "--dims", "48,62,42", "--iso", "60", "-o", "raw.ply")
        self.assertEqual((self.folder / "exr.ply").read_bytes(), (self.folder / "raw.ply").read_bytes())
        notes = " ".join(note["text"] for note in json.loads((self.folder / "r.json").read_text())["notes"])
        self.assertIn("R, G and B are equal", notes)
        self.assertIn("42 files are the slices", notes)

    @needs_data("exr/beachball.0001.exr")
    def test_exr_channels_are_grids_placed_by_the_data_window(self):
        found = self.info(DATA / "exr/beachball.0001.exr", "--grid", "Z")
        self.assertEqual(len(found["grids"]), 20)
        self.assertIn("left.Z", [grid["name"] for grid in found["grids"]])
        self.assertEqual(found["field"]["box"]["max"], [910, 875, 0])
        self.assertEqual([row[3] for row in found["field"]["index_to_world"]][:2], [654, 245])
        rings = self.info(DATA / "exr/BrightRingsNanInf.exr", "--grid", "R")
        self.assertEqual([grid["name"] for grid in rings["grids"]], ["B", "G", "R"])
        self.assertEqual(rings["field"]["values"]["nan"], 2)

    def test_deep_exr_is_refused_with_a_sentence(self):
        def text(value):
            return value.encode() + b"\0"

        def attribute(name, kind, value):
            return text(name) + text(kind) + struct.pack("<I", len(value)) + value

        channels = text("Z") + struct.pack("<iB3xii", 2, 0, 1, 1) + b"\0"
        box = struct.pack("<4i", 0, 0, 7, 7)
        header = b"".join([
            struct.pack("<II", 20000630, 2 | 0x800), attribute("channels", "chlist", channels),
            attribute("compression", "compression", b"\0"), attribute("dataWindow", "box2i", box),
            attribute("displayWindow", "box2i", box), attribute("lineOrder", "lineOrder", b"\0"),
            attribute("pixelAspectRatio", "float", struct.pack("<f", 1)),
            attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)),
            attribute("screenWindowWidth", "float", struct.pack("<f", 1)),
            attribute("type", "string", b"deepscanline"), attribute("version", "int", struct.pack("<i", 1)),
            attribute("chunkCount", "int", struct.pack("<i", 8)), b"\0"])
        (self.folder / "deep.exr").write_bytes(header + bytes(64))
        self.assert_fails(2, self.run_program("info", "deep.exr"), "deep image")

    def test_png_samples(self):
        gray = ball()[4]
        Image.fromarray(gray.astype("u2")).save(self.folder / "wide.png")
        found = self.info("wide.png")
        self.assertEqual((found["field"]["format"], found["field"]["box"]["max"]), ("PNG", [13, 11, 0]))
        self.assertEqual(found["field"]["values"]["max"], gray.max())
        palette = Image.fromarray((gray % 5).astype("u1"), "P")
        palette.putpalette([7 * i % 256 for i in range(768)])
        palette.save(self.folder / "p.png")
        self.assertEqual(self.info("p.png")["field"]["values"]["max"], (gray % 5).max())

    def test_cut_files_are_errors(self):
        tifffile.imwrite(self.folder / "whole.tif", ball(), compression="zlib", metadata={"axes": "ZYX"})
        pages = (self.folder / "whole.tif").read_bytes()
        Image.fromarray(ball(dtype="u1")[4]).save(self.folder / "whole.png")
        png = (self.folder / "whole.png").read_bytes()
        for name, data, step in (("cut.tif", pages, 97), ("cut.png", png[:-16], 31)):
            for length in range(9, len(data) - 1, step):
                (self.folder / name).write_bytes(data[:length])
                run = self.run_program("info", name)
                self.assertEqual(run.code, 2, f"{name} of {length} bytes: {run.err}{run.out}")
                self.assertIn(name, run.err)

    def test_sizes_beyond_the_file_are_refused(self):
        tifffile.imwrite(self.folder / "a.tif", ball()[0], metadata=None)
        data = bytearray((self.folder / "a.tif").read_bytes())
        with tifffile.TiffFile(self.folder / "a.tif") as file:
            tag = file.pages[0].tags["ImageLength"]
        struct.pack_into("<H", data, tag.valueoffset, 60000)
        (self.folder / "a.tif").write_bytes(data)
        self.assert_fails(2, self.run_program("info", "a.tif"), "a.tif", "bytes of samples, but the file has")


if __name__ == "__main__":
    main()
