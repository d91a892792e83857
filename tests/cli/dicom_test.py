"""DICOM through the plug-in: placement and values against pydicom and numpy, segmentations, damaged files, privacy."""

import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys

SYSTEM_PYTHON = "/usr/bin/python3"
try:
    import numpy
    import pydicom
except ImportError:
    # Debian's modules are those of the system's Python; the tests may run in another.
    if sys.executable == SYSTEM_PYTHON or not pathlib.Path(SYSTEM_PYTHON).exists():
        raise
    os.execv(SYSTEM_PYTHON, [SYSTEM_PYTHON, "-B", *sys.argv])

from support import DATA, PROGRAM, ProgramTest, main, needs_data, needs_program, read_ply

import dicom_files as dicom

PLUGIN = pathlib.Path(PROGRAM).parent / "plugins" / "isoextract-volume-dicom.so"
SHAPE = (6, 5, 7)  # slices, rows, columns
PLACES = [(10, 20, 30 + 2.5 * k) for k in range(SHAPE[0])]
VOLUME = numpy.random.default_rng(1).integers(-2000, 2000, SHAPE).astype(numpy.int16)
PHANTOM = "dicom/phantom_ct"


class DicomTestCase(ProgramTest):
    def setUp(self):
        super().setUp()
        self.assertTrue(PLUGIN.exists(), f"no {PLUGIN.name}: scripts/setup.sh dicom installs what it needs")

    def field(self, *arguments):
        """Values, with slope and intercept applied, and the report of a conversion to an array [z, y, x]."""
        run = self.convert(*arguments, "-o", "field.npy", "--report", "report.json")
        report = json.loads((self.folder / "report.json").read_text())
        for text in (run.err, (self.folder / "report.json").read_text()):
            for secret in dicom.PATIENT:
                self.assertNotIn(secret.lower(), text.lower())
        return numpy.load(self.folder / "field.npy"), report

    def info(self, *arguments):
        run = self.run_program("info", "--json", *arguments)
        self.assertEqual(run.code, 0, run.err)
        for secret in dicom.PATIENT:
            self.assertNotIn(secret.lower(), (run.text + run.err).lower())
        return json.loads(run.text)[0]

    def assert_field(self, arguments, expected, placement=None, note=None):
        values, report = self.field(*arguments)
        expected = numpy.asarray(expected)
        self.assertEqual(values.dtype, expected.dtype)
        numpy.testing.assert_array_equal(values, expected)
        if placement is not None:
            numpy.testing.assert_allclose(report["input"]["index_to_world"], placement, rtol=0, atol=1e-9)
            self.assertEqual((report["input"]["world_space"], report["input"]["length_unit"]), ("left-posterior-superior", "mm"))
        if note is not None:
            self.assertIn(note, json.dumps(report["notes"]))
        return report


class SeriesTest(DicomTestCase):
    placement = [[0.75, 0, 0, 10], [0, 0.5, 0, 20], [0, 0, 2.5, 30]]

    def test_slices_are_sorted_by_position(self):
        order = numpy.random.default_rng(2).permutation(SHAPE[0])
        dicom.write_series(self.folder / "scan", VOLUME, PLACES, names=[f"IM{order[k]}" for k in range(SHAPE[0])])
        dicom.save(dicom.report(), self.folder / "scan" / "IMREPORT")
        (self.folder / "scan" / "notes.txt").write_text("no slice")
        report = self.assert_field(["scan"], VOLUME, self.placement, "the reader skips 1 object without pixels")
        self.assertIn("the reader skips 1 file that is not DICOM", json.dumps(report["notes"]))
        # A file of the series stands for all of it, and a list of files for these.
        self.assert_field(["scan/IM3"], VOLUME, self.placement)

    def test_sheared_by_gantry_tilt(self):
        places = [(0, 0.3 * k, 2 * k) for k in range(SHAPE[0])]
        dicom.write_series(self.folder / "scan", VOLUME, places)
        placement = [[0.75, 0, 0, 0], [0, 0.5, 0.3, 0], [0, 0, 2, 0]]
        self.assert_field(["scan"], VOLUME, placement, "sheared by 8.53077 degrees")

    def test_oblique_and_from_the_top_down(self):
        row, column = numpy.array([0.6, 0.8, 0]), numpy.array([0, 0, -1])
        normal = numpy.cross(row, column)
        places = [5 * numpy.ones(3) - 1.5 * k * normal for k in range(SHAPE[0])]
        dicom.write_series(self.folder / "scan", VOLUME, places, orientation=[*row, *column])
        placement = numpy.column_stack([row * 0.75, column * 0.5, normal * 1.5, places[-1]])
        self.assert_field(["scan"], VOLUME[::-1], placement)

    def test_uneven_distances(self):
        dicom.write_series(self.folder / "scan", VOLUME, [(0, 0, z) for z in (0, 2, 4, 8, 10, 12)])
        run = self.run_program("scan", "--iso", "0", "-o", "a.ply")
        self.assert_fails(2, run, "found distances from 2 to 4 mm, usually 2 mm: 4 mm after slice 3", "1 slice is missing", "--resample")
        middle = (VOLUME[2].astype(float) + VOLUME[3]) / 2
        expected = numpy.concatenate([VOLUME[:3], [middle], VOLUME[3:]]).astype(numpy.float32)
        self.assert_field(["scan", "--resample"], expected, [[0.75, 0, 0, 0], [0, 0.5, 0, 0], [0, 0, 2, 0]], "linearly, and makes 7 slices")

    def test_slopes(self):
        dicom.write_series(self.folder / "one", VOLUME, PLACES, slopes=[(2.5, -7)] * SHAPE[0])
        report = self.assert_field(["one"], (2.5 * VOLUME - 7).astype(numpy.float32))
        self.assertEqual(report["input"]["sample_type"], "i16")
        slopes = [(1 + 0.1 * k, -5 * k) for k in range(SHAPE[0])]
        dicom.write_series(self.folder / "several", VOLUME, PLACES, slopes=slopes)
        expected = numpy.stack([VOLUME[k] * float(dicom.decimal(slope)) + offset for k, (slope, offset) in enumerate(slopes)])
        self.assert_field(["several"], expected.astype(numpy.float32), note="different rescale slopes")

    def test_several_series(self):
        dicom.write_series(self.folder / "scan", VOLUME, PLACES)
        dicom.write_series(self.folder / "scan" / "b", VOLUME + 1, PLACES, series="1.2.3.101", number=7, description="BONE")
        dicom.write_series(self.folder / "scan" / "c", VOLUME[:1], PLACES[:1], series="1.2.3.102", number=8, description="SCOUT")
        names = [grid["name"] for grid in self.info("scan")["grids"]]
        self.assertEqual(names, ["1 TEST SERIES", "7 BONE"])
        run = self.run_program("scan", "--iso", "0", "-o", "a.ply")
        self.assert_fails(2, run, "7 BONE", "--grid")
        self.assert_field(["scan", "--grid", "7 BONE"], VOLUME + 1, note="the reader skips 1 single image beside the volumes")
        # In one folder, a file chooses its series.
        for path in (self.folder / "scan" / "b").iterdir():
            shutil.copy(path, self.folder / "scan" / f"b_{path.name}")
        self.assert_field(["scan/b_slice_002.dcm"], VOLUME + 1)

    def test_time_steps(self):
        for t in range(3):
            names = [f"T{t}_{k}" for k in range(SHAPE[0])]
            dicom.write_series(self.folder / "scan", VOLUME + t, PLACES, names=names, TemporalPositionIdentifier=t + 1, TemporalResolution="500")
        (grid,) = self.info("scan")["grids"]
        self.assertEqual((grid["volumes"], grid["times"], grid["time_unit"]), (3, [0, 0.5, 1], "s"))
        self.assert_field(["scan", "--volume", "2"], VOLUME + 2, self.placement)

    def test_echoes_and_image_types(self):
        for t, echo in enumerate(("4.6", "9.2")):
            for kind in "MP":
                names = [f"{t}{kind}{k}" for k in range(SHAPE[0])]
                dicom.write_series(self.folder / "scan", VOLUME + t + 10 * (kind == "P"), PLACES, names=names, EchoTime=echo,
                                   ImageType=["ORIGINAL", "PRIMARY", kind])
        grids = self.info("scan")["grids"]
        self.assertEqual([grid["volumes"] for grid in grids], [2, 2])
        self.assertIn("image type", grids[1]["name"])
        self.assert_field(["scan", "--grid", grids[1]["name"], "--volume", "1"], VOLUME + 11)

    def test_copies_and_duplicates(self):
        dicom.write_series(self.folder / "scan", VOLUME, PLACES)
        shutil.copy(self.folder / "scan" / "slice_001.dcm", self.folder / "scan" / "copy.dcm")
        dicom.save(dicom.image(VOLUME[0], PLACES[2], instance=99), self.folder / "scan" / "again.dcm")
        report = self.assert_field(["scan"], VOLUME, note="the reader skips 1 copy of the same image")
        self.assertIn("1 slice at the position of another left out", json.dumps(report["notes"]))

    def test_a_description_with_the_patients_name(self):
        dicom.write_series(self.folder / "scan", VOLUME, PLACES, description="thorax of alonso", ProtocolName="QX-4711-A head",
                           ManufacturerModelName="Model QUIXOTE")
        (grid,) = self.info("scan")["grids"]
        self.assertEqual((grid["name"], grid["creator"]), ("1", "Maker"))
        self.assert_field(["scan"], VOLUME)

    def test_descriptions_with_other_forms_of_the_patient(self):
        def names(description, **attributes):
            dicom.write_series(self.folder / "scan", VOLUME, PLACES, description=description, **attributes)
            return self.info("scan")["grids"][0]["name"]

        leaking = (("CT Li abdomen", {"PatientName": "Li^A"}), ("of MÜLLER", {"PatientName": "Müller", "SpecificCharacterSet": "ISO_IR 100"}),
                   ("АННА 2", {"PatientName": "Анна", "SpecificCharacterSet": "ISO_IR 192"}), ("born 09-29-1547", {}),
                   ("born 1547-09-29", {}), ("29.09.1547", {}), ("Leia Organa", {"PatientBirthName": "Organa^Leia"}),
                   ("luc 3", {"PatientName": "Durand^Jean-Luc"}),
                   ("no. 77-12", {"OtherPatientIDsSequence": pydicom.Sequence([dicom.item(PatientID="77-12")])}))
        for description, attributes in leaking:
            self.assertEqual(names(description, **attributes), "1", description)
        for description, attributes in (("Limb", {"PatientName": "Li^A"}), ("T1 a", {"PatientName": "Li^A"}),
                                        ("Thorax CT", {"PatientID": "CT-001"}), ("1547 slices", {})):
            self.assertIn(description, names(description, **attributes))

    def test_a_description_that_is_not_utf_8(self):
        """A half of a pair of UTF-16 and a slash in two bytes: bytes of the form of UTF-8, but no characters."""
        for wrong, text in ((b"\xed\xa0\x80", "???"), (b"\xc0\xaf.", "??."), ("ü.".encode(), "ü.")):
            dicom.write_series(self.folder / "scan", VOLUME, PLACES, description="thorax QQQ", SpecificCharacterSet="ISO_IR 192")
            for path in (self.folder / "scan").iterdir():
                path.write_bytes(path.read_bytes().replace(b"QQQ", wrong))
            self.assertIn(f"thorax {text}", self.info("scan")["grids"][0]["name"])

    def test_no_positions(self):
        dicom.write_series(self.folder / "scan", VOLUME, [None] * SHAPE[0], SliceThickness="3")
        report = self.assert_field(["scan"], VOLUME, note="the headers have no positions")
        self.assertEqual(report["input"]["index_to_world"][2], [0, 0, 3, 0])
        self.assertEqual(report["input"]["world_space"], "")

    def test_directory_file(self):
        dicom.write_series(self.folder / "disc" / "images", VOLUME, PLACES, names=[f"im{k}" for k in range(SHAPE[0])])
        data = dicom.base("1.2.840.10008.1.3.10", "1")
        data.DirectoryRecordSequence = pydicom.Sequence(
            [dicom.item(DirectoryRecordType="IMAGE", ReferencedFileID=["IMAGES", f"IM{k}"]) for k in range(SHAPE[0] + 1)])
        dicom.save(data, self.folder / "disc" / "DICOMDIR")
        self.assert_field(["disc/DICOMDIR"], VOLUME, self.placement, "1 file of the DICOM directory is missing")

    def test_a_region_reads_its_slices_only(self):
        dicom.write_series(self.folder / "scan", numpy.repeat(VOLUME, 5, axis=0), [(0, 0, k) for k in range(30)])
        self.convert("scan", "--iso", "0", "--roi", "0,0,10,4,2,11", "-o", "a.ply", "--report", "report.json")
        report = (self.folder / "report.json").read_text()
        self.assertRegex(report, r'"file_parts"')


def smooth():
    """Three slices of 12 bits that codecs like."""
    steps = numpy.random.default_rng(3).integers(-3, 4, (3, 32, 40))
    return (numpy.cumsum(numpy.cumsum(steps, 1), 2) % 4096).astype(numpy.uint16)


class FormsTest(DicomTestCase):
    """How pixels are stored."""

    places = [(0, 0, k) for k in range(3)]

    def test_byte_orders_and_deflated(self):
        for name in ("ExplicitVRBigEndian", "ImplicitVRLittleEndian", "DeflatedExplicitVRLittleEndian"):
            dicom.write_series(self.folder / name, smooth(), self.places, syntax=getattr(pydicom.uid, name))
            self.assert_field([name], smooth())

    def test_types(self):
        for kind in ("u1", "i1", "u2", "i2", "u4", "i4"):
            values = (smooth()[:, :9, :11].astype(int) - 50).astype(kind)
            dicom.write_series(self.folder / kind, values, self.places)
            self.assert_field([kind], values)

    def test_unused_bits(self):
        values = smooth()
        stored = (values << 4) | 9  # overlays in the low bits
        dicom.write_series(self.folder / "scan", stored, self.places, BitsStored=12, HighBit=15)
        self.assert_field(["scan"], values)
        signed = values.astype(numpy.int16) - 2048
        dicom.write_series(self.folder / "signed", (signed.astype(numpy.uint16) & 0xFFF) | 0x7000, self.places, BitsStored=12, HighBit=11,
                           PixelRepresentation=1)
        self.assert_field(["signed"], signed)

    @needs_program("gdcmconv")
    def test_compressed(self):
        arrays = {"u2": smooth(), "i2": smooth().astype(numpy.int16) - 2048, "u1": (smooth() // 16).astype(numpy.uint8)}
        for kind, values in arrays.items():
            paths = dicom.write_series(self.folder / kind, values, self.places)
            for form in ("jpeg", "jpegls", "j2k", "rle"):
                (self.folder / (kind + form)).mkdir()
                for path in paths:
                    subprocess.run(["gdcmconv", f"--{form}", path, self.folder / (kind + form) / path.name], check=True, capture_output=True)
                self.assert_field([kind + form], values)

    def test_colors(self):
        values = numpy.random.default_rng(4).integers(0, 256, (3, 9, 8, 3)).astype(numpy.uint8)
        dicom.write_series(self.folder / "scan", values, self.places)
        (grid,) = self.info("scan")["grids"]
        self.assertEqual((grid["components"], grid["component_names"]), (3, "red green blue"))
        self.assert_field(["scan", "--component", "1"], values[..., 1])
        length = numpy.sqrt((values.astype(float) ** 2).sum(-1)).astype(numpy.float32)
        self.assert_field(["scan", "--component", "length"], length)
        planes = self.folder / "planes"
        planes.mkdir()
        for k in range(3):
            data = dicom.image(values[k], self.places[k], instance=k)
            data.PlanarConfiguration = 1
            data.PixelData = values[k].transpose(2, 0, 1).tobytes()
            dicom.save(data, planes / str(k))
        self.assert_field(["planes", "--component", "2"], values[..., 2])

    def test_inverted_values_are_told(self):
        dicom.write_series(self.folder / "scan", VOLUME, PLACES, PhotometricInterpretation="MONOCHROME1")
        self.assert_field(["scan"], VOLUME, note="MONOCHROME1")


class MultiFrameTest(DicomTestCase):
    def test_frames_are_sorted_and_scaled(self):
        order = numpy.random.default_rng(5).permutation(SHAPE[0])
        data = dicom.enhanced(VOLUME[order], [PLACES[k] for k in order], slopes=[(2, -7)] * SHAPE[0])
        dicom.save(data, self.folder / "scan.dcm")
        self.assert_field(["scan.dcm"], (2 * VOLUME - 7).astype(numpy.float32), SeriesTest.placement)

    @needs_program("gdcmconv")
    def test_compressed_time_steps(self):
        frames = numpy.concatenate([smooth(), smooth() + 1])
        data = dicom.enhanced(frames, PLACES[:3] * 2, temporal=[1] * 3 + [2] * 3)
        dicom.save(data, self.folder / "raw.dcm")
        for form in ("jpegls", "j2k", "rle"):
            subprocess.run(["gdcmconv", f"--{form}", "raw.dcm", f"{form}.dcm"], check=True, capture_output=True, cwd=self.folder)
            self.assert_field([f"{form}.dcm", "--volume", "1"], smooth() + 1, SeriesTest.placement)

    def test_dose(self):
        data = dicom.base("1.2.840.10008.5.1.4.1.1.481.2", "1.2.3.9")
        values = (VOLUME.astype(int) + 2000).astype(numpy.uint32)
        dicom.set_pixels(data, values)
        data.NumberOfFrames = SHAPE[0]
        data.ImagePositionPatient, data.ImageOrientationPatient = [10, 20, 30], dicom.AXIAL
        data.PixelSpacing = [0.5, 0.75]
        data.GridFrameOffsetVector = [2.5 * k for k in range(SHAPE[0])]
        data.DoseGridScaling = "0.001"
        dicom.save(data, self.folder / "dose.dcm")
        self.assert_field(["dose.dcm"], values * 0.001, SeriesTest.placement)


def ball(center, radius):
    z, y, x = numpy.mgrid[:10, :40, :50]
    return (z - center[2]) ** 2 + (y - center[1]) ** 2 + (x - center[0]) ** 2 < radius**2


class SegmentationTest(DicomTestCase):
    def test_names_colors_and_place(self):
        left, right = ball((15, 20, 5), 4), ball((33, 20, 5), 4)
        data = dicom.segmentation([left, right], ["Leber", "Niere"], [(128, 0, 0), None], numbers=[1, 5], origin=(5, 6, 7))
        dicom.save(data, self.folder / "seg.dcm")
        # Slices 0, 1 and 9 have no frame.
        expected = (left + 5 * right)[2:9].astype(numpy.uint8)
        self.assert_field(["seg.dcm"], expected, [[0.75, 0, 0, 5], [0, 0.5, 0, 6], [0, 0, 2, 11]])
        (grid,) = self.info("seg.dcm")["grids"]
        self.assertEqual([(label["label"], label["name"]) for label in grid["labels"]], [(1, "Leber"), (5, "Niere")])
        # dcmqi writes (16732, 45246, 42677) for this red, the value that the file has.
        numpy.testing.assert_allclose(data.SegmentSequence[0].RecommendedDisplayCIELabValue, (16732, 45246, 42677), atol=8)
        numpy.testing.assert_allclose(grid["labels"][0]["color"], (128 / 255, 0, 0), atol=2e-3)
        self.assertIsNone(grid["labels"][1]["color"])

    def test_a_segment_named_by_the_patient(self):
        mask = ball((15, 20, 5), 4)
        dicom.save(dicom.segmentation([mask, ~mask], ["Liver Quixote", "Leber"], [None, None]), self.folder / "seg.dcm")
        (grid,) = self.info("seg.dcm")["grids"]
        self.assertEqual([label["name"] for label in grid["labels"]], ["segment 1", "Leber"])

    def test_volumes_of_the_meshes(self):
        left, right = ball((15, 20, 5), 4), ball((33, 20, 5), 4)
        dicom.save(dicom.segmentation([left, right], ["A", "B"], [None, None]), self.folder / "seg.dcm")
        for label, mask in ((1, left), (2, right)):
            self.convert("seg.dcm", "--labels", label, "--method", "voxels", "-o", "one.ply")
            run = self.run_program("check", "one.ply", "--json")
            volume = find(json.loads(run.text), "volume")
            self.assertAlmostEqual(volume, mask.sum() * 0.75 * 0.5 * 2, places=3)

    def test_gaps_are_empty(self):
        mask = ball((15, 20, 5), 4)
        mask[4:6] = False
        dicom.save(dicom.segmentation([mask], ["A"], [None]), self.folder / "seg.dcm")
        self.assert_field(["seg.dcm"], mask[2:9].astype(numpy.uint8))

    def test_overlapping_segments(self):
        masks = [ball((15, 20, 5), 4), ball((33, 20, 5), 4), ball((20, 20, 5), 4)]
        data = dicom.segmentation(masks, ["A", "B", "C"], [None] * 3)
        dicom.save(data, self.folder / "seg.dcm")
        grids = self.info("seg.dcm")["grids"]
        self.assertEqual([[label["name"] for label in grid["labels"]] for grid in grids], [["A", "B"], ["C"]])
        self.assert_field(["seg.dcm", "--grid", grids[1]["name"]], 3 * masks[2][2:9].astype(numpy.uint8), note="segments overlap")
        # The file's word that none overlap saves reading it twice.
        data.SegmentsOverlap = "NO"
        dicom.save(data, self.folder / "seg.dcm")
        self.assertEqual(len(self.info("seg.dcm")["grids"]), 1)

    def test_fractions(self):
        z, y, x = numpy.mgrid[:10, :40, :50]
        fractions = numpy.clip((5 - numpy.sqrt((z - 5) ** 2 + (y - 20) ** 2 + (x - 15) ** 2)) / 2, 0, 1)
        dicom.save(dicom.segmentation([fractions], ["F"], [None], kind="FRACTIONAL", full=100), self.folder / "seg.dcm")
        grids = self.info("seg.dcm")["grids"]
        self.assertEqual([grid["name"] for grid in grids], ["300 Segmentation", "F fraction"])
        stored = numpy.rint(fractions * 100)[1:10].astype(numpy.uint8)
        values, _ = self.field("seg.dcm", "--grid", "F fraction")
        numpy.testing.assert_allclose(values, stored / 100, atol=1e-6)
        self.assert_field(["seg.dcm", "--grid", "300 Segmentation"], (stored > 50).astype(numpy.uint8))


def find(document, name):
    """The first number of this name in a JSON document."""
    if isinstance(document, dict):
        if isinstance(document.get(name), (int, float)):
            return document[name]
        document = list(document.values())
    if isinstance(document, list):
        for part in document:
            found = find(part, name)
            if found is not None:
                return found
    return None


class DamageTest(DicomTestCase):
    def test_cut_files(self):
        dicom.save(dicom.enhanced(VOLUME, PLACES), self.folder / "whole.dcm")
        whole = (self.folder / "whole.dcm").read_bytes()
        for length in range(140, len(whole), len(whole) // 25):
            (self.folder / "cut.dcm").write_bytes(whole[:length])
            run = self.run_program("info", "cut.dcm")
            self.assertEqual(run.code, 2, f"{length} bytes: {run.text}{run.err}")
            self.assertIn("cut.dcm", run.err)

    def test_a_cut_slice_is_named(self):
        paths = dicom.write_series(self.folder / "scan", VOLUME, PLACES)
        whole = paths[3].read_bytes()
        for length in (200, len(whole) // 2, len(whole) - 1):
            paths[3].write_bytes(whole[:length])
            run = self.run_program("scan", "--iso", "0", "-o", "a.ply")
            self.assert_fails(2, run, "slice_003.dcm")

    def test_flipped_bytes_end_no_batch(self):
        random = numpy.random.default_rng(6)
        dicom.save(dicom.enhanced(VOLUME, PLACES), self.folder / "whole.dcm")
        whole = numpy.frombuffer((self.folder / "whole.dcm").read_bytes(), numpy.uint8)
        for k in range(12):
            damaged = whole.copy()
            damaged[random.integers(0, len(whole) - VOLUME.nbytes, 3)] = random.integers(0, 256, 3)
            damaged.tofile(self.folder / f"f{k}.dcm")
            run = self.run_program("info", f"f{k}.dcm")
            self.assertIn(run.code, (0, 2), run.err)

    def test_a_sequence_in_the_files_header(self):
        dicom.save(dicom.enhanced(VOLUME, PLACES), self.folder / "whole.dcm")
        whole = (self.folder / "whole.dcm").read_bytes()
        for kind, length in ((b"SQ", 0), (b"UN", 0xFFFFFFFF)):
            element = b"\x02\0\x02\x01" + kind + struct.pack("<HI", 0, length)
            (self.folder / "odd.dcm").write_bytes(whole[:144] + element + whole[144:])
            run = self.run_program("info", "odd.dcm")
            self.assert_fails(2, run, "odd.dcm", "found a sequence in the file's header")

    def test_a_deflated_file_of_nothing(self):
        image = dicom.image(VOLUME[0], PLACES[0], syntax=pydicom.uid.DeflatedExplicitVRLittleEndian)
        dicom.save(image, self.folder / "whole.dcm")
        whole = (self.folder / "whole.dcm").read_bytes()
        start = 144 + struct.unpack_from("<I", whole, 140)[0]  # the length of the file's header
        (self.folder / "empty.dcm").write_bytes(whole[:start] + b"\x03\0")
        run = self.run_program("info", "empty.dcm")
        self.assert_fails(2, run, "empty.dcm", "found the end: the file ends early")

    def test_pixels_without_attributes(self):
        dicom.save(dicom.image(VOLUME[0], PLACES[0]), self.folder / "whole.dcm")
        whole = (self.folder / "whole.dcm").read_bytes()
        start = 144 + struct.unpack_from("<I", whole, 140)[0]  # the length of the file's header
        pixels = whole.index(bytes.fromhex("e07f 1000"))
        (self.folder / "odd.dcm").write_bytes(whole[:start] + whole[pixels:])
        run = self.run_program("info", "odd.dcm")
        self.assert_fails(2, run, "odd.dcm", "expected attributes before the pixels, found none")

    def test_items_outside_of_sequences(self):
        dicom.save(dicom.enhanced(VOLUME, PLACES), self.folder / "whole.dcm")
        whole = (self.folder / "whole.dcm").read_bytes()
        length = whole.index(bytes.fromhex("2000 1391 5351 0000")) + 8
        (self.folder / "odd.dcm").write_bytes(whole[:length] + bytes(4) + whole[length + 4:])
        run = self.run_program("info", "odd.dcm")
        self.assert_fails(2, run, "odd.dcm", "found the start or end of an item: the header is damaged")

    def test_items_of_untyped_sequences(self):
        image = dicom.enhanced(VOLUME, PLACES, syntax=pydicom.uid.ImplicitVRLittleEndian)
        dicom.save(image, self.folder / "whole.dcm")
        whole = (self.folder / "whole.dcm").read_bytes()
        self.assertEqual(self.run_program("info", "whole.dcm").code, 0)
        position = whole.index(bytes.fromhex("2000 3200"), whole.index(bytes.fromhex("2000 1391")))
        (self.folder / "odd.dcm").write_bytes(whole[:position + 4] + struct.pack("<I", 1 << 30) + whole[position + 8:])
        run = self.run_program("info", "odd.dcm")
        self.assert_fails(2, run, "odd.dcm", f"expected an attribute of {1 << 30} bytes", "found")

    def test_sizes_are_not_trusted(self):
        data = dicom.image(VOLUME[0], PLACES[0])
        data.Rows = data.Columns = 65535
        dicom.save(data, self.folder / "huge.dcm")
        run = self.run_program("huge.dcm", "--iso", "0", "-o", "a.ply")
        self.assert_fails(2, run, "expected 8589672450 bytes of pixels", "found 70")


@needs_data(PHANTOM)
class PhantomTest(DicomTestCase):
    def test_surface_and_place(self):
        folder = DATA / PHANTOM
        self.convert(folder, "--iso", "200", "--space", "index", "-o", "x.ply", "--report", "r.json")
        run = self.run_program("check", "x.ply", "--json")
        area = find(json.loads(run.text), "area")
        self.assertLess(abs(area / 356417.7 - 1), 0.005)
        positions = numpy.array(read_ply((self.folder / "x.ply").read_bytes()).vertices)
        numpy.testing.assert_allclose(positions.min(0), (11.353, 33.864, 0), atol=0.02)
        numpy.testing.assert_allclose(positions.max(0), (481.284, 511, 27), atol=0.02)

        headers = [pydicom.dcmread(path, stop_before_pixels=True) for path in sorted(folder.glob("I*"))]
        headers.sort(key=lambda header: header.ImagePositionPatient[2])
        first, last = headers[0], headers[-1]
        row, column = numpy.array(first.ImageOrientationPatient).reshape(2, 3)
        step = (numpy.array(last.ImagePositionPatient) - numpy.array(first.ImagePositionPatient)) / (len(headers) - 1)
        expected = numpy.column_stack([row * first.PixelSpacing[1], column * first.PixelSpacing[0], step, first.ImagePositionPatient])
        report = json.loads((self.folder / "r.json").read_text())["input"]
        numpy.testing.assert_allclose(report["index_to_world"], expected, rtol=0, atol=1e-9)
        self.assertEqual(report["dims"], [512, 512, 28])
        self.assertIn("-1024", json.dumps(report["value_scale"]))


if __name__ == "__main__":
    main()
