"""Files with several frames: which bytes a frame depends on, and what --resume converts again."""

import json
import os

from support import ProgramTest, main

XYZ = "4\nTime={0}\nH 1 1 {1}\nH 2 2 2\nH 1 2 1\nH 2 1 1\n"
LAMMPS = ("ITEM: TIMESTEP\n{0}\nITEM: NUMBER OF ATOMS\n4\nITEM: BOX BOUNDS pp pp pp\n0 4\n0 4\n0 4\nITEM: ATOMS id x y z\n"
          "1 1 1 {1}\n2 2 2 2\n3 1 2 1\n4 2 1 1\n")
FRAMES = 6
RADIUS = ("--radius", "1")


def npy(values, shape):
    head = f"{{'descr': '|u1', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head.encode() + bytes(values)


def volume(value):
    samples = bytearray(216)
    samples[86] = value
    return bytes(samples)


class TrajectoriesTest(ProgramTest):
    def meshes(self, folder):
        return {path.name: path.read_bytes() for path in (self.folder / folder).iterdir() if path.suffix == ".ply"}

    def converted(self, run):
        """The frames that the run converted."""
        self.assertEqual(run.code, 0, run.err)
        rows = json.loads((self.folder / "t.json").read_text())
        return [row["frame"] for row in rows if row["status"] == "done"]

    def run_all(self, name, *options):
        return self.run_program(name, "--volume", "all", *options, "-o", "out/{}.ply", "--mkdir", "--table", "t.json", "--resume")

    def containers(self):
        """Name, options, bytes of the file with the given frames."""
        yield "a.xyz", RADIUS, lambda zs: "".join(XYZ.format(k, z) for k, z in enumerate(zs)).encode()
        yield "a.lammpstrj", RADIUS, lambda zs: "".join(LAMMPS.format(k, z) for k, z in enumerate(zs)).encode()
        yield "a.npy", ("--iso", "50"), lambda zs: npy(b"".join(volume(100 + int(10 * z)) for z in zs), (FRAMES, 6, 6, 6))
        yield ("a.nrrd", ("--iso", "50"), lambda zs: b"NRRD0004\ntype: uint8\ndimension: 4\nsizes: 6 6 6 %d\nkinds: domain domain domain time\nencoding: raw\n\n" % FRAMES
               + b"".join(volume(100 + int(10 * z)) for z in zs))
        yield ("a.raw", ("--dims", "6,6,6", "--dtype", "u8", "--iso", "50"), lambda zs: b"".join(volume(100 + int(10 * z)) for z in zs))

    def test_resume_converts_only_the_frame_that_changed(self):
        for name, options, bytes_of in self.containers():
            with self.subTest(name=name):
                path = self.folder / name
                zs = [k / 10 for k in range(FRAMES)]
                path.write_bytes(bytes_of(zs))
                self.assertEqual(self.converted(self.run_all(name, *options)), list(range(FRAMES)))
                self.assertEqual(self.converted(self.run_all(name, *options)), [])
                os.utime(path, ns=(10**18, 10**18))
                self.assertEqual(self.converted(self.run_all(name, *options)), [])
                zs[3] = 0.9
                path.write_bytes(bytes_of(zs))
                self.assertEqual(self.converted(self.run_all(name, *options)), [3])
                made = self.meshes("out")
                for output in (self.folder / "out").iterdir():
                    output.unlink()
                self.run_all(name, *options)
                self.assertEqual(self.meshes("out"), made)
                for output in (self.folder / "out").iterdir():
                    output.unlink()

    def test_resume_takes_the_new_frames_of_a_file_that_grew(self):
        for name, frame in (("a.xyz", XYZ), ("a.lammpstrj", LAMMPS)):
            path = self.folder / name
            path.write_text("".join(frame.format(k, k / 10) for k in range(3)))
            self.assertEqual(self.converted(self.run_all(name, *RADIUS)), [0, 1, 2])
            with path.open("a") as file:
                file.write(frame.format(3, 0.3) + frame.format(4, 0.4))
            self.assertEqual(self.converted(self.run_all(name, *RADIUS)), [3, 4])
            # A frame in front moves all others.
            path.write_text(frame.format(9, 0.9) + path.read_text())
            self.assertEqual(self.converted(self.run_all(name, *RADIUS)), list(range(6)))
            for output in (self.folder / "out").iterdir():
                output.unlink()

    def test_a_changed_header_converts_all_frames(self):
        path = self.folder / "a.npy"
        samples = b"".join(volume(100 + k) for k in range(FRAMES))
        path.write_bytes(npy(samples, (FRAMES, 6, 6, 6)))
        self.run_all("a.npy", "--iso", "50")
        path.write_bytes(npy(samples, (FRAMES, 6, 6, 6)).replace(b"'|u1'", b"'<u1'"))
        self.assertEqual(self.converted(self.run_all("a.npy", "--iso", "50")), list(range(FRAMES)))

    def test_units_of_an_earlier_frame_count(self):
        """LAMMPS states the units in the first frame only."""
        path = self.folder / "a.lammpstrj"
        text = "".join(LAMMPS.format(k, k / 10) for k in range(3))
        path.write_text("ITEM: UNITS\nmetal\n" + text)
        self.assertEqual(self.converted(self.run_all(path.name, *RADIUS)), [0, 1, 2])
        self.assertEqual(self.converted(self.run_all(path.name, *RADIUS)), [])
        path.write_text("ITEM: UNITS\nmicro\n" + text)
        self.assertEqual(self.converted(self.run_all(path.name, *RADIUS)), [0, 1, 2])

    def test_frames_are_equal_to_those_of_single_files(self):
        """Of unlike sizes, with CR LF and blank lines between them."""
        sizes = (4, 1, 7, 3)
        atoms = [[(i % 3, i // 3, 0.2 * k) for i in range(n)] for k, n in enumerate(sizes)]
        for end in ("\n", "\r\n"):
            frames = [f"{len(rows)}{end}comment{end}" + "".join(f"H {x} {y} {z}{end}" for x, y, z in rows) for rows in atoms]
            (self.folder / "all.xyz").write_bytes((end + end).join(frames).encode())
            for k, frame in enumerate(frames):
                (self.folder / f"one_{k}.xyz").write_bytes(frame.encode())
            self.convert("all.xyz", "--volume", "all", *RADIUS, "-o", "all/{}.ply", "--mkdir")
            self.convert("one_{}.xyz", *RADIUS, "-o", "one/{}.ply", "--mkdir")
            self.assertEqual(len(self.meshes("all")), len(sizes))
            self.assertEqual(self.meshes("all"), self.meshes("one"))
            # The ranges in the manifest against a scan in Python.
            at, expected = 0, []
            for k, frame in enumerate(frames):
                length = len(frame) + (2 * len(end) if k > 0 else 0)
                expected.append([[at, length]])
                at += length
            records = [json.loads(line[33:]) for line in (self.folder / "all/isoextract.manifest").read_text().splitlines()]
            found = {record["frame"]: record["inputs"][0]["ranges"] for record in records if "inputs" in record}
            self.assertEqual([found[k] for k in range(len(sizes))], expected)

    def test_shards_record_their_frames(self):
        path = self.folder / "a.xyz"
        path.write_text("".join(XYZ.format(k, k / 10) for k in range(FRAMES)))
        for shard in ("1/2", "2/2"):
            self.convert("a.xyz", "--volume", "all", *RADIUS, "-o", "out/{}.ply", "--mkdir", "--shard", shard)
        self.convert("merge", "out")
        self.assertEqual(self.converted(self.run_all("a.xyz", *RADIUS)), [])
        path.write_text("".join(XYZ.format(k, 0.8 if k == 2 else k / 10) for k in range(FRAMES)))
        self.assertEqual(self.converted(self.run_all("a.xyz", *RADIUS)), [2])


if __name__ == "__main__":
    main()
