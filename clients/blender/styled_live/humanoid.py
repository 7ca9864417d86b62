"""Which bone of a skeleton is which joint of a humanoid, by its name: the habits that the daemon
knows (model/rig/joint_names.cpp), by the same rules. Knows nothing of Blender."""

import os
import re
from typing import Dict, List, Optional, Tuple

# Aliases are lower case without separators, the better one first.
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
# SMPL and MVN's BVH files name limbs by the joint, not by the bone below it.
_SIDED_BY_JOINT = {'Shoulder': ('collar',), 'UpperArm': ('shoulder',), 'LowerArm': ('elbow',),
                   'Hand': ('wrist',), 'UpperLeg': ('hip',), 'LowerLeg': ('knee',),
                   'Foot': ('ankle',), 'Toes': ('foot', 'toe', 'toes')}
# Spine and chest: the first pair of which both are there.
_BACKS = (('lowerback', 'spine'), ('lowerback', 'upperback'), ('l5', 't12'), ('ab', 'chest'),
          ('abdomen', 'chest'), ('torso2', 'torso4'), ('spine', 'chest'), ('spine', 'spine1'),
          ('spine', 'spine2'), ('spine01', 'spine02'), ('spine1', 'spine2'), ('chest', 'chest2'),
          ('spine', 'upperchest'), ('spine', 'thorax'))


def _folded(names: List[str]) -> Dict[str, str]:
    """Names without what exporters put before them, separators and case, to the names."""
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
    """Canonical joint (leftUpperArm) to the name that it has here; those that are not found are
    missing."""
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
