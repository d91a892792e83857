"""info on label maps, masks and CT scans, against numpy; the note about iso values on labels; help labels and masks."""

import gzip
import json
import re
import struct
import subprocess

from support import DATA, PROGRAM, SOURCE, ProgramTest, main, needs_data, needs_modules

needs_modules("numpy", "jsonschema")

import jsonschema  # noqa: E402
import numpy as np  # noqa: E402

from segmentation_test import BONE, DIMS, ORGAN, TUMOR, VOLUMES, VOXEL, seg_nrrd  # noqa: E402
from written_volumes import needs_reader  # noqa: E402

SCHEMA = json.loads((SOURCE / "docs" / "schemas" / "info.schema.json").read_text())
SPACING = (0.5, 0.75, 2.0)
ORIGIN = (10.0, -20.0, 30.0)


def ball(size, radius):
    z, y, x = np.mgrid[:size, :size, :size] - 0.5 * (size - 1) - 0.2
    return x * x + y * y + z * z < radius * radius


def cells(size, side, seed):
    """Wavy cells of about `side` samples, with labels from 1 in random order: [z, y, x]."""
    z, y, x = np.mgrid[:size, :size, :size].astype(float)
    waves = [1.3 * np.sin(0.31 * a + 0.23 * b) + 2 for a, b in ((y, z), (z, x), (x, y))]
    i, j, k = (((at + wave) // side).astype(np.int64) for at, wave in zip((x, y, z), waves))
    _, numbers = np.unique(i + 1000 * j + 1000000 * k, return_inverse=True)
    numbers = numbers.reshape(x.shape)
    return (np.random.default_rng(seed).permutation(numbers.max() + 1) + 1)[numbers]


def figures_of(volume):
    """Voxels and index boxes of each label except 0, and the faces of all of them, without isoextract."""
    labels = {}
    for label, count in zip(*np.unique(volume, return_counts=True)):
        if label != 0:
            labels[int(label)] = {"voxels": int(count)}
    order = np.argsort(volume, axis=None, kind="stable")
    sorted_labels = volume.ravel()[order]
    starts = np.flatnonzero(np.r_[True, np.diff(sorted_labels) != 0])
    where = np.unravel_index(order, volume.shape)[::-1]  # x, y, z
    low = [np.minimum.reduceat(axis, starts) for axis in where]
    high = [np.maximum.reduceat(axis, starts) for axis in where]
    for n, start in enumerate(starts):
        if sorted_labels[start] != 0:
            labels[int(sorted_labels[start])]["box"] = {"min": [int(a[n]) for a in low], "max": [int(a[n]) for a in high]}
    padded = np.pad(volume, 1)
    faces = 0
    for axis in range(3):
        a, b = (np.take(padded, range(s, padded.shape[axis] - 1 + s), axis) for s in (0, 1))
        faces += int(((a != b) & (a != 0)).sum() + ((a != b) & (b != 0)).sum())
    return labels, faces


def multi_otsu(values):
    """Both thresholds by trying all pairs of cuts of a histogram of 1024 bins from -1100 up."""
    counts, edges = np.histogram(values, 1024)
    first = int((-1100 - edges[0]) / (edges[1] - edges[0])) if edges[0] < -1100 else 0
    centers = np.arange(1024)
    w = np.r_[0, np.cumsum(np.where(centers >= first, counts, 0))].astype(float)
    m = np.r_[0, np.cumsum(np.where(centers >= first, counts * centers, 0))].astype(float)
    low, high = np.ogrid[:1024, :1024]
    sums = np.where((low > first) & (low < high), 0.0, -1)
    for start, end in ((first, low), (low, high), (high, 1024)):
        count, moment = w[end] - w[start], m[end] - m[start]
        sums = np.where((sums < 0) | (count == 0), -1, sums + moment * moment / np.maximum(count, 1))
    best = np.nonzero(sums == sums.max())  # an empty gap makes several cuts equally good: the middle
    return [edges[0] + 0.5 * (at.min() + at.max()) * (edges[1] - edges[0]) for at in best] + [edges[1] - edges[0]]


class InfoLabelsTest(ProgramTest):
    def write(self, volume, name="v.npy"):
        np.save(self.folder / name, volume)
        return (name,)

    def write_nifti(self, volume, name):
        """A NIfTI-1 file of bytes, as tools for segmentations write it."""
        head = bytearray(352)
        struct.pack_into("<i", head, 0, 348)
        struct.pack_into("<8h", head, 40, 3, *volume.shape[::-1], 1, 1, 1, 1)
        struct.pack_into("<2h", head, 70, 2, 8)
        struct.pack_into("<8f", head, 76, 1, 1, 1, 1, 0, 0, 0, 0)
        struct.pack_into("<f", head, 108, 352)
        head[344:348] = b"n+1\0"
        (self.folder / name).write_bytes(gzip.compress(bytes(head) + volume.astype(np.uint8).tobytes()))

    def field(self, *arguments):
        run = self.convert("info", "--json", *arguments)
        document = json.loads(run.text)
        jsonschema.Draft202012Validator(SCHEMA).validate(document)
        return document[0]["field"]

    def run_command(self, command):
        command = command.replace("isoextract", f"'{PROGRAM}'", 1)
        run = subprocess.run(["bash", "-c", command], cwd=self.folder, capture_output=True, check=False, timeout=300)
        self.assertEqual(run.returncode, 0, run.stderr)
        return run.stderr.decode()

    def assert_labels(self, volume, kind):
        """Everything that info says of the volume, and the number of triangles of the suggested command."""
        file = (*self.write(volume), "--spacing", "0.5,0.75,2", "--origin", "10,-20,30")
        field = self.field(*file)
        found = field["label_map"]
        self.assertEqual(found["kind"], kind)
        expected, faces = figures_of(volume)
        self.assertEqual([entry["label"] for entry in found["labels"]], sorted(expected))
        for entry in found["labels"]:
            of = expected[entry["label"]]
            self.assertEqual((entry["voxels"], entry["box"]), (of["voxels"], of["box"]))
            self.assertAlmostEqual(entry["volume"], of["voxels"] * 0.75, delta=1e-9 * of["voxels"])
            for end in ("min", "max"):
                for axis in range(3):
                    self.assertAlmostEqual(entry["world_box"][end][axis], ORIGIN[axis] + SPACING[axis] * of["box"][end][axis])
        zeros = int((volume == 0).sum())
        self.assertEqual(found["background"]["voxels"] if zeros else found["background"], zeros or None)
        suggestion = field["suggestion"]
        self.assertEqual((suggestion["iso"], suggestion["labels"], suggestion["triangles"]), (None, "all", 2 * faces))
        self.assertIn(" --labels all -o v.glb", suggestion["command"])
        return file, suggestion["command"], 2 * faces

    def test_masks(self):
        for inside, dtype in ((1, "uint8"), (255, "uint8"), (1, "float32"), (7, "uint16")):
            volume = np.where(ball(30, 11), inside, 0).astype(dtype)
            file, command, triangles = self.assert_labels(volume, "binary mask")
            text = self.convert("info", *file).text
            self.assertIn(f"content       binary mask: 0 and {inside}\n", text)
            self.assertIn("--labels all: a smooth closed mesh of the mask\n", text)
            self.assertNotIn("--iso", text)
            self.assertIn(f"{triangles} triangles", self.run_command(command).replace(",", ""))

    def test_a_label_map_with_a_hundred_labels(self):
        volume = cells(48, 10, 1)
        volume[~ball(48, 22)] = 0
        count = len(np.unique(volume)) - 1
        self.assertGreater(count, 70)
        for dtype in ("uint8", "int16", "uint32", "int64", "float32", "float64"):
            file, command, triangles = self.assert_labels(volume.astype(dtype), "label map")
        text = self.convert("info", *file).text
        self.assertIn(f"label map: {count} labels, background 0; ", text)
        self.assertIn(f" of the first 20 of {count}; --json lists all\n", text)
        first = sorted(set(volume[volume > 0]))[:20]
        rows = [int(row) for row in re.findall(r"^ +(\d+): +\d+ +[\d.]+ +\(", text, re.M)]
        self.assertEqual(rows, first)
        self.assertNotIn("histogram", text)
        self.run_command(command)
        self.assertTrue((self.folder / "v.glb").exists())

    def test_a_label_map_with_thousands_of_labels(self):
        volume = cells(96, 6.6, 2).astype(np.uint32)
        self.assertGreater(len(np.unique(volume)), 3000)
        self.assert_labels(volume, "label map")
        self.assertIn("without the label 0", self.convert("info", *self.write(volume)).text)

    def test_ids_that_a_double_does_not_hold(self):
        first = 720575940600000017
        for offset, dtype in ((first, "uint64"), (-first - 9, "int64")):
            volume = cells(48, 10, 5)
            volume = np.where(ball(48, 22), volume + offset, 0).astype(dtype)
            field = self.field(*self.assert_labels(volume, "label map")[0])
            self.assertEqual((field["type"], field["values"]["min"], field["values"]["max"]), ("i64", int(volume.min()), int(volume.max())))
            text = self.convert("info", *self.write(volume)).text
            self.assertIn(f"values        {volume.min()} .. {volume.max()}\n", text)
        noise = np.random.default_rng(1).integers(first, first + 1000, (16, 16, 16))
        run = self.run_program("info", *self.write(noise))
        self.assert_fails(2, run, f"v.npy: expected integers that a double represents exactly (all up to 2^53, above 2^53 only some), found {noise[0, 0, 0]} at sample (0, 0, 0)")

    def test_what_is_no_label_map(self):
        random = np.random.default_rng(3)
        z, y, x = np.mgrid[:64, :64, :64]
        smooth = 200 * np.exp(-(x ** 2 + y ** 2 + z ** 2) / (2 * 40 ** 2))
        noise = random.integers(0, 4, (64, 64, 64))
        for volume in (noise, noise * ball(64, 20), random.integers(0, 256, (64, 64, 64)), smooth, smooth // 12, x // 3):
            file = self.write(volume.astype(np.uint8))
            field = self.field(*file)
            self.assertIsNone(field["label_map"])
            self.assertIsNotNone(field["suggestion"]["iso"])
            self.assertNotIn("content ", self.convert("info", *file).text)

    @needs_data("med/ch2.nii.gz")
    def test_scans_are_no_label_maps(self):
        for name in ("med/ch2.nii.gz", "med/MR.nii.gz", "med/LIDC2.vti", "med/FLAIR.nrrd", "med/tooth.nhdr",
                     "med/HeadMRVolume.mhd", "sim/vase_1comp.vti", "sim/hydrogen.vti", "mol/betaGal.mrc"):
            if not (DATA / name).exists():
                continue
            if self.run_program("info", DATA / name).code == 3:  # without the plug-in for VTK's files
                continue
            field = self.field(DATA / name)
            self.assertIsNone(field["label_map"], name)
            self.assertIsNotNone(field["suggestion"]["iso"], name)
            if field["memory"]["samples"] < 4e6:
                run = self.convert(DATA / name, "--iso", field["suggestion"]["iso"], "-o", "m.ply")
                self.assertNotIn("iso-of-labels", run.err)

    def test_segmentations_have_names_and_layers(self):
        (self.folder / "s.seg.nrrd").write_bytes(seg_nrrd((ORGAN, BONE, TUMOR, ("Nowhere", "0 0 1", 9, 0, lambda *at: False)), 2))
        for volume, segments in ((0, (ORGAN, BONE)), (1, (TUMOR,))):
            found = self.field("s.seg.nrrd", "--volume", volume)["label_map"]
            self.assertEqual(found["kind"], "label map" if volume == 0 else "binary mask")
            self.assertEqual([entry["label"] for entry in found["labels"]], [segment[2] for segment in segments])
            for entry, (name, color, _, _, _) in zip(found["labels"], segments):
                name = name.replace("\\\\", "\\")
                self.assertEqual((entry["name"], entry["color"]), (name, [float(c) for c in color.split()]))
                self.assertAlmostEqual(entry["volume"], VOLUMES[name])
        text = self.convert("info", "s.seg.nrrd").text
        self.assertIn("no voxels     Nowhere\n", text)
        self.assertRegex(text, r"\n +7: +126 +94.5 .*  Rippe ä\n")
        self.assertEqual(VOXEL, 0.75)
        self.assertEqual(DIMS, (14, 12, 10))

    @needs_reader("dicom", "pydicom")
    def test_a_dicom_segmentation(self):
        import dicom_files  # needs pydicom

        masks = np.zeros((2, 10, 12, 14), bool)
        masks[0, 2:7, 3:9, 1:8] = True
        masks[1, 2:9, 2:9, 10:13] = True
        dicom_files.save(dicom_files.segmentation(masks, ["Liver", "Spine"], [(200, 20, 10), None]), self.folder / "s.dcm")
        found = self.field("s.dcm")["label_map"]
        for n, entry in enumerate(found["labels"]):
            self.assertEqual((entry["name"], entry["voxels"]), (("Liver", "Spine")[n], int(masks[n].sum())))

    def test_a_table_beside_the_file_has_the_names(self):
        volume = cells(32, 16, 4).astype(np.uint8)
        file = self.write(volume, "map.npy")
        (self.folder / "map.ctbl").write_text("1 Left-Kidney 0 0 255 0\n3 Spleen 255 255 0 0\n200 Elsewhere 1 1 1 0\n")
        found = self.field(*file)["label_map"]
        self.assertEqual(found["names_from"], "map.ctbl")
        names = {entry["label"]: (entry["name"], entry["color"]) for entry in found["labels"]}
        self.assertEqual((names[1], names[2], names[3]), (("Left-Kidney", [0, 0, 1]), (None, None), ("Spleen", [1, 1, 0])))
        run = self.convert("info", *file)
        self.assertIn("names         from map.ctbl\n", run.text)
        self.assertRegex(run.text, r"\n +3: .*  Spleen\n")
        self.assertNotIn("Elsewhere", run.text)
        (self.folder / "map.ctbl").write_text("no table\n")
        run = self.convert("info", *file)
        self.assertIn("note[label-table]: map.ctbl lies beside the input", run.err)

    def test_a_sequence_of_masks(self):
        for frame in (1, 2, 3):
            self.write(np.where(ball(24, 4 + frame), 1, 0).astype(np.uint8), f"m_{frame}.npy")
        (report,) = json.loads(self.convert("info", "--json", "m_{}.npy").text)
        jsonschema.Draft202012Validator(SCHEMA).validate([report])
        suggestion = report["suggestion"]
        self.assertEqual((suggestion["iso"], suggestion["labels"], suggestion["frames"]), (None, "all", 3))
        self.run_command(suggestion["command"])
        self.assertTrue((self.folder / "m_0003.glb").exists())
        text = self.convert("info", "m_{}.npy").text
        self.assertIn("3 of 3 frames are label maps or masks\n", text)
        self.assertIn(suggestion["command"], text)

    def test_an_iso_value_on_labels_is_told(self):
        mask = self.write(np.where(ball(30, 11), 1, 0).astype(np.uint8), "mask.npy")
        labels = self.write((cells(60, 9, 5) * ball(60, 28)).astype(np.uint16), "labels.npy")
        run = self.convert(*mask, "--iso", "0.5", "-o", "a.ply")
        self.assertIn("note[iso-of-labels]: mask.npy: the samples look like a binary mask: ", run.err)
        self.assertIn("--method surface-nets makes a smooth one", run.err)
        run = self.convert(*labels, "--iso", "2.5", "-o", "b.ply", "--report", "r.json")
        self.assertIn("note[iso-of-labels]: labels.npy: the samples look like a label map: ", run.err)
        notes = json.loads((self.folder / "r.json").read_text())["notes"]
        self.assertIn("iso-of-labels", [note["id"] for note in notes])
        for words in (("--labels", "1"), ("--iso", "0.5", "--method", "voxels"), ("--iso", "0.5", "--method", "surface-nets"),
                      ("--iso", "0.5", "--blur", "1"), ("--iso", "0.5", "--no-note", "iso-of-labels")):
            self.assertNotIn("iso-of-labels", self.convert(*mask, *words, "-o", "c.ply").err, words)
        # Once for all frames of a batch.
        for frame in (1, 2, 3):
            self.write(np.where(ball(24, 4 + frame), 1, 0).astype(np.uint8), f"m_{frame}.npy")
        run = self.convert("m_{}.npy", "--iso", "0.5", "-o", "m_{}.ply")
        self.assertEqual(run.err.count("iso-of-labels"), 1)

    def test_a_conversion_without_an_iso_value_leads_to_labels(self):
        for volume, kind in ((cells(24, 8, 1), "label map"), (ball(16, 5).astype("u1"), "binary mask")):
            file = self.write(volume.astype("u1"))
            run = self.run_program(*file, "-o", "x.glb")
            self.assert_fails(1, run, f"the samples look like a {kind}", "'isoextract info' prints the command")
            self.assertNotIn("iso value is inside", self.convert("info", *file).text)

    def test_a_ct_scan_has_iso_values_of_skin_and_bone(self):
        random = np.random.default_rng(6)
        volume = random.normal(-1000, 12, (48, 48, 48))
        volume = np.where(ball(48, 21), random.normal(40, 35, volume.shape), volume)
        volume = np.where(ball(48, 9), random.normal(1100, 150, volume.shape), volume).round().astype(np.int16)
        file = self.write(volume)
        field = self.field(*file)
        self.assertIsNone(field["label_map"])
        skin, bone, width = multi_otsu(volume)
        self.assertAlmostEqual(field["ct"]["skin"], skin, delta=width)
        self.assertAlmostEqual(field["ct"]["bone"], bone, delta=width)
        self.assertTrue(-900 < field["ct"]["skin"] < -100 < 300 < field["ct"]["bone"] < 900)
        text = self.convert("info", *file).text
        self.assertIn(f"CT scan       --iso {field['ct']['skin']:g}: skin; --iso {field['ct']['bone']:g}: bone (multi-Otsu", text)
        self.assertIn(f"suggestion    --iso {field['suggestion']['iso']:g}: Otsu's threshold", text)
        self.assertIsNone(self.field(*self.write(volume + np.int16(1024)))["ct"])

    def test_the_commands_of_the_help_work(self):
        self.write_nifti(cells(30, 12, 7) * ball(30, 14), "seg.nii.gz")
        self.write_nifti(ball(30, 11), "mask.nii.gz")
        (self.folder / "segmentations").mkdir()
        for name in ("heart.nii.gz", "aorta.nii.gz", "segmentations/kidney_left.nii.gz", "segmentations/liver.nii.gz"):
            self.write_nifti(ball(30, 5 + len(name) % 7), name)
        for topic, count in (("labels", 4), ("masks", 8)):
            commands = re.findall(r"^  (isoextract .*)$", self.convert("help", topic).text, re.M)
            self.assertEqual(len(commands), count)
            for command in commands:
                self.run_command(command)
        made = set(self.files())
        self.assertTrue({"organs.glb", "small.glb", "organ_1.stl", "organ_4.stl", "mask.stl", "smooth.stl", "steps.stl", "chest.glb",
                         "kidney_left.stl"} <= made, made)


if __name__ == "__main__":
    main()
