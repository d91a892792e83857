"""What people see: the import operator and its menu entry, the object's panel, the preferences."""

import os

import bpy
import numpy as np
from bpy_extras.io_utils import ImportHelper

from . import playback
from .frames import EXTENSIONS, NUMBER, Sequence, sequences_of
from .surface import UnreadableFile


class ImportSequence(bpy.types.Operator, ImportHelper):
    """Import numbered mesh files as one object that shows the file of the scene's frame"""

    bl_idname = "import_mesh.isosurface_sequence"
    bl_label = "Import Isosurface Sequence"
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = EXTENSIONS[0]
    filter_glob: bpy.props.StringProperty(default=";".join("*" + e for e in EXTENSIONS), options={"HIDDEN"})
    files: bpy.props.CollectionProperty(type=bpy.types.OperatorFileListElement, options={"HIDDEN", "SKIP_SAVE"})
    directory: bpy.props.StringProperty(subtype="DIR_PATH", options={"HIDDEN", "SKIP_SAVE"})

    numbering: bpy.props.EnumProperty(
        name="Frames", default="NUMBER",
        items=[("NUMBER", "As Numbered", "The file of number n is shown at frame n of the scene"),
               ("START", "From Scene Start", "The first file is shown at the first frame of the scene")])
    offset: bpy.props.IntProperty(name="Offset", description="So many frames later")
    ends: bpy.props.EnumProperty(name="Before and After", default="HOLD", items=playback.ENDS)
    up: bpy.props.EnumProperty(name="Up Axis", default="FORMAT", items=playback.UP_AXES)

    def execute(self, context):
        folder, names = self.directory, [item.name for item in self.files if item.name]
        if not names:
            folder, name = os.path.split(bpy.path.abspath(self.filepath))
            names = [name]
        try:
            imported = [self.new_object(context, folder, *found) for found in sequences_of(folder, names)]
        except UnreadableFile as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for item in context.selected_objects:
            item.select_set(False)
        for item in imported:
            context.collection.objects.link(item)
            item.select_set(True)
            context.view_layer.objects.active = item
            missing = item.isosurface_sequence.sequence().missing()
            if missing:
                pattern = item.isosurface_sequence.pattern
                self.report({"WARNING"}, f"{pattern}: {missing} missing; the one before is shown")
            if item.isosurface_sequence.problem:
                self.report({"WARNING"}, item.isosurface_sequence.problem)
        return {"FINISHED"}

    def new_object(self, context, folder, pattern, first, last):
        """An object that shows the files of `pattern`; not in the scene yet."""
        sequence = Sequence.in_folder(folder, pattern)
        surface = playback.read_surface(sequence.path(first), self.up)
        name = os.path.splitext(pattern.replace(NUMBER, ""))[0].strip("_-. ") or "isosurface"
        item = bpy.data.objects.new(name, bpy.data.meshes.new(name))
        if surface.parts is not None:
            for _ in surface.part_names:  # a slot for each, so that each can have a material of its own
                item.data.materials.append(None)
        properties = item.isosurface_sequence
        properties.origin = surface.origin.astype(np.float32)
        item.location = properties.origin
        properties.pattern = pattern
        properties.first_number, properties.last_number = first, last
        properties.start_frame = self.offset + (context.scene.frame_start if self.numbering == "START" else first)
        properties.ends, properties.up = self.ends, self.up
        properties.folder = folder  # the last: from here on the object shows the sequence
        return item


class ReloadSequence(bpy.types.Operator):
    """Read the files again, and use those that have come since"""

    bl_idname = "object.isosurface_sequence_reload"
    bl_label = "Reload Isosurface Sequence"

    @classmethod
    def poll(cls, context):
        return context.object is not None and playback.shows_sequence(context.object)

    def execute(self, context):
        properties = context.object.isosurface_sequence
        playback.cache.clear()
        context.object.data.pop(playback.SHOWN, None)
        try:
            numbers = properties.sequence().numbers
            if numbers:
                properties.last_number = max(properties.last_number, numbers[-1])
        except UnreadableFile:
            pass  # show() tells
        playback.show(context.object, context.scene.frame_current)
        if properties.problem:
            self.report({"ERROR"}, properties.problem)
            return {"CANCELLED"}
        return {"FINISHED"}


SHOWN_PROPERTIES = (
    "folder", "pattern", "first_number", "last_number", "start_frame", "ends", "up", "smooth", "normals")


class SequencePanel(bpy.types.Panel):
    bl_idname = "OBJECT_PT_isosurface_sequence"
    bl_label = "Isosurface Sequence"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "object"

    @classmethod
    def poll(cls, context):
        return ReloadSequence.poll(context)

    def draw(self, context):
        properties = context.object.isosurface_sequence
        self.layout.use_property_split = True
        for name in SHOWN_PROPERTIES:
            self.layout.prop(properties, name)
        if properties.problem:
            self.layout.label(text=properties.problem, icon="ERROR")
        self.layout.operator(ReloadSequence.bl_idname, text="Reload", icon="FILE_REFRESH")


def _set_cache_limit(preferences, _context=None):
    playback.cache.limit = preferences.cache_mib << 20


class SequencePreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    cache_mib: bpy.props.IntProperty(
        name="Memory for Frames (MiB)", default=playback.CACHE_MIB, min=0, max=1 << 16, update=_set_cache_limit,
        description="So much of the frames shown last is kept, so that they need not be read again")

    def draw(self, _context):
        self.layout.prop(self, "cache_mib")


def _menu_entry(menu, _context):
    menu.layout.operator(ImportSequence.bl_idname, text="Isosurface sequence (.glb, .ply)")


CLASSES = (ImportSequence, ReloadSequence, SequencePanel, SequencePreferences)


def register():
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.TOPBAR_MT_file_import.append(_menu_entry)
    addon = bpy.context.preferences.addons.get(__package__)
    if addon is not None and addon.preferences is not None:
        _set_cache_limit(addon.preferences)


def unregister():
    bpy.types.TOPBAR_MT_file_import.remove(_menu_entry)
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
