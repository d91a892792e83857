"""Raw files of several volumes and components, and the headers that lie beside them."""

import json
import math
import struct

from support import ProgramTest, main, read_ply

DIMS = (13, 12, 11)
COUNT = math.prod(DIMS)


def ball(i, j, k, c=0, v=0):
    """A ball whose radius tells the component and the volume."""
    return 3 + 0.25 * c + 0.5 * v - math.dist((i, j, k), (6, 5.5, 5))


def values(components=1, volumes=1, planar=False):
    index = [(i, j, k) for k in range(DIMS[2]) for j in range(DIMS[1]) for i in range(DIMS[0])]
    if planar:
        return [ball(*at, c, v) for v in range(volumes) for c in range(components) for at in index]
    return [ball(*at, c, v) for v in range(volumes) for at in index for c in range(components)]


def packed(numbers, code="<f"):
    return struct.pack(f"{code[0]}{len(numbers)}{code[1:]}", *numbers)


class RawTest(ProgramTest):
    def write(self, name, data):
        (self.folder / name).write_bytes(data if isinstance(data, bytes) else data.encode())

    def bounds(self, *arguments):
        self.convert(*arguments, "--iso", "0", "-o", "o.ply", "--report", "r.json")
        return read_ply((self.folder / "o.ply").read_bytes()).bounds()

    def assert_ball(self, c, v, *arguments, spacing=(1, 1, 1)):
        low, high = self.bounds(*arguments)
        for axis, center in enumerate((6, 5.5, 5)):
            wide = (high[axis] - low[axis]) / spacing[axis]
            # Linear interpolation between samples makes balls a little narrower.
            self.assertAlmostEqual(wide, 2 * (3 + 0.25 * c + 0.5 * v), delta=0.12)
            self.assertAlmostEqual((high[axis] + low[axis]) / 2 / spacing[axis], center, delta=0.05)


class SeveralTest(RawTest):
    LAYOUT = ("--dims", "{},{},{}".format(*DIMS), "--dtype", "f32")

    def test_components_and_volumes_in_both_orders(self):
        for planar in (False, True):
            self.write("a.raw", packed(values(3, 2, planar)))
            order = ("--planar",) if planar else ()
            for c in range(3):
                for v in range(2):
                    self.assert_ball(c, v, "a.raw", *self.LAYOUT, "--components", "3", *order, "--component", c, "--volume", v)
        raw = json.loads((self.folder / "r.json").read_text())["options"]["raw"]
        self.assertEqual((raw["components"], raw["planar"]), (3, True))

    def test_all_volumes(self):
        self.write("a.raw", packed(values(1, 3)))
        self.convert("a.raw", *self.LAYOUT, "--volume", "all", "--iso", "0", "-o", "o_{}.ply")
        self.assertEqual([n for n in self.files() if n.startswith("o_")], ["o_0.ply", "o_1.ply", "o_2.ply"])

    def test_what_is_refused(self):
        self.write("a.raw", packed(values(3)))
        convert = lambda *more: self.run_program("a.raw", *self.LAYOUT, "--iso", "0", "-o", "no.ply", *more)  # noqa: E731
        self.assert_fails(2, convert("--components", "3"), "found 3 components", "--component K")
        self.assert_fails(2, convert("--components", "2"), "of 2 components")
        self.assert_fails(1, convert("--planar"), "--planar needs samples of several components", "--components N")
        self.assert_fails(1, convert("--components", "0"), "a whole number from 1 to 64")
        self.assert_fails(1, self.run_program("a.raw", "--components", "3", "--iso", "0"), "--components describes a raw file")


class HeaderTest(RawTest):
    def test_volvis(self):
        self.write("eng.raw", struct.pack(f">{COUNT}H", *(round(1000 + 100 * n) for n in values())))
        self.write("eng.dat", "ObjectFileName:\teng.raw\r\nTaggedFileName: ---\nResolution:     13 12 11\n"
                   "SliceThickness: 1 0.5 2\nFormat:         USHORT\nNbrTags:        0\nObjectType:     TEXTURE_VOLUME_OBJECT\n"
                   "ObjectModel:    I\nGridType:       EQUIDISTANT\nEndianess: BIG\n")
        self.convert("eng.dat", "--iso", "1000", "-o", "o.ply")
        low, high = read_ply((self.folder / "o.ply").read_bytes()).bounds()
        for axis, spacing in enumerate((1, 0.5, 2)):
            self.assertAlmostEqual((high[axis] - low[axis]) / spacing, 6, delta=0.12)
        info = json.loads(self.convert("info", "eng.dat", "--json").text)[0]["field"]
        self.assertEqual((info["type"], info["spacing"]), ("u16", [1, 0.5, 2]))

    def test_colors_and_vectors(self):
        self.write("c.raw", packed(values(4)))
        self.write("c.dat", "ObjectFileName: c.raw\nResolution: 13 12 11\nFormat: FLOAT\nObjectModel: RGBA\n")
        self.assert_ball(3, 0, "c.dat", "--component", "3")
        self.write("v.raw", b"12345" + packed(values(3, 2)))
        self.write("v.dat", "Rawfile: v.raw\nResolution: 13 12 11\nFormat: Vec3FLOAT32\nByteOffset: 5\n"
                   "BasisVector1: 26 0 0\nBasisVector2: 0 24 0\nBasisVector3: 0 0 22\nOffset: -1 -1 -1\n")
        self.assert_ball(2, 1, "v.dat", "--component", "2", "--volume", "1", spacing=(2, 2, 2))

    def test_ini(self):
        self.write("m.raw", b"head" + packed(values()))
        self.write("m.raw.ini", "dimx:13\ndimy:12\ndimz:11\nskip:4\nformat:float32\nendianness:little")
        self.assert_ball(0, 0, "m.raw.ini")

    def test_damaged_headers(self):
        self.write("e.raw", packed(values()))
        good = "ObjectFileName: e.raw\nResolution: 13 12 11\nFormat: FLOAT\n"
        self.write("e.dat", good)
        self.assert_ball(0, 0, "e.dat")
        for old, new, said in (("13 12 11", "13 12", "expected three numbers from 1 on as 'Resolution', found '13 12'"),
                               ("13 12 11", "13 0 11", "three numbers from 1 on"), ("FLOAT", "STRING", "a sample type such as UCHAR"),
                               ("13 12 11", "1300 1200 1100", "expected"), ("e.raw", "../e.raw", "outside the folder"),
                               ("e.raw", "none.raw", "finding it failed"), ("FLOAT", "DOUBLE", "bytes")):
            self.write("e.dat", good.replace(old, new))
            run = self.run_program("e.dat", "--iso", "0", "-o", "no.ply")
            self.assert_fails(2, run, said)
        for length in range(len(good) - 6):
            self.write("e.dat", good[:length])
            self.assertNotEqual(self.run_program("e.dat", "--iso", "0", "-o", "no.ply").code, 0, length)


if __name__ == "__main__":
    main()
