"""Builds an armature from a body: joints at their positions in the T-pose, in metres, +Z up, facing -Y
as Blender's figures do."""

from typing import Optional

import bpy
from mathutils import Vector

from . import skeleton

_SHORTEST_M = 0.01  # Blender deletes bones without length
_LEAF = 0.4         # fraction of the parent bone's length


def _tail(children, name, place) -> Optional[Vector]:
    """Where a bone ends: at its joint's child. With several children, at the one in the most vertical
    direction, which is the neck or the spine and not a shoulder or hip."""
    def steepness(child):
        step = place[child] - place[name]
        return -abs(step.z) / max(step.length, 1e-9) if len(children[name]) > 1 else 0

    for child in sorted(children[name], key=steepness):
        if (place[child] - place[name]).length > _SHORTEST_M:
            return place[child]
    return None


def make_armature(body, name: str, collection) -> 'bpy.types.Object':
    """A new armature object, selected and active, whose bones have the names of the body's joints.
    Blender must be in object mode."""
    rest = skeleton.rest_of_body(body)
    axes = skeleton.axes_of(rest)
    turn = skeleton.BLENDER_AXES.transposed()
    if axes is not None:
        turn = turn @ axes
    unit = skeleton.metres_per_unit(body, rest, axes)
    place = {joint: turn @ position * unit for joint, position in rest.positions.items()}
    children = {joint: [] for joint in rest.names}
    for joint, parent in enumerate(body.parents):
        if parent >= 0:
            children[rest.names[parent]].append(rest.names[joint])

    armature = bpy.data.armatures.new(name)
    made = bpy.data.objects.new(name, armature)
    collection.objects.link(made)
    for other in bpy.context.selected_objects:
        other.select_set(False)
    made.select_set(True)
    bpy.context.view_layer.objects.active = made
    bpy.ops.object.mode_set(mode='EDIT')
    for joint, parent in zip(rest.names, body.parents):
        bone = armature.edit_bones.new(joint)
        bone.head = place[joint]
        tail = _tail(children, joint, place)
        if parent >= 0:
            bone.parent = armature.edit_bones[rest.names[parent]]
            if tail is None:  # a leaf continues in its parent's direction
                onward = bone.head - bone.parent.head
                tail = bone.head + onward * _LEAF if onward.length * _LEAF > _SHORTEST_M else None
        bone.tail = bone.head + Vector((0, 0, 0.1)) if tail is None else tail
    bpy.ops.object.mode_set(mode='OBJECT')
    return made
