"""Restyles an armature's action by libstyled or the program `stylize`, without a daemon: the poses are exported as BVH and
imported as keyframes of a new action, on the same bones."""

import os
import shutil
import subprocess
import tempfile

import bpy
import styled
from mathutils import Quaternion, Vector
from styled import library
from styled.v1 import body_pb2, frame_pb2

from . import bvh, skeleton
from .bake import MAX_FRAMES, bake, undone_on_failure
from .drive import Plan, Unfit
from .humanoid import BODY

_TIMEOUT_S = 600


class Failed(Exception):
    """The text describes the error."""


class _Humanoid:
    """The humanoid's bones of an armature, as joints with the canonical axes."""

    def __init__(self, armature):
        rest = skeleton.rest_of_armature(armature)
        self._axes = skeleton.axes_of(rest)
        if self._axes is None or 'hips' not in rest.humanoid:
            raise Unfit('not a humanoid: hips, head or legs are missing, or have other names')
        # Fingers, eyes and jaw keep their own keyframes.
        bones = {bone: joint for joint, bone in rest.humanoid.items() if joint in BODY}
        self.names = [bone.name for bone in armature.bones if bone.name in bones]  # parents first
        self._rest = {name: armature.bones[name].matrix_local.to_3x3().normalized() for name in self.names}
        self._lift = Vector((0, -skeleton.floor(rest, self._axes), 0))
        self.joints = []
        for name in self.names:
            above = armature.bones[name].parent
            while above is not None and above.name not in bones:
                above = above.parent
            place = rest.positions[name] - (rest.positions[above.name] if above else Vector())
            parent = self.names.index(above.name) if above else -1
            offset = self._axes @ place + (Vector() if above else self._lift)
            self.joints.append(bvh.Joint(bones[name], parent, offset))
        if sum(joint.parent < 0 for joint in self.joints) != 1:
            raise Unfit('not a humanoid: the bones of the body are not all below its hips')

    def pose(self, pose_bones):
        """The root's position, and each joint's rotation relative to its parent."""
        world = []
        for name in self.names:
            turn = pose_bones[name].matrix.to_3x3().normalized() @ self._rest[name].transposed()
            world.append((self._axes @ turn @ self._axes.transposed()).to_quaternion())
        local = [turn if joint.parent < 0 else world[joint.parent].inverted() @ turn
                 for joint, turn in zip(self.joints, world)]
        return self._axes @ pose_bones[self.names[0]].head + self._lift, local


def restyle(scene, thing, style: str, strength: float, program: str) -> None:
    """Gives `thing` a copy of its action with the humanoid's bones in the style; the original is kept.
    Raises Failed or Unfit."""
    action, now = thing.animation_data.action, scene.frame_current
    humanoid = _Humanoid(thing.data)
    start, end = _range(action)
    fps = scene.render.fps / scene.render.fps_base
    positions, rotations = [], []
    try:
        for at in range(start, end + 1):
            scene.frame_set(at)
            place, turns = humanoid.pose(thing.pose.bones)
            positions.append(place)
            rotations.append(turns)
    finally:
        scene.frame_set(now)
    with tempfile.TemporaryDirectory(prefix='styled-') as folder:
        before, after = (os.path.join(folder, name) for name in ('before.bvh', 'after.bvh'))
        bvh.write(before, bvh.Clip(humanoid.joints, 1 / fps, positions, rotations))
        _stylize(program, style, strength, before, after)
        try:
            clip = bvh.read(after)
        except OSError as error:
            raise Failed(f"'{program}' has written no clip; is it stylize?") from error
    body, frames = _messages(clip, style)
    plan = Plan(body, thing.data)
    try:
        with undone_on_failure(thing):
            copy = action.copy()
            copy.name = f'{action.name} {style}'
            _forget(copy, thing, plan)
            thing.animation_data.action = copy
            bake(plan, frames, thing, fps, start)
        action.use_fake_user = True  # it is unused, and Blender would not save it
    finally:
        scene.frame_set(now)


def _range(action):
    """The first and the last frame that have keys."""
    if not any(len(curve.keyframe_points) for curve in action.fcurves):
        raise Failed(f'the action {action.name} has no keyframes')
    start, end = (round(x) for x in action.frame_range)
    if end - start >= MAX_FRAMES:
        raise Failed(f'the action {action.name} has {end - start + 1} frames, expected at most {MAX_FRAMES}')
    return start, end


# Without a program by libstyled in this process, else by stylize where it is installed.
def _stylize(program, style, strength, before, after) -> None:
    if not program:
        try:
            library.library_version()
        except styled.LibraryError as error:
            if shutil.which('stylize') is None:
                raise Failed(f'{error}; or give the path of the program stylize') from error
            program = 'stylize'
        else:
            try:
                styled.restyle(before, {style: strength}).write(after)
            except (styled.LibraryError, ValueError) as error:
                raise Failed(str(error)) from error
            return
    command = [program, '--style', style, '--strength', f'{strength:g}', before, after]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=_TIMEOUT_S)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise Failed(f"cannot run '{program}': {error}") from error
    if done.returncode != 0:
        raise Failed(done.stderr.strip().splitlines()[-1] if done.stderr.strip() else f'{program} failed')


# Bones that restyle does not move, fingers among them, keep their keys.
def _forget(action, thing, plan: Plan) -> None:
    paths = set()
    for name in plan.joints:
        path = thing.pose.bones[name].path_from_id()
        paths |= {f'{path}.rotation_{kind}' for kind in ('quaternion', 'euler', 'axis_angle')}
        if name in plan.moving():
            paths.add(f'{path}.location')
    for curve in list(action.fcurves):
        if curve.data_path in paths:
            action.fcurves.remove(curve)


def _messages(clip: bvh.Clip, style: str):
    body = body_pb2.Body(names=[joint.name for joint in clip.joints],
                         parents=[joint.parent for joint in clip.joints],
                         offsets=[x for joint in clip.joints for x in joint.offset],
                         metres_per_unit=1, hash=1, output=body_pb2.OUTPUT_CANONICAL)
    frames = []
    for index, (place, turns) in enumerate(zip(clip.positions, clip.rotations)):
        wire = [x for q in turns for x in (q.x, q.y, q.z, q.w)]
        frames.append(frame_pb2.Frame(performer=style, body_hash=1, output=body_pb2.OUTPUT_CANONICAL,
                                      source_time_ns=1 + round(index * clip.frame_s * 1e9),
                                      root_position=list(place), rotations=wire))
    if not frames:
        raise Failed('no frame was returned')
    return body, frames
