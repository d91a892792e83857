"""The object's properties, and the handler that shows the file of the scene's frame.

The mesh of the object stays the same data block; its geometry is replaced. So materials, modifiers and other users of
the mesh are kept, and a saved .blend holds one frame, whatever the length of the sequence.
"""

import bpy
from bpy.app.handlers import persistent

from .blender_mesh import fill
from .cache import SurfaceCache, stamp
from .frames import Sequence
from .surface import UnreadableFile

CACHE_MIB = 512
ENDS = [("HOLD", "Hold", "The first and the last file stay"), ("LOOP", "Loop", "The sequence repeats")]
UP_AXES = [("FORMAT", "As the Format Says", "y in GLB files, z in PLY files"),
           ("Y", "Y", "y of the files is up"), ("Z", "Z", "z of the files is up")]
SHOWN = "isosurface_file"  # on the mesh: what it holds, so that undo and loading take it along

cache = SurfaceCache(CACHE_MIB << 20)


def _changed(properties, _context):
    item = properties.id_data
    # A linked duplicate shows the same frame only as long as its properties are the same.
    if shows_sequence(item) and item.data.users > 1:
        item.data = item.data.copy()
    show(item, bpy.context.scene.frame_current)


class SequenceProperties(bpy.types.PropertyGroup):
    """What an object shows; saved with it."""

    folder: bpy.props.StringProperty(
        name="Folder", subtype="DIR_PATH", update=_changed, description="Where the files are; // is beside the .blend")
    pattern: bpy.props.StringProperty(
        name="Files", update=_changed, description="Name of the files; {} stands for the number")
    first_number: bpy.props.IntProperty(name="First", update=_changed, description="Number of the first file used")
    last_number: bpy.props.IntProperty(name="Last", update=_changed, description="Number of the last file used")
    start_frame: bpy.props.IntProperty(
        name="Start Frame", update=_changed, description="Frame of the scene that shows the first file")
    ends: bpy.props.EnumProperty(name="Before and After", update=_changed, default="HOLD", items=ENDS)
    up: bpy.props.EnumProperty(name="Up Axis", update=_changed, default="FORMAT", items=UP_AXES)
    smooth: bpy.props.BoolProperty(name="Shade Smooth", default=True, update=_changed)
    normals: bpy.props.BoolProperty(
        name="Normals of the Files", default=True, update=_changed,
        description="Shade with the normals that the files hold. Without, Blender makes its own, which is faster")
    # A Blender float has 32 bits; as these numbers become the object's location, so much is what they may have.
    origin: bpy.props.FloatVectorProperty(size=3, options={"HIDDEN"})
    problem: bpy.props.StringProperty(options={"HIDDEN", "SKIP_SAVE"})

    def sequence(self):
        """The files that are there now."""
        return Sequence.in_folder(bpy.path.abspath(self.folder, library=self.id_data.library), self.pattern)

    def path_at(self, frame):
        """The file that a frame of the scene shows."""
        sequence = self.sequence()
        number = sequence.number_at(frame, self.start_frame, self.first_number, self.last_number, self.ends == "LOOP")
        if number is None:
            raise UnreadableFile(
                f"{sequence.folder}: no file {self.pattern} from {self.first_number} to {self.last_number}")
        return sequence.path(number)


def read_surface(path, up):
    """A file's surface with z up."""
    return cache.surface(path, path.lower().endswith(".glb") if up == "FORMAT" else up == "Y")


def shows_sequence(item):
    properties = item.isosurface_sequence
    return item.type == "MESH" and bool(properties.folder and properties.pattern)


def show(item, frame):
    """Fills the object's mesh with the surface of a frame. A file that cannot be read leaves the mesh as it was; the
    add-on reports it once, and in the object's panel."""
    if not shows_sequence(item) or item.mode == "EDIT":
        return
    properties = item.isosurface_sequence
    problem = ""
    try:
        path = properties.path_at(frame)
        wanted = "|".join((stamp(path), properties.up, str(properties.smooth), str(properties.normals)))
        if item.data.get(SHOWN) != wanted:
            surface = read_surface(path, properties.up)
            fill(item.data, surface, properties.origin, properties.smooth, properties.normals)
            item.data[SHOWN] = wanted
    except UnreadableFile as error:
        problem = str(error)
    if properties.problem != problem:
        properties.problem = problem
        if problem:
            print(f"Isosurface sequence: {problem}")


def show_all(scene):
    """All objects of the scene, and those in no scene, which are in collections that others are instances of."""
    for item in bpy.data.objects:
        if shows_sequence(item):
            scenes = item.users_scene
            if not scenes or scene in scenes:
                show(item, scene.frame_current)


@persistent
def on_frame_change(scene, _depsgraph=None):
    # Before the scene is evaluated, so that modifiers run once, over the new mesh.
    show_all(scene)


@persistent
def on_load(_file=None):
    cache.clear()
    current = bpy.context.scene
    for scene in [scene for scene in bpy.data.scenes if scene != current] + [current]:
        show_all(scene)


def register():
    bpy.utils.register_class(SequenceProperties)
    bpy.types.Object.isosurface_sequence = bpy.props.PointerProperty(type=SequenceProperties)
    bpy.app.handlers.frame_change_pre.append(on_frame_change)
    bpy.app.handlers.load_post.append(on_load)


def unregister():
    bpy.app.handlers.load_post.remove(on_load)
    bpy.app.handlers.frame_change_pre.remove(on_frame_change)
    del bpy.types.Object.isosurface_sequence
    bpy.utils.unregister_class(SequenceProperties)
    cache.clear()
