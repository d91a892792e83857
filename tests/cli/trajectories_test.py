"""Files with several frames: which bytes a frame depends on, and what --resume converts again."""

import gzip
import json
import os
import random
import struct

from support import ProgramTest, main

XYZ = "4\nTime={0}\nH 1 1 {1}\nH 2 2 2\nH 1 2 1\nH 2 1 1\n"
LAMMPS = ("ITEM: TIMESTEP\n{0}\nITEM: NUMBER OF ATOMS\n4\nITEM: BOX BOUNDS pp pp pp\n0 4\n0 4\n0 4\nITEM: ATOMS id x y z\n"
          "1 1 1 {1}\n2 2 2 2\n3 1 2 1\n4 2 1 1\n")
GRO = "t= {0}\n4\n" + "".join(f"    1SOL     OW    1{row}\n" for row in ("   1.000   1.000{1:8.3f}", "   2.000   2.000   2.000", "   1.000   2.000   1.000", "   2.000   1.000   1.000")) + "9 9 9\n"
PDB = "MODEL {0}\n" + "".join(f"ATOM      1  N   ALA A   1    {row}\n" for row in ("   1.000   1.000{1:8.3f}", "   2.000   2.000   2.000", "   1.000   2.000   1.000", "   2.000   1.000   1.000")) + "ENDMDL\n"
TRAJECTORIES = (("a.xyz", XYZ), ("a.lammpstrj", LAMMPS), ("a.gro", GRO), ("a.pdb", PDB))
FRAMES = 6
RADIUS = ("--radius", "1")


def npy(values, shape, kind="|u1"):
    head = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
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
        yield "a.gro", RADIUS, lambda zs: "".join(GRO.format(k, z) for k, z in enumerate(zs)).encode()
        yield "a.pdb", RADIUS, lambda zs: "".join(PDB.format(k, z) for k, z in enumerate(zs)).encode()
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
        for name, frame in TRAJECTORIES:
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

    def test_resume_takes_the_frames_after_an_incomplete_one(self):
        for name, frame in TRAJECTORIES:
            path = self.folder / name
            text = "".join(frame.format(k, k / 10) for k in range(5))
            path.write_text(text[:text.index(frame.format(2, 0.2)) + len(frame.format(2, 0.2)) - 10])
            run = self.run_all(name, *RADIUS)
            self.assertEqual(self.converted(run), [0, 1])
            part = {"a.gro": "the file ends before its box", "a.pdb": "4 atoms without the record ENDMDL or END after them"}
            part = part.get(name, "2 of 4 particles")
            self.assertIn(f"the last frame (2) of {name} is incomplete: {part}; the reader uses the 2 frames before it", run.err)
            path.write_text(text)
            run = self.run_all(name, *RADIUS)
            self.assertEqual(self.converted(run), [2, 3, 4])
            self.assertNotIn("incomplete", run.err)
            for output in (self.folder / "out").iterdir():
                output.unlink()

    def test_compressed_frames_have_the_bytes_of_plain_ones(self):
        for name, frame in TRAJECTORIES:
            data = "".join(frame.format(k, k / 10) for k in range(FRAMES)).encode()
            (self.folder / name).write_bytes(data)
            (self.folder / f"{name}.gz").write_bytes(gzip.compress(data))
            for jobs in ("1", "3"):
                self.convert(name, "--volume", "all", *RADIUS, "-o", "plain/{}.ply", "--mkdir", "--jobs", jobs)
                self.convert(f"{name}.gz", "--volume", "all", *RADIUS, "-o", "packed/{}.ply", "--mkdir", "--jobs", jobs)
                self.assertEqual(len(self.meshes("plain")), FRAMES)
                self.assertEqual(self.meshes("packed"), self.meshes("plain"))

    def test_frames_of_a_numpy_array_of_particles(self):
        """Shape (F, N, 3), against files of one frame each."""
        chance = random.Random(1)
        points = [[chance.uniform(0, 3) for _ in range(20 * 3)] for _ in range(FRAMES)]
        packed = [struct.pack("<60d", *frame) for frame in points]
        path = self.folder / "a.npy"
        path.write_bytes(npy(b"".join(packed), (FRAMES, 20, 3), "<f8"))
        for k in range(FRAMES):
            (self.folder / f"one_{k}.npy").write_bytes(npy(packed[k], (20, 3), "<f8"))
        info = json.loads(self.convert("info", "--json", "--radius", "1", "a.npy", "--volume", "3").out)[0]["particles"]
        self.assertEqual((info["frames"], info["frame"], info["count"]), (FRAMES, 3, 20))
        for axis in range(3):
            self.assertEqual([bound[axis] for bound in info["bounds"].values()], [min(points[3][axis::3]), max(points[3][axis::3])])
        self.convert("a.npy", "--volume", "all", *RADIUS, "-o", "all/{}.ply", "--mkdir")
        self.convert("one_{}.npy", *RADIUS, "-o", "one/{}.ply", "--mkdir")
        self.assertEqual(len(self.meshes("all")), FRAMES)
        self.assertEqual(self.meshes("all"), self.meshes("one"))
        self.convert("a.npy", "--volume", "2", *RADIUS, "-o", "two.ply")
        self.assertEqual((self.folder / "two.ply").read_bytes(), self.meshes("one")["2.ply"])
        self.assert_fails(2, self.run_program("a.npy", *RADIUS, "-o", "x.ply"), f"there are {FRAMES} frames in the file")
        self.assertEqual(self.converted(self.run_all("a.npy", *RADIUS)), list(range(FRAMES)))
        packed[4] = struct.pack("<60d", *(x + 0.25 for x in points[4]))
        path.write_bytes(npy(b"".join(packed), (FRAMES, 20, 3), "<f8"))
        self.assertEqual(self.converted(self.run_all("a.npy", *RADIUS)), [4])

    def test_steps_and_times(self):
        """In info, the table, the report, the manifest and the names of files."""
        gro = "Water t= {0} step= {1}\n1\n    1SOL     OW    1   1.000   1.000   1.000\n9 9 9\n"
        extended = "1\nProperties=pos:R:3 Time={0} step={1}\n1 1 1\n"
        lammps = ("ITEM: TIMESTEP\n{1}\nITEM: TIME\n{0}\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS pp pp pp\n0 4\n0 4\n0 4\n"
                  "ITEM: ATOMS x y z\n1 1 1\n")
        moments = [(0.5, 100), (0.75, 150), (2.5, 500)]
        for name, frame in (("a.gro", gro), ("a.xyz", extended), ("a.dump", lammps)):
            with self.subTest(name=name):
                (self.folder / name).write_text("".join(frame.format(*moment) for moment in moments))
                run = self.convert("info", "--json", name)
                info = json.loads(run.out)[0]["particles"]
                self.assertEqual((info["steps"], info["times"]), ([100, 500], [0.5, 2.5]))
                self.assertRegex(self.convert("info", name).out.decode(), r"steps +100 to 500\n.*times +0.5 to 2.5\n")
                self.convert(name, "--volume", "all", *RADIUS, "-o", name + "_out/m_{step}.ply", "--mkdir", "--table", "t.json",
                             "--report", "r_{step}.json")
                self.assertEqual(sorted(self.meshes(name + "_out")), ["m_100.ply", "m_150.ply", "m_500.ply"])
                rows = json.loads((self.folder / "t.json").read_text())
                self.assertEqual([(row["time"], row["step"]) for row in rows], moments)
                report = json.loads((self.folder / "r_150.json").read_text())
                self.assertEqual(report["particles"]["frame"], {"step": 150, "time": 0.75})
                records = [json.loads(line[33:]) for line in (self.folder / f"{name}_out/isoextract.manifest").read_text().splitlines()]
                figures = [record["figures"] for record in records if "figures" in record]
                self.assertEqual(sorted((one["time"], one["step"]) for one in figures), moments)
                self.convert(name, "--volume", "1", *RADIUS, "-o", "one_{step}.ply")
                self.assertTrue((self.folder / "one_150.ply").exists())
        # Files of one frame each.
        for k, moment in enumerate(moments):
            (self.folder / f"s_{k}.dump").write_text(lammps.format(*moment))
        self.convert("s_{}.dump", *RADIUS, "-o", "s/m_{step}.ply", "--mkdir")
        self.assertEqual(sorted(self.meshes("s")), ["m_100.ply", "m_150.ply", "m_500.ply"])

    def test_names_by_step_need_steps_that_differ(self):
        (self.folder / "none.xyz").write_text(XYZ.format(0, 0) * 2)
        self.assert_fails(1, self.run_program("none.xyz", "--volume", "all", *RADIUS, "-o", "m_{step}.ply"),
                          "frame 0 (none.xyz): expected the number of a time step for {step} in the output name, found none")
        self.assert_fails(1, self.run_program("none.xyz", "--volume", "all", *RADIUS, "-o", "m_{}.ply", "--report", "r_{step}.json"),
                          "--report r_{step}.json: expected the number of a time step for {step}, found none in none.xyz")
        self.assert_fails(1, self.run_program("demo:sphere", "--iso", "0.5", "-o", "m_{step}.ply"), "for {step}")
        (self.folder / "same.dump").write_text(LAMMPS.format(7, 0) + LAMMPS.format(7, 0.5))
        self.assert_fails(1, self.run_program("same.dump", "--volume", "all", *RADIUS, "-o", "m_{step}.ply"),
                          "frame 0 (same.dump) and frame 1 (same.dump) would both write this file")

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
        path.write_text("ITEM: UNITS\nmetal\n" + text + LAMMPS.format(3, 0.3))
        self.assertEqual(self.converted(self.run_all(path.name, *RADIUS)), [3])
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
