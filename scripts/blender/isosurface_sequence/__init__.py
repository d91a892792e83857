"""Isosurface sequences in Blender: numbered GLB or PLY files as one object whose mesh follows the scene's frame.

Modules that need Blender are imported by register(), so that the readers can be used, and tested, without it.
"""

bl_info = {
    "name": "Isosurface Sequence",
    "author": "isoextract",
    "description": "Imports numbered .glb and .ply files as one object whose mesh follows the frame",
    "version": (1, 0, 0),
    "blender": (3, 4, 0),
    "location": "File > Import > Isosurface sequence (.glb, .ply)",
    "category": "Import-Export",
}


def register():
    from . import interface, playback

    playback.register()
    interface.register()


def unregister():
    from . import interface, playback

    interface.unregister()
    playback.unregister()
