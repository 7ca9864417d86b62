"""Run by Blender: imports each BVH file of a folder and writes blender.json beside them.

By file name either "error", the exception's text, or "hz" and "joints": by bone the place of its
head in each frame, in the file's unit and axes.
"""
import json
import pathlib
import re
import sys

import bpy
import io_anim_bvh.import_bvh as importer


def open_text(path, _mode):
    """Blender 3.4 opens with mode 'rU', which Python 3.11 refuses; 'r' is the same."""
    return open(path, 'r', encoding='utf-8')


importer.open = open_text


def places(armature, frames):
    """By bone the place of its head in each frame."""
    joints = {}
    for frame in range(1, frames + 1):
        bpy.context.scene.frame_set(frame)
        bpy.context.view_layer.update()
        for bone in armature.pose.bones:
            joints.setdefault(bone.name, []).append(list(armature.matrix_world @ bone.head))
    return joints


def read(file):
    """What Blender makes of a file, in an empty scene."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    # In Blender's own axes nothing is turned.
    bpy.ops.import_anim.bvh(filepath=str(file), axis_forward='Y', axis_up='Z', global_scale=1,
                            rotate_mode='NATIVE', frame_start=1, use_fps_scale=False,
                            update_scene_fps=True)
    armature = next(thing for thing in bpy.data.objects if thing.type == 'ARMATURE')
    frames = round(armature.animation_data.action.frame_range[1])
    render = bpy.context.scene.render
    return {'hz': render.fps / render.fps_base, 'joints': places(armature, frames)}


folder = pathlib.Path(sys.argv[sys.argv.index('--') + 1])
results = {}
for text in sorted(folder.glob('*.bvh')):
    try:
        results[text.stem] = read(text)
    except Exception as error:  # whatever the importer raises is its answer
        lines = str(error).strip().splitlines() or [type(error).__name__]
        said = [line for line in lines if re.match(r'\w*(Error|Exception)', line)]
        results[text.stem] = {'error': (said or lines)[-1]}
(folder / 'blender.json').write_text(json.dumps(results))
