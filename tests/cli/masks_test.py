"""--masks: a folder or a list of masks, one file each, becomes the meshes of one label map; info lists the masks."""

import gzip
import json
import struct

from support import SOURCE, ProgramTest, main, needs_modules, read_glb, read_ply

needs_modules("numpy", "jsonschema")

import jsonschema  # noqa: E402
import numpy as np  # noqa: E402

from label_choice_test import open_edges, volume_of  # noqa: E402

SPACING = (0.5, 0.75, 2.0)
VOXEL = 0.5 * 0.75 * 2.0
NIFTI_TYPES = {"uint8": (2, 8), "int16": (4, 16), "uint16": (512, 16), "float32": (16, 32), "float64": (64, 64)}


def nifti(array, spacing=SPACING, origin=(0.0, 0.0, 0.0), scale=(1.0, 0.0)):
    """array[z, y, x] as the bytes of a NIfTI file with an sform."""
    code, bits = NIFTI_TYPES[str(array.dtype)]
    head = bytearray(352)
    struct.pack_into("<i", head, 0, 348)
    struct.pack_into("<8h", head, 40, 3, *array.shape[::-1], 1, 1, 1, 1)
    struct.pack_into("<hh", head, 70, code, bits)
    struct.pack_into("<8f", head, 76, 1, *spacing, 1, 1, 1, 1)
    struct.pack_into("<fff", head, 108, 352, *scale)
    head[123] = 2  # mm
    struct.pack_into("<h", head, 254, 1)  # sform_code
    for axis in range(3):
        row = [0.0, 0.0, 0.0, origin[axis]]
        row[axis] = spacing[axis]
        struct.pack_into("<4f", head, 280 + 16 * axis, *row)
    head[344:348] = b"n+1\0"
    return bytes(head) + array.tobytes()


def triangles_by_position(mesh):
    """The triangles as sets of positions, and how often each occurs does not matter."""
    return {frozenset(map(tuple, (mesh.vertices[v] for v in triangle))) for triangle in mesh.triangles}


class MasksTest(ProgramTest):
    def setUp(self):
        super().setUp()
        (self.folder / "seg").mkdir()
        z, y, x = np.mgrid[:20, :24, :28]
        self.left = (x - 8) ** 2 + (y - 12) ** 2 + (z - 10) ** 2 < 49  # two balls that touch at a plane
        self.right = ((x - 17) ** 2 + (y - 12) ** 2 + (z - 10) ** 2 < 64) & ~self.left
        self.box = (abs(x - 12) < 3) & (abs(y - 12) < 5) & (abs(z - 10) < 3)  # overlaps both

    def write(self, name, mask, kind="uint8", value=1, **placement):
        data = nifti(mask.astype(kind) * np.dtype(kind).type(value), **placement)
        path = self.folder / "seg" / name
        path.write_bytes(gzip.compress(data, 1) if name.endswith(".gz") else data)
        return f"seg/{name}"

    def write_balls(self):
        self.write("kidney_left.nii.gz", self.left)
        self.write("kidney_right.nii.gz", self.right)

    def meshes(self, *arguments, output="out.glb"):
        run = self.convert(*arguments, "-o", output)
        return read_glb((self.folder / output).read_bytes()), run

    def assert_is_mask(self, mesh, mask, part=1e-3):
        """Closed, with the volume of its voxels in mm^3, as --relax promises."""
        self.assertEqual(open_edges(mesh), 0)
        self.assertAlmostEqual(volume_of(mesh), mask.sum() * VOXEL, delta=part * mask.sum() * VOXEL)

    def test_a_folder_becomes_one_file(self):
        self.write_balls()
        (self.folder / "seg" / "statistics.json").write_text("{}")
        meshes, run = self.meshes("seg", "--masks")
        self.assertEqual(list(meshes), ["kidney_left", "kidney_right"])
        self.assert_is_mask(meshes["kidney_left"], self.left)
        self.assert_is_mask(meshes["kidney_right"], self.right)
        self.assertIn("note[other-files]: seg: the program takes 2 volume files (such as kidney_left.nii.gz) and skips 1 other "
                      "file (statistics.json)", run.err)
        self.assertNotIn("overlap", run.err)

    def test_the_default_name_is_that_of_the_folder(self):
        self.write_balls()
        for inputs in (["seg"], ["seg/"], ["seg/kidney_right.nii.gz", "seg/kidney_left.nii.gz"]):
            with self.subTest(inputs=inputs):
                self.convert(*inputs, "--masks")
                names = list(read_glb((self.folder / "seg.glb").read_bytes()))
                self.assertEqual(names, ["kidney_left", "kidney_right"])  # in natural order
                (self.folder / "seg.glb").unlink()

    def test_neighbors_share_faces_as_in_one_label_map(self):
        """The same bytes as the label map, but for names."""
        self.write_balls()
        labels = self.left.astype(np.uint8) + 2 * self.right.astype(np.uint8)
        (self.folder / "map.nii").write_bytes(nifti(labels))
        of_masks, _ = self.meshes("seg", "--masks")
        of_map, _ = self.meshes("map.nii", "--labels", "all", output="map.glb")
        for mask, label in zip(of_masks.values(), of_map.values()):
            self.assertEqual(mask.vertices, label.vertices)
            self.assertEqual(mask.triangles, label.triangles)
        left, right = map(triangles_by_position, of_masks.values())
        self.assertGreater(len(left & right), 50)

    def test_overlapping_masks_keep_all_voxels(self):
        self.write_balls()
        self.write("aorta.nii.gz", self.box)
        meshes, run = self.meshes("seg", "--masks")
        self.assertEqual(set(meshes), {"aorta", "kidney_left", "kidney_right"})
        for name, mask in (("aorta", self.box), ("kidney_left", self.left), ("kidney_right", self.right)):
            self.assert_is_mask(meshes[name], mask)
        shared = int((self.box & self.left).sum() + (self.box & self.right).sum())
        self.assertIn(f"note[masks-overlap]: seg/aorta.nii.gz and 2 more: {shared} voxels of masks are in earlier masks", run.err)
        self.assertIn("kidney_left, kidney_right", run.err)
        # The kidneys do not overlap each other: they have a layer together, and meet without gaps.
        left, right = (triangles_by_position(meshes[name]) for name in ("kidney_left", "kidney_right"))
        self.assertGreater(len(left & right), 50)

    def test_notes_are_about_the_chosen_masks(self):
        """The aorta overlaps both kidneys, which are therefore in another layer. The layers do not depend on the choice."""
        self.write_balls()
        self.write("aorta.nii.gz", self.box)
        self.write("empty.nii.gz", np.zeros_like(self.box))
        both, run = self.meshes("seg", "--masks")
        self.assertIn("no mesh for masks without voxels, 1 of 4: empty", run.err)
        shared = int((self.box & self.left).sum())
        for chosen, words in (("kidney*", None), ("aorta", None), ("3", None), ("all,!kidney_right", f"{shared} voxels of masks are"),
                              ("1,kidney_left", f"{shared} voxels of masks are")):
            meshes, run = self.meshes("seg", "--masks", "--labels", chosen)
            self.assertEqual("note[masks-overlap]" in run.err, words is not None, run.err)
            self.assertIn(words or "", run.err)
            self.assertEqual("note[labels-empty]" in run.err, chosen.startswith("all"), run.err)
            for name, mesh in meshes.items():
                self.assertEqual(mesh.vertices, both[name].vertices)
        meshes, run = self.meshes("seg", "--masks", "--labels-min-voxels", int(self.box.sum()) + 1)
        self.assertEqual(list(meshes), ["kidney_left", "kidney_right"])
        self.assertNotIn("note[masks-overlap]", run.err)

    def test_counts_are_of_all_layers(self):
        self.write_balls()
        self.write("aorta.nii.gz", self.box)  # in another layer than the kidneys
        self.assert_fails(2, self.run_program("seg", "--masks", "--labels", "spleen*", "-o", "none.glb"),
                          "the choice includes none of the 3 labels in the file")
        self.assert_fails(2, self.run_program("seg", "--masks", "--labels-min-voxels", "99999", "-o", "none.glb"),
                          "3 labels chosen, none with as many voxels as required")

    def test_masks_apart_because_of_one_without_a_mesh(self):
        self.write("a.nii", self.left)
        self.write("b.nii", self.left | self.right)
        apart = np.zeros_like(self.left)
        apart[:3] = True
        self.write("c.nii", apart)
        _, run = self.meshes("seg", "--masks", "--labels", "b,c")
        self.assertIn("note[masks-overlap]: seg/a.nii and 2 more: masks without a mesh have voxels of others, too, so the "
                      "meshes of 1 mask share no faces with the other meshes: b\n", run.err)

    def test_twelve_copies_are_twelve_meshes(self):
        """More layers than have a bit of their own."""
        for k in range(12):
            self.write(f"copy_{k}.nii", self.left)
        meshes, run = self.meshes("seg", "--masks", "--method", "voxels")
        self.assertEqual(list(meshes), [f"copy_{k}" for k in range(12)])  # in natural order
        for mesh in meshes.values():
            self.assertAlmostEqual(volume_of(mesh), self.left.sum() * VOXEL, delta=1e-3)
        self.assertIn(f"{11 * self.left.sum()} voxels of masks are in earlier masks", run.err)

    def test_values_and_types_of_masks(self):
        for kind, value in (("uint8", 255), ("int16", -3), ("uint16", 1000), ("float32", 1), ("float64", 0.5)):
            with self.subTest(kind=kind, value=value):
                name = self.write("mask.nii", self.left, kind, value)
                meshes, _ = self.meshes(name, "--masks")
                self.assertEqual(list(meshes), ["mask"])
                self.assert_is_mask(meshes["mask"], self.left)
        self.write("mask.nii", self.left, "int16", scale=(0.01, 0.0))
        self.assert_is_mask(self.meshes("seg/mask.nii", "--masks")[0]["mask"], self.left)

    def test_a_file_that_is_no_mask_is_refused(self):
        self.write_balls()
        self.write("ct.nii.gz", self.left, "int16", 1)
        ct = self.left.astype(np.int16) + 4 * self.right.astype(np.int16)
        (self.folder / "seg" / "ct.nii").write_bytes(nifti(ct))
        self.assert_fails(2, self.run_program("seg/kidney_left.nii.gz", "seg/ct.nii", "--masks", "-o", "out.glb"),
                          "seg/ct.nii: expected a mask, with 0 and one other value, found 4 and 1")
        probability = self.left.astype(np.float32)
        probability[3, 3, 3] = np.nan
        (self.folder / "seg" / "ct.nii").write_bytes(nifti(probability))
        self.assert_fails(2, self.run_program("seg/ct.nii", "--masks", "-o", "out.glb"), "nan")
        self.write("ct.nii", self.left, "int16", scale=(1.0, -1024.0))
        self.assert_fails(2, self.run_program("seg/ct.nii", "--masks", "-o", "out.glb"), "found scaled samples", "-1024")
        self.assertNotIn("out.glb", self.files())

    def test_other_grids_are_refused_with_both_grids(self):
        self.write_balls()
        self.write("z_other.nii", self.left[:-1])
        self.assert_fails(2, self.run_program("seg", "--masks", "-o", "out.glb"),
                          "the masks seg/kidney_left.nii.gz and seg/z_other.nii have different grids: 28 x 24 x 20 samples",
                          "; and 28 x 24 x 19 samples")
        self.write("z_other.nii", self.left, origin=(0.0, 0.0, 1.0))
        self.assert_fails(2, self.run_program("seg", "--masks", "-o", "out.glb"),
                          "first sample at (0, 0, 0); and", "first sample at (0, 0, 1)")
        self.write("z_other.nii", self.left, spacing=(0.5, 0.75, 2.001))  # 0.038 mm at the far end
        self.assert_fails(2, self.run_program("seg", "--masks", "-o", "out.glb"), "(0, 0, 2.001)")
        self.write("z_other.nii", np.zeros_like(self.left), origin=(0.0, 0.0, 1e-5))  # rounding
        self.convert("seg", "--masks", "-o", "out.glb")

    def test_empty_masks_are_told(self):
        self.write_balls()
        self.write("a_empty.nii.gz", np.zeros_like(self.left))
        meshes, run = self.meshes("seg", "--masks")
        self.assertEqual(list(meshes), ["kidney_left", "kidney_right"])
        self.assertIn("no mesh for masks without voxels, 1 of 3: a_empty", run.err)
        self.assert_fails(2, self.run_program("seg/a_empty.nii.gz", "--masks", "-o", "none.glb"), "no sample has a label")
        self.convert("seg/a_empty.nii.gz", "--masks", "--empty", "skip", "-o", "none.glb")
        self.assertNotIn("none.glb", self.files())
        asked = ("seg", "--masks", "--labels")
        self.assert_fails(2, self.run_program(*asked, "a_empty", "-o", "none.glb"), "no sample has the label 'a_empty'")
        run = self.convert(*asked, "a_empty,kidney_left,spleen", "--empty", "skip", "-o", "left.glb")
        self.assertIn("no sample has the label 'a_empty'", run.err)
        self.assertIn("no label matches 'spleen'", run.err)
        self.assertEqual(list(read_glb((self.folder / "left.glb").read_bytes())), ["kidney_left"])

    def test_a_full_mask_is_a_box(self):
        self.write("body.nii", np.ones_like(self.left))
        meshes, _ = self.meshes("seg", "--masks", "--method", "voxels")
        self.assertAlmostEqual(volume_of(meshes["body"]), self.left.size * VOXEL, delta=1e-3)

    def test_names_choose_masks_in_all_layers(self):
        self.write_balls()
        self.write("aorta.nii.gz", self.box)
        meshes, run = self.meshes("seg", "--masks", "--labels", "kidney*")
        self.assertEqual(list(meshes), ["kidney_left", "kidney_right"])
        self.assertNotIn("labels-unmatched", run.err)
        self.assert_fails(2, self.run_program("seg", "--masks", "--labels", "aorta,kidny_left", "-o", "none.glb"),
                          "no label is 'kidny_left'", "did you mean 'kidney_left'?")
        meshes, run = self.meshes("seg", "--masks", "--labels", "aorta,spleen", "--empty", "skip")
        self.assertEqual(list(meshes), ["aorta"])
        self.assertIn("no label matches 'spleen'", run.err)
        meshes, _ = self.meshes("seg", "--masks", "--labels", "2")
        self.assertEqual(list(meshes), ["kidney_left"])
        self.assert_fails(2, self.run_program("seg", "--masks", "--labels", "spleen", "-o", "none.glb"), "no label is 'spleen'", "the names are ")

    def test_numbers_follow_natural_order_in_a_list_too(self):
        for name, mask in (("10", self.left), ("2", self.box), ("1", self.right)):
            self.write(f"{name}.nii", mask)
        folder, _ = self.meshes("seg", "--masks", "--labels", "2")
        listed, _ = self.meshes("seg/1.nii", "seg/10.nii", "seg/2.nii", "--masks", "--labels", "2")
        self.assertEqual((list(folder), list(listed)), (["2"], ["2"]))

    def test_samples_of_a_header_are_no_mask(self):
        for name, mask in (("left", self.left), ("right", self.right)):
            sizes = " ".join(map(str, mask.shape[::-1]))
            (self.folder / "seg" / f"{name}.raw").write_bytes(mask.astype(np.uint8).tobytes())
            (self.folder / "seg" / f"{name}.nhdr").write_text(
                f"NRRD0004\ntype: uint8\ndimension: 3\nsizes: {sizes}\nencoding: raw\ndata file: {name}.raw\n\n")
        listed = [f"seg/{name}" for name in ("left.nhdr", "left.raw", "right.nhdr", "right.raw")]
        for inputs in (["seg"], listed):
            meshes, run = self.meshes(*inputs, "--masks")
            self.assertEqual(list(meshes), ["left", "right"])
            self.assertNotIn("other-files", run.err)
        self.assertEqual(run.err.count("note[placement-assumed]"), 1)  # not once for each mask
        # Without --masks, too: a header alone is one conversion, several are frames.
        self.assertNotIn("frames", self.convert(*listed[:2], "--iso", "0.5", "-o", "left.ply").err)
        self.convert(*listed, "--iso", "0.5", "-o", "of_{}.ply", "--jobs", "2")
        self.assertEqual([name for name in self.files() if name.startswith("of_")], ["of_1.ply", "of_2.ply"])

    def test_missing_folders_are_made_on_request(self):
        self.write_balls()
        self.assert_fails(4, self.run_program("seg", "--masks", "-o", "made/{name}.stl"), "made")
        self.convert("seg", "--masks", "-o", "made/{name}.stl", "--mkdir")
        self.assertEqual(sorted(path.name for path in (self.folder / "made").iterdir()), ["kidney_left.stl", "kidney_right.stl"])

    def test_a_file_for_each_mask(self):
        self.write_balls()
        self.convert("seg", "--masks", "-o", "{name}.ply")
        for name, mask in (("kidney_left", self.left), ("kidney_right", self.right)):
            self.assert_is_mask(read_ply((self.folder / f"{name}.ply").read_bytes()), mask)
        self.convert("seg", "--masks", "-o", "m_{label}.obj")
        self.assertTrue({"m_1.obj", "m_2.obj"} <= set(self.files()))

    def test_equal_names_of_two_folders(self):
        self.write_balls()
        (self.folder / "other").mkdir()
        (self.folder / "other" / "kidney_left.nii").write_bytes(nifti(self.right.astype(np.uint8)))
        meshes, _ = self.meshes("seg/kidney_left.nii.gz", "other/kidney_left.nii", "--masks")
        self.assertEqual(list(meshes), ["kidney_left label 1", "kidney_left label 2"])
        self.assert_is_mask(meshes["kidney_left label 1"], self.right)  # other/ comes before seg/
        self.assert_is_mask(meshes["kidney_left label 2"], self.left)
        self.convert("seg/kidney_left.nii.gz", "other/kidney_left.nii", "--masks", "-o", "{name}.stl")
        self.assertTrue({"kidney_left.stl", "kidney_left_2.stl"} <= set(self.files()))

    def test_many_masks(self):
        """104 masks, as TotalSegmentator writes; 300 need labels of 16 bits."""
        for count in (104, 300):
            with self.subTest(count=count):
                blocks = np.zeros((20, 24, 28), np.uint16)
                for k in range(count):
                    x, y, z = 2 * (k % 14), 2 * (k // 14 % 12), 2 * (k // 168)
                    blocks[z : z + 2, y : y + 2, x : x + 2] = k + 1
                    self.write(f"organ_{k + 1}.nii", blocks == k + 1)
                meshes, run = self.meshes("seg", "--masks", "--method", "voxels")
                self.assertEqual(list(meshes), [f"organ_{k + 1}" for k in range(count)])
                for mesh in meshes.values():
                    self.assertAlmostEqual(volume_of(mesh), 8 * VOXEL, delta=1e-3)
                self.assertNotIn("masks-overlap", run.err)

    def test_memory_does_not_grow_with_the_masks(self):
        """Each limit is what a few masks need, too."""
        size = 160
        mask = np.zeros((size, size, size), np.uint8)
        for k in range(20):
            mask[:] = 0
            mask[8 * k : 8 * k + 8, 40:80, 40:80] = 1
            self.write(f"m{k}.nii.gz", mask)
        run = self.convert("seg", "--masks", "--memory-limit", "64MiB", "-o", "out.glb")  # 20 masks are 78 MiB
        self.assertEqual(len(read_glb((self.folder / "out.glb").read_bytes())), 20)
        self.assertNotIn("overlap", run.err)

    def test_outputs_do_not_replace_masks(self):
        self.write("a.nii", self.left)
        self.write("b.nii", self.right)
        before = (self.folder / "seg" / "b.nii").read_bytes()
        run = self.run_program("seg", "--masks", "--format", "ply", "-o", "seg/b.nii")
        self.assertEqual(run.code, 1, run.err)
        self.assertEqual((self.folder / "seg" / "b.nii").read_bytes(), before)

    def test_the_report_has_the_files(self):
        self.write_balls()
        self.convert("seg", "--masks", "-o", "out.glb", "--report", "r.json")
        report = json.loads((self.folder / "r.json").read_text())
        jsonschema.validate(report, json.loads((SOURCE / "docs" / "schemas" / "report.schema.json").read_text()))
        self.assertEqual(report["options"]["masks"], ["seg/kidney_left.nii.gz", "seg/kidney_right.nii.gz"])
        self.assertEqual(report["options"]["input"], "seg")

    def test_options_that_do_not_go_with_masks(self):
        self.write_balls()
        for options in (["--iso", "0.5"], ["--volume", "0"], ["--label-names", "x.txt"], ["--background", "1"],
                        ["--frames", "1-2"], ["--jobs", "2"], ["--inside", "below"], ["--particles", "sph"], ["--radius", "2"],
                        ["--periodic", "x"]):
            with self.subTest(options=options):
                self.assert_fails(1, self.run_program("seg", "--masks", *options, "-o", "out.glb"),
                                  f"--masks and {options[0]} exclude each other")
        self.assert_fails(1, self.run_program("info", "seg", "--masks", "--stride", "2"),
                          "--masks and --stride exclude each other: the files of masks are volumes, not particles")
        for option, value, said in (("--method", "mc", "marching cubes"), ("--blur", "1", ""), ("--component", "length", "")):
            run = self.run_program("seg", "--masks", option, value, "-o", "out.glb")  # not --labels, which was not given
            self.assert_fails(1, run, f"--masks does not work with {said}" if said else " does not work with --masks: ")
        self.assert_fails(1, self.run_program("seg", "seg/kidney_left.nii.gz", "--masks"), "among several inputs")
        self.assert_fails(1, self.run_program("seg/kidney_left.nii.gz", "seg/kidney_left.nii.gz", "--masks"), "each mask once")
        self.assert_fails(1, self.run_program("-", "--masks", "-o", "out.glb"), "found stdin")
        self.assert_fails(2, self.run_program("seg/missing.nii", "--masks", "-o", "out.glb"), "seg/missing.nii")
        (self.folder / "none").mkdir()
        self.assert_fails(2, self.run_program("none", "--masks", "-o", "out.glb"), "none: no file in the folder")

    def test_files_that_look_like_masks_lead_to_the_option(self):
        self.write_balls()
        run = self.run_program("seg", "--labels", "all", "-o", "out.glb")
        self.assert_fails(1, run, "would both write this file", "use --masks if each file is a mask of one object, on one grid")
        text = self.convert("info", "seg").text
        self.assertIn("  command       isoextract seg --masks --labels all -o seg.glb\n", text)
        self.convert("seg", "--masks", "-o", "seg.glb")
        (report,) = json.loads(self.convert("info", "seg", "--json").text)
        jsonschema.validate([report], json.loads((SOURCE / "docs" / "schemas" / "info.schema.json").read_text()))
        self.assertEqual(report["suggestion"]["command"], "isoextract seg --masks --labels all -o seg.glb")
        both = self.left.astype(np.uint8) + 2 * self.right.astype(np.uint8)
        (self.folder / "seg" / "atlas.nii").write_bytes(nifti(both))
        self.assertIn("isoextract seg --labels all -o 'seg_{:04}.glb'", self.convert("info", "seg").text)

    def test_info_lists_the_masks(self):
        self.write_balls()
        self.write("aorta.nii.gz", self.box)
        self.write("empty.nii.gz", np.zeros_like(self.box))
        run = self.run_program("info", "seg", "--masks")
        self.assertEqual(run.code, 0, run.err)
        self.assertIn("masks: 3 with voxels, in 2 layers", run.text)
        self.assertIn("isoextract seg --masks --labels all -o seg.glb", run.text)
        self.assertIn("note[masks-overlap]", run.err)
        self.assertIn("empty", run.err)
        as_json = self.run_program("info", "seg", "--masks", "--json")
        document = json.loads(as_json.text)
        jsonschema.validate(document, json.loads((SOURCE / "docs" / "schemas" / "info.schema.json").read_text()))
        labels = document[0]["field"]["label_map"]["labels"]
        masks = {"aorta": self.box, "kidney_left": self.left, "kidney_right": self.right}
        self.assertEqual([label["name"] for label in labels], ["aorta", "kidney_left", "kidney_right"])
        for label in labels:
            mask = masks[label["name"]]
            self.assertEqual(label["voxels"], mask.sum())
            self.assertAlmostEqual(label["volume"], mask.sum() * VOXEL)
            where = np.argwhere(mask)[:, ::-1]
            self.assertEqual(label["box"], {"min": where.min(axis=0).tolist(), "max": where.max(axis=0).tolist()})
        command = document[0]["field"]["suggestion"]["command"].split()[1:]
        self.convert(*command)
        self.assertIn("seg.glb", self.files())
        listed = self.run_program("info", "seg/kidney_left.nii.gz", "seg/aorta.nii.gz", "--masks")
        self.assertIn("isoextract seg/kidney_left.nii.gz seg/aorta.nii.gz --masks --labels all -o seg.glb", listed.text)


if __name__ == "__main__":
    main()
