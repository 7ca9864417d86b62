"""Run by Blender: imports a BVH file and writes it as FBX. Arguments: IN.bvh OUT.fbx."""
import sys

import bpy
import io_anim_bvh.import_bvh as importer

# Blender 3.4 opens with mode 'rU', which Python 3.11 refuses; 'r' is the same.
importer.open = lambda path, _mode: open(path, encoding='utf-8')
source, target = sys.argv[sys.argv.index('--') + 1:]
bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
bpy.ops.import_anim.bvh(filepath=source, use_fps_scale=False, update_scene_fps=True)
bpy.ops.export_scene.fbx(filepath=target, add_leaf_bones=False, object_types={'ARMATURE'})
