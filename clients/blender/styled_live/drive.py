"""Applies frames to an armature. A Plan holds the data that is computed once; apply() does the work
of each frame."""

from typing import Dict, List, NamedTuple, Optional, Set

from mathutils import Matrix, Vector
from styled import kinematics

from . import skeleton

# Limbs, whose rest poses may differ (A-pose, T-pose); _swings() aligns one rest pose with the
# other.
_LIMBS = [(side + start, side + end) for side in ('left', 'right')
          for start, end in (('UpperArm', 'LowerArm'), ('LowerArm', 'Hand'),
                             ('UpperLeg', 'LowerLeg'), ('LowerLeg', 'Foot'))]


class Unfit(ValueError):
    """Body and armature have too little in common; the text states what is missing."""


class _Step(NamedTuple):
    bone: str
    parent: Optional[str]
    joint: Optional[int]  # of the body; None: the bone keeps its rest pose relative to its parent
    joint_rest: Matrix    # factor from a joint's world rotation to its bone's
    moves: bool           # has its own position: no bone above it follows a joint


class Plan:
    """Maps the joints of one body to the bones of one armature, for any rest poses, rolls, axes,
    handedness and sizes. A bone with a joint's exact name follows that joint; otherwise a bone follows
    the same joint of the humanoid. It holds names only, and no objects of Blender, which undo or
    loading a file could remove."""

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

    # A skeleton that is not a humanoid is assumed to have the other skeleton's axes, or glTF's for
    # a body.
    def _axes(self):
        source, target = skeleton.axes_of(self._source), skeleton.axes_of(self._target)
        if source is None:
            source = Matrix.Identity(3)
        return source, skeleton.BLENDER_AXES if target is None else target

    # Armature units per body unit, and the height of the armature's floor.
    def _measure(self, axes_source, axes_target):
        source = skeleton.hips_height(self._source, axes_source)
        target = skeleton.hips_height(self._target, axes_target)
        if source is None or target is None:
            return skeleton.metres_per_unit(self.body, self._source, axes_source), Vector()
        return target / source, axes_target[1] * skeleton.floor(self._target, axes_target)

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

    # Rotations of the limbs from the armature's rest pose to the body's T-pose. Hands and fingers
    # follow the forearm; feet and everything else are assumed to have the same rest pose.
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

    def bones(self, armature_object) -> list:
        """The armature's pose bones that follow a joint. Raises KeyError if one of the plan's bones no
        longer exists."""
        pose_bones = armature_object.pose.bones
        found = {step.bone: pose_bones[step.bone] for step in self._steps}
        return [found[name] for name in self.joints]

    def moving(self) -> Set[str]:
        """The bones that have a position of their own, not only a rotation."""
        return {step.bone for step in self._steps if step.moves}

    def apply(self, frame, armature_object) -> None:
        """Poses the armature. Raises ValueError if the frame belongs to another body, KeyError if a bone
        no longer exists."""
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
            else:  # rest pose relative to the parent
                pose.translation = bone.convert_local_to_pose(
                    Matrix.Identity(4), bone.matrix_local, **above).translation
            pose_bone.matrix_basis = bone.convert_local_to_pose(
                pose, bone.matrix_local, invert=True, **above)
            poses[step.bone] = pose
