"""Converts the motion of FBX or glTF files to BVH, with Blender but without its window.

blender -b -P fbx_to_bvh.py -- walk.fbx [more.fbx ...]      writes walk.bvh beside each
"""
import pathlib
import sys

import bpy


def read(file):
    """Imports a file into an empty scene, at the file's own rate."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    if file.suffix.lower() == '.fbx':
        bpy.ops.import_scene.fbx(filepath=str(file))
    elif file.suffix.lower() in ('.glb', '.gltf', '.vrm'):
        bpy.ops.import_scene.gltf(filepath=str(file))
    else:
        raise ValueError('expected .fbx, .glb, .gltf or .vrm')


def write(file):
    """Exports the armature that has an action: of several the one with most bones."""
    moving = [thing for thing in bpy.data.objects
              if thing.type == 'ARMATURE' and thing.animation_data and thing.animation_data.action]
    if not moving:
        raise ValueError('found no armature that moves, expected one with an action')
    armature = max(moving, key=lambda thing: len(thing.data.bones))
    bpy.context.view_layer.objects.active = armature
    first, last = armature.animation_data.action.frame_range
    bpy.ops.export_anim.bvh(filepath=str(file), frame_start=round(first), frame_end=round(last),
                            root_transform_only=True)


def main(files):
    """Returns the number of files that were not converted."""
    failed = 0
    for name in files:
        file = pathlib.Path(name)
        try:
            if not file.is_file():
                raise ValueError('is not a file')
            read(file)
            write(file.with_suffix('.bvh'))
            print(f"{file} -> {file.with_suffix('.bvh')}")
        except (ValueError, RuntimeError, AttributeError) as error:
            print(f'fbx_to_bvh: {file}: {str(error).strip()}', file=sys.stderr)
            failed += 1
    return failed


given = sys.argv[sys.argv.index('--') + 1:] if '--' in sys.argv else []
if not given:
    sys.exit('expected files after --: blender -b -P fbx_to_bvh.py -- walk.fbx')
sys.exit(1 if main(given) else 0)
