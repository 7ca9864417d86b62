"""Makes keyframes from a performer's motion: a new action for an armature, with a key per frame of
the scene."""

import contextlib
from typing import List

import bpy

from .drive import Plan

MAX_FRAMES = 100_000  # of a take: 14 minutes at 120 Hz


def _times_s(frames) -> List[float]:
    """The time of each frame, relative to the first. If the rig's clock restarts, time continues by
    one step of 1/60 s."""
    times, before = [0.0], frames[0].source_time_ns
    for frame in frames[1:]:
        step_ns = frame.source_time_ns - before
        before = frame.source_time_ns
        times.append(times[-1] + (step_ns * 1e-9 if 0 < step_ns < 10e9 else 1 / 60))
    return times


# Keys of the scene's frames at `fps`. A sum of many steps may fall short by rounding.
def _keys(times_s: List[float], fps: float) -> int:
    return int(times_s[-1] * fps + 1e-3) + 1


@contextlib.contextmanager
def undone_on_failure(thing):
    """If the code inside fails, restores the armature's action and its bones' rotation modes, and removes
    actions that were made meanwhile."""
    animated = thing.animation_data is not None
    action = thing.animation_data.action if animated else None
    modes = {bone.name: bone.rotation_mode for bone in thing.pose.bones}
    actions = list(bpy.data.actions)
    try:
        yield
    except BaseException:
        if thing.animation_data is not None:
            thing.animation_data.action = action
        if not animated:
            thing.animation_data_clear()
        for bone in thing.pose.bones:
            bone.rotation_mode = modes.get(bone.name, bone.rotation_mode)
        for made in [other for other in bpy.data.actions if other not in actions]:
            bpy.data.actions.remove(made)
        raise


def bake(plan: Plan, frames, armature_object, fps: float, start: int) -> int:
    """Gives the armature keys in its action, or in a new one if it has none. The keys begin at the
    scene's frame `start`; at each frame from there on the armature has the pose of the performer's
    frame that is nearest in time. Bones that follow a joint get quaternions. `frames`: at least
    one, of the plan's body. Returns the scene's frame of the last key. Raises KeyError, before it
    changes anything, if a bone no longer exists."""
    bones = plan.bones(armature_object)
    animation = armature_object.animation_data_create()
    if animation.action is None:
        animation.action = bpy.data.actions.new(f'{armature_object.name} {frames[0].performer}')
    moving = plan.moving()
    for bone in bones:
        bone.rotation_mode = 'QUATERNION'
    times = _times_s(frames)
    keys = _keys(times, fps)
    nearest, before = 0, {}
    for key in range(keys):
        at = key / fps
        while nearest + 1 < len(times) and abs(times[nearest + 1] - at) <= abs(times[nearest] - at):
            nearest += 1
        plan.apply(frames[nearest], armature_object)
        for bone in bones:
            turn = bone.rotation_quaternion.copy()
            if bone.name in before:
                # No turn the long way round between two keys.
                turn.make_compatible(before[bone.name])
                bone.rotation_quaternion = turn
            before[bone.name] = turn
            bone.keyframe_insert('rotation_quaternion', frame=start + key, group=bone.name)
            if bone.name in moving:
                bone.keyframe_insert('location', frame=start + key, group=bone.name)
    return start + keys - 1
