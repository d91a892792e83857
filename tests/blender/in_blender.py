"""The add-on in Blender, without a display: imports sequences, steps the scene's frame, saves and loads.

Run by scripts/blender/check: blender -b --python-exit-code 1 --python in_blender.py -- ADDON.zip FOLDER
FOLDER has glb/f_K.glb and ply/f_K.ply of the same surfaces, K = 1, 2, 3, 5 and 10, and far/f_K.glb far from the origin.
What the files hold is read by the tests' own reader, not by the add-on's. FOLDER/saved.blend is left for rendered.py.
"""

import pathlib
import shutil
import sys
import unittest

import bpy
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))

import mesh_readers  # noqa: E402

ADDON, FOLDER = (pathlib.Path(argument) for argument in sys.argv[sys.argv.index("--") + 1:])
NUMBERS = [1, 2, 3, 5, 10]
# What frames 0 to 12 of the scene show: gaps and ends are held.
HELD = dict(zip(range(13), [1, 1, 2, 3, 3, 5, 5, 5, 5, 5, 10, 10, 10]))


def expected(path):
    """Vertices as Blender should have them, and the number of triangles, of a file of one mesh."""
    (mesh,) = mesh_readers.read(path)
    places = np.array(mesh.vertices)
    if path.suffix == ".glb":
        places = np.stack([places[:, 0], -places[:, 2], places[:, 1]], axis=1)
    return places, len(mesh.triangles)


def places_of(item):
    """Vertices of the evaluated object in the scene, in double: what is rendered."""
    mesh = item.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    flat = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3).astype(np.float64) + np.array(item.location)


def normals_of(mesh):
    """The normal that each vertex is shaded with, by its last corner."""
    if hasattr(mesh, "calc_normals_split"):  # before 4.1
        mesh.calc_normals_split()
    normals, vertices = np.empty(3 * len(mesh.loops), np.float32), np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("normal", normals)
    mesh.loops.foreach_get("vertex_index", vertices)
    result = np.zeros((len(mesh.vertices), 3), np.float32)
    result[vertices] = normals.reshape(-1, 3)
    return result


def import_sequence(*names, **options):
    """The objects that the add-on's operator makes of files of one folder."""
    before = set(bpy.data.objects)
    folder = FOLDER / names[0].split("/")[0]
    files = [{"name": name.split("/")[1]} for name in names]
    done = bpy.ops.import_mesh.isosurface_sequence(directory=str(folder), files=files, **options)
    assert done == {"FINISHED"}, done
    return sorted(set(bpy.data.objects) - before, key=lambda item: item.name)


class AddonTest(unittest.TestCase):
    def setUp(self):
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        bpy.context.scene.frame_set(1)

    def assert_shows(self, item, path):
        places, triangles = expected(path)
        found = places_of(item)
        self.assertEqual((len(found), len(item.data.polygons)), (len(places), triangles), path.name)
        size = np.abs(places).max() * 2.0**-22
        np.testing.assert_allclose(found, places, rtol=0, atol=size, err_msg=path.name)

    def test_every_frame_shows_its_file(self):
        for kind in ("glb", "ply"):
            (item,) = import_sequence(f"{kind}/f_3.{kind}")
            for frame, number in HELD.items():
                bpy.context.scene.frame_set(frame)
                self.assert_shows(item, FOLDER / kind / f"f_{number}.{kind}")
            self.assertEqual(item.isosurface_sequence.problem, "")

    def test_glb_and_ply_are_the_same_way_up(self):
        (glb,), (ply,) = import_sequence("glb/f_1.glb"), import_sequence("ply/f_1.ply")
        for frame in NUMBERS:
            bpy.context.scene.frame_set(frame)
            low, high = (np.sort(places_of(item), axis=0)[[0, -1]] for item in (glb, ply))
            np.testing.assert_allclose(low, high, atol=1e-6)

    def test_offset_loop_and_chosen_files(self):
        (item,) = import_sequence("glb/f_2.glb", "glb/f_5.glb", numbering="START", offset=10, ends="LOOP")
        # 2, 3, 4 (which is 3), 5 and again, from frame 11.
        for frame, number in {11: 2, 12: 3, 13: 3, 14: 5, 15: 2, 18: 5, 10: 5, 7: 2}.items():
            bpy.context.scene.frame_set(frame)
            self.assert_shows(item, FOLDER / "glb" / f"f_{number}.glb")

    def test_materials_modifiers_and_the_mesh_stay(self):
        (item,) = import_sequence("glb/f_1.glb")
        mesh, material = item.data, bpy.data.materials.new("water")
        mesh.materials.append(material)
        item.modifiers.new("smooth", "SMOOTH")
        for frame in NUMBERS:
            bpy.context.scene.frame_set(frame)
            self.assertIs(item.data, mesh)
            self.assertEqual([slot.material for slot in item.material_slots], [material])
            self.assertEqual(len(item.modifiers), 1)
        self.assertEqual(len(bpy.data.meshes), 1)

    def test_linked_duplicates_and_instances(self):
        (item,) = import_sequence("glb/f_1.glb")
        twin = item.copy()
        bpy.context.collection.objects.link(twin)
        bpy.context.scene.frame_set(2)
        self.assertIs(twin.data, item.data)
        twin.isosurface_sequence.start_frame = 0  # a frame earlier
        for frame, numbers in {2: (2, 3), 9: (5, 10), 1: (1, 2)}.items():
            bpy.context.scene.frame_set(frame)
            for shown, number in zip((item, twin), numbers):
                self.assert_shows(shown, FOLDER / "glb" / f"f_{number}.glb")
        # In a collection that is not in the scene, but an instance of it is.
        collection = bpy.data.collections.new("asset")
        collection.objects.link(twin)
        bpy.context.collection.objects.unlink(twin)
        empty = bpy.data.objects.new("instance", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
        bpy.context.collection.objects.link(empty)
        bpy.context.scene.frame_set(9)
        self.assertEqual(len(twin.data.polygons), expected(FOLDER / "glb" / "f_10.glb")[1])

    def test_normals_are_those_of_the_file(self):
        (item,) = import_sequence("glb/f_5.glb")
        bpy.context.scene.frame_set(5)
        (mesh,) = mesh_readers.read(FOLDER / "glb" / "f_5.glb")
        wanted = np.array(mesh.normals)
        wanted = np.stack([wanted[:, 0], -wanted[:, 2], wanted[:, 1]], axis=1)
        found = normals_of(item.data)
        self.assertLess(np.abs(found - wanted).max(), 5e-3)  # Blender keeps them as two 16-bit angles
        item.isosurface_sequence.normals = False
        self.assertGreater(np.abs(normals_of(item.data) - wanted).max(), 1e-2)
        item.isosurface_sequence.smooth = False
        self.assertFalse(item.data.polygons[0].use_smooth)

    def test_attributes_and_colors_come_along(self):
        folder = FOLDER / "attributes"
        folder.mkdir(exist_ok=True)
        for number in (1, 2):
            rows = "".join(f"{x} {y} {x * number} {number} {number} 0 0 1 255 0 127\n"
                           for x, y in ((0, 0), (1, 0), (0, 1)))
            (folder / f"a{number}.ply").write_text(
                "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                "property float density\nproperty int id\nproperty float velocity_0\nproperty float velocity_1\n"
                "property float velocity_2\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
                f"element face 1\nproperty list uchar int vertex_index\nend_header\n{rows}3 0 1 2\n")
        (item,) = import_sequence("attributes/a1.ply")
        for number in (1, 2):
            bpy.context.scene.frame_set(number)
            layers = item.data.attributes
            self.assertEqual([value.value for value in layers["density"].data], 3 * [number])
            self.assertEqual([value.value for value in layers["id"].data], 3 * [number])
            self.assertEqual(tuple(layers["velocity"].data[0].vector), (0, 0, 1))
            self.assertEqual(item.data.color_attributes.active_color.name, "Color")
            color = layers["Color"].data[1].color
            self.assertEqual((color[0], color[1], color[3]), (1, 0, 1))
            self.assertAlmostEqual(color[2], ((127 / 255 + 0.055) / 1.055) ** 2.4, places=6)

    def test_far_from_the_origin_nothing_is_rounded_away(self):
        (item,) = import_sequence("far/f_1.glb")
        for number in (1, 2):
            bpy.context.scene.frame_set(number)
            places, _ = expected(FOLDER / "far" / f"f_{number}.glb")
            found = places_of(item)  # added in double
            self.assertGreater(np.abs(places).max(), 1e6)
            self.assertLess(np.abs(found - places).max(), 1e-3)

    def test_a_damaged_file_is_told_and_the_last_frame_stays(self):
        folder = FOLDER / "damaged"
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(FOLDER / "glb", folder)
        (folder / "f_2.glb").write_bytes((FOLDER / "glb" / "f_2.glb").read_bytes()[:1000])
        (item,) = import_sequence("damaged/f_1.glb")
        bpy.context.scene.frame_set(2)
        self.assert_shows(item, FOLDER / "glb" / "f_1.glb")
        self.assertIn("f_2.glb: cut off", item.isosurface_sequence.problem)
        bpy.context.scene.frame_set(3)
        self.assert_shows(item, FOLDER / "glb" / "f_3.glb")
        self.assertEqual(item.isosurface_sequence.problem, "")
        # A file that is put right, or comes later, is seen.
        shutil.copy(FOLDER / "glb" / "f_2.glb", folder)
        shutil.copy(FOLDER / "glb" / "f_1.glb", folder / "f_4.glb")
        for frame, number in {2: 2, 4: 1}.items():
            bpy.context.scene.frame_set(frame)
            self.assert_shows(item, FOLDER / "glb" / f"f_{number}.glb")

    def test_what_cannot_be_read_makes_no_object(self):
        (FOLDER / "nothing.glb").write_text("nothing")
        with self.assertRaisesRegex(RuntimeError, "not a GLB file"):
            bpy.ops.import_mesh.isosurface_sequence(filepath=str(FOLDER / "nothing.glb"))
        self.assertEqual(len(bpy.data.objects), 0)

    def test_saved_and_loaded(self):
        (item,) = import_sequence("glb/f_1.glb")
        item.data.materials.append(bpy.data.materials.new("water"))
        name, path = item.name, str(FOLDER / "saved.blend")
        bpy.context.scene.frame_set(3)
        bpy.ops.wm.save_as_mainfile(filepath=path)
        bpy.context.scene.frame_set(1)
        bpy.ops.wm.open_mainfile(filepath=path)
        item = bpy.data.objects[name]
        self.assert_shows(item, FOLDER / "glb" / "f_3.glb")
        for frame, number in HELD.items():
            bpy.context.scene.frame_set(frame)
            self.assert_shows(item, FOLDER / "glb" / f"f_{number}.glb")
        self.assertEqual(item.material_slots[0].material.name, "water")

    def test_disabled_and_enabled_again(self):
        handlers = (bpy.app.handlers.frame_change_pre, bpy.app.handlers.load_post)
        before = [len(handler) for handler in handlers]
        for _ in range(2):
            bpy.ops.preferences.addon_disable(module="isosurface_sequence")
            self.assertEqual([len(handler) for handler in handlers], [count - 1 for count in before])
            self.assertFalse(hasattr(bpy.types.Object, "isosurface_sequence"))
            bpy.ops.preferences.addon_enable(module="isosurface_sequence")
            self.assertEqual([len(handler) for handler in handlers], before)
        self.assertEqual(len(import_sequence("glb/f_1.glb")), 1)

    def test_the_cache_stays_within_its_memory(self):
        from isosurface_sequence import playback

        preferences = bpy.context.preferences.addons["isosurface_sequence"].preferences
        (item,) = import_sequence("glb/f_1.glb")
        size = playback.read_surface(str(FOLDER / "glb" / "f_1.glb"), "FORMAT").bytes()
        preferences.cache_mib = 1
        for frame in NUMBERS + NUMBERS:
            bpy.context.scene.frame_set(frame)
            self.assertLessEqual(playback.cache.bytes(), max(1 << 20, 2 * size))
        self.assertEqual(playback.cache.limit, 1 << 20)
        preferences.cache_mib = playback.CACHE_MIB


if __name__ == "__main__":
    bpy.ops.preferences.addon_install(filepath=str(ADDON))
    bpy.ops.preferences.addon_enable(module="isosurface_sequence")
    result = unittest.main(argv=sys.argv[:1], exit=False).result
    sys.exit(not result.wasSuccessful())
