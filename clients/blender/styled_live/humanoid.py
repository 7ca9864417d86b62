"""Identifies the joints of a humanoid by their names, with the same conventions and rules as the daemon
(model/rig/joint_names.cpp). Independent of Blender."""

import os
import re
from typing import Dict, List, Optional, Tuple

# Aliases in lower case without separators, the preferred one first.
_CENTRE = {'hips': ('hips', 'hip', 'pelvis'), 'neck': ('neck', 'neck1', 'neck01', 'lowerneck'),
           'head': ('head',)}
_SIDED = {'Shoulder': ('shoulder', 'clavicle', 'collar'),
          'UpperArm': ('upperarm', 'arm', 'uarm', 'uparm', 'humerus'),
          'LowerArm': ('lowerarm', 'forearm', 'farm', 'lowarm', 'radius'),
          'Hand': ('hand', 'wrist'),
          'UpperLeg': ('upperleg', 'upleg', 'thigh', 'femur'),
          'LowerLeg': ('lowerleg', 'lowleg', 'leg', 'shin', 'calf', 'tibia'),
          'Foot': ('foot',),
          'Toes': ('toes', 'toe', 'toebase', 'toe0', 'ball')}
# SMPL and MVN's BVH files name limbs after the joint, not after the bone below it.
_SIDED_BY_JOINT = {'Shoulder': ('collar',), 'UpperArm': ('shoulder',), 'LowerArm': ('elbow',),
                   'Hand': ('wrist',), 'UpperLeg': ('hip',), 'LowerLeg': ('knee',),
                   'Foot': ('ankle',), 'Toes': ('foot', 'toe', 'toes')}
# Spine and chest: the first pair with both names present.
_BACKS = (('lowerback', 'spine'), ('lowerback', 'upperback'), ('l5', 't12'), ('ab', 'chest'),
          ('abdomen', 'chest'), ('torso2', 'torso4'), ('spine', 'chest'), ('spine', 'spine1'),
          ('spine', 'spine2'), ('spine01', 'spine02'), ('spine1', 'spine2'), ('chest', 'chest2'),
          ('spine', 'upperchest'), ('spine', 'thorax'))


def _folded(names: List[str]) -> Dict[str, str]:
    """Maps names without exporters' prefixes, separators and case to the names."""
    plain = [name.rsplit(':')[-1] for name in names]
    prefix = os.path.commonprefix(plain) if len(plain) > 2 else ''
    prefix = re.match(r'(.*[_ .-])?', prefix, re.S).group(0)
    folded: Dict[str, str] = {}
    for name, text in zip(names, plain):
        text = re.sub('[_ .-]', '', text[len(prefix):].lower())
        text = re.sub('^mixamorig[0-9]*', '', text)
        for habit in ('valvebiped', 'jbip', 'bip001', 'bip01', 'bip'):
            if text.startswith(habit) and text != habit:
                text = text[len(habit):]
        folded.setdefault(text, name)
    return folded


class _Names:
    def __init__(self, names: List[str]):
        self._folded = _folded(names)

    def centre(self, *aliases: str) -> Optional[str]:
        return self._first(form for alias in aliases for form in (alias, 'c' + alias))

    def sided(self, side: str, *aliases: str) -> Optional[str]:
        letter = side[0]
        return self._first(form for alias in aliases for form in (
            side + alias, alias + side, letter + alias, alias + letter))

    def _first(self, forms) -> Optional[str]:
        return next((self._folded[form] for form in forms if form in self._folded), None)


def _back(names: _Names) -> Tuple[Optional[str], Optional[str]]:
    for spine, chest in _BACKS:
        pair = names.centre(spine), names.centre(chest)
        if None not in pair:
            return pair
    return names.centre('spine'), names.centre('chest', 'upperchest', 'thorax')


def map_names(names: List[str]) -> Dict[str, str]:
    """Maps each canonical joint (leftUpperArm) to its name in this skeleton; joints that are not found
    are missing."""
    table = _Names(names)
    found = {joint: table.centre(*aliases) for joint, aliases in _CENTRE.items()}
    if found['hips'] is None and table.centre('torso1') is not None:  # mocopi
        found['hips'] = table.centre('root')
    found['spine'], found['chest'] = _back(table)
    by_joint = table.sided('left', 'knee') is not None and table.sided('left', 'ankle') is not None
    for joint, aliases in (_SIDED_BY_JOINT if by_joint else _SIDED).items():
        for side in ('left', 'right'):
            found[side + joint] = table.sided(side, *aliases)
    return {joint: name for joint, name in found.items() if name is not None}
