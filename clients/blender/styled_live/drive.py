"""Puts frames on an armature: what can be known once is in a Plan, what each frame takes in
apply()."""

from typing import Dict, List, NamedTuple, Optional

from mathutils import Matrix, Vector
from styled import kinematics

from . import skeleton

# Limbs: rests differ there (A-pose, T-pose), and these swing the one to the other.
_LIMBS = [(side + start, side + end) for side in ('left', 'right')
          for start, end in (('UpperArm', 'LowerArm'), ('LowerArm', 'Hand'),
                             ('UpperLeg', 'LowerLeg'), ('LowerLeg', 'Foot'))]


class Unfit(ValueError):
    """Body and armature have too little in common; the text says what is missing."""


class _Step(NamedTuple):
    bone: str
    parent: Optional[str]
    joint: Optional[int]     # of the body; None: the bone stays as it is to its parent
    joint_rest: Matrix       # what a joint's world rotation is multiplied by for the bone's
    moves: bool              # has a place of its own: no bone above it follows a joint


class Plan:
    """How the joints of one body turn and move the bones of one armature, whatever rest pose, rolls,
    axes, handedness and size either of them has. A bone of a joint's very name follows it; where
    names differ, bones do that are the same joint of a humanoid. Holds names only, nothing of Blender's
    that undo or a new file could take away."""

    def __init__(self, body, armature):
        self.body = body
        self._source = skeleton.rest_of_body(body)
        self._target = skeleton.rest_of_armature(armature)
        self.joints = self._match()
        axes_source, axes_target = self._axes()
        self._turn = axes_target.transposed() @ axes_source  # armature from body; orthogonal
        self._unit, self._floor = self._measure(axes_source, axes_target)
        self._steps = self._plan(armature)

    def _match(self) -> Dict[str, int]:
        index = {name: joint for joint, name in enumerate(self._source.names)}
        joints = {name: index[name] for name in self._target.names if name in index}
        taken = set(joints.values())
        for canonical, bone in self._target.humanoid.items():
            joint = index.get(self._source.humanoid.get(canonical))
            if joint is not None and joint not in taken and bone not in joints:
                joints[bone] = joint
        if not joints:
            raise Unfit('no bone has the name of a joint, nor one that a humanoid\'s would have '
                        '(hips, leftUpperArm, mixamorig:LeftArm, upper_arm.L, ...)')
        return joints

    # A skeleton that is no humanoid is taken to have the other's axes, or, of bodies, glTF's.
    def _axes(self):
        source, target = skeleton.axes_of(self._source), skeleton.axes_of(self._target)
        if source is None:
            source = Matrix.Identity(3)
        return source, skeleton.BLENDER_AXES if target is None else target

    # Armature units per body unit, and where the armature's floor is, upward.
    def _measure(self, axes_source, axes_target):
        source = skeleton.hips_height(self._source, axes_source)
        target = skeleton.hips_height(self._target, axes_target)
        if source is None or target is None:
            return skeleton.metres_per_unit(self.body, self._source, axes_source), Vector()
        # Some armatures have their origin in the hips.
        low = skeleton.lowest(self._target, axes_target)
        floor = low if low < -0.25 * target else 0.0
        return target / source, axes_target[1] * floor

    def _plan(self, armature) -> List[_Step]:
        swings = self._swings()
        needed = set()
        for name in self.joints:
            bone = armature.bones[name]
            while bone is not None and bone.name not in needed:
                needed.add(bone.name)
                bone = bone.parent
        steps, led, swing_of = [], set(), {}
        for bone in armature.bones:  # parents first
            if bone.name not in needed:
                continue
            parent = bone.parent.name if bone.parent else None
            joint = self.joints.get(bone.name)
            swing = swings.get(bone.name, swing_of.get(parent, Matrix.Identity(3)))
            rest = None
            if joint is not None:
                rest = self._source.rotations[self._source.names[joint]].transposed() @ \
                    self._turn.transposed() @ swing @ bone.matrix_local.to_3x3().normalized()
            steps.append(_Step(bone.name, parent, joint, rest,
                               joint is not None and parent not in led))
            swing_of[bone.name] = swing
            if joint is not None or parent in led:
                led.add(bone.name)
        return steps

    # From the armature's rest to the body's T-pose, of limbs; hands and fingers go with the forearm,
    # feet, like all else, are taken to be alike.
    def _swings(self) -> Dict[str, Matrix]:
        swings = {}
        for start, end in _LIMBS:
            bone, here = self._target.humanoid.get(start), self._target.direction(start, end)
            there = self._source.direction(start, end)
            if bone in self.joints and here is not None and there is not None:
                swings[bone] = here.rotation_difference(self._turn @ there).to_matrix()
        for foot in ('leftFoot', 'rightFoot'):
            if foot in self._target.humanoid:
                swings[self._target.humanoid[foot]] = Matrix.Identity(3)
        return swings

    def apply(self, frame, armature_object) -> None:
        """Poses the armature. ValueError where the frame is of another body; KeyError where a bone
        has gone."""
        world = kinematics.world_transforms(self.body, frame)
        bones, pose_bones = armature_object.data.bones, armature_object.pose.bones
        poses: Dict[str, Matrix] = {}
        for step in self._steps:
            bone, pose_bone = bones[step.bone], pose_bones[step.bone]
            above = {}
            if step.parent is not None:
                above = {'parent_matrix': poses[step.parent],
                         'parent_matrix_local': bones[step.parent].matrix_local}
            if step.joint is None:
                poses[step.bone] = bone.convert_local_to_pose(
                    pose_bone.matrix_basis, bone.matrix_local, **above)
                continue
            pose = (self._turn @ skeleton.quaternion(*world[step.joint].rotation).to_matrix()
                    @ step.joint_rest).to_4x4()
            if step.moves:
                place = self._turn @ Vector(world[step.joint].position)
                pose.translation = place * self._unit + self._floor
            else:  # at rest to its parent
                pose.translation = bone.convert_local_to_pose(
                    Matrix.Identity(4), bone.matrix_local, **above).translation
            pose_bone.matrix_basis = bone.convert_local_to_pose(
                pose, bone.matrix_local, invert=True, **above)
            poses[step.bone] = pose
