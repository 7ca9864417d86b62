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

# The canonical joints, without fingers, eyes and jaw.
BODY = frozenset((*_CENTRE, 'spine', 'chest', *(side + joint for side in ('left', 'right')
                                                for joint in _SIDED)))
# Fingers: words for them, and additional names. Three joints each, from the hand outwards.
_FINGERS = {
    'Thumb': (('thumb', 'handthumb'),
              (('firstmc', 'firstpp', 'firstdp'), ('finger0', 'finger01', 'finger02'))),
    'Index': (('index', 'handindex', 'findex', 'indexfinger'),
              (('secondpp', 'secondmp', 'seconddp'), ('finger1', 'finger11', 'finger12'))),
    'Middle': (('middle', 'handmiddle', 'fmiddle', 'middlefinger', 'mid'),
               (('thirdpp', 'thirdmp', 'thirddp'), ('finger2', 'finger21', 'finger22'))),
    'Ring': (('ring', 'handring', 'fring', 'ringfinger'),
             (('fourthpp', 'fourthmp', 'fourthdp'), ('finger3', 'finger31', 'finger32'))),
    'Little': (('little', 'handlittle', 'littlefinger', 'pinky', 'handpinky', 'fpinky', 'pinkyfinger'),
               (('fifthpp', 'fifthmp', 'fifthdp'), ('finger4', 'finger41', 'finger42')))}
_PHALANGES = ('Proximal', 'Intermediate', 'Distal')
_THUMB = ('Metacarpal', 'Proximal', 'Distal')
_NAMED = (('proximal', 'intermediate', 'distal'), ('proximal', 'medial', 'distal'))
_NUMBERED = (('1', '2', '3'), ('01', '02', '03'))


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


def _finger(names: _Names, side: str, finger: str) -> Dict[str, Optional[str]]:
    """The joints of one finger by the naming convention that matches most of them. Numbers and
    abbreviations are ambiguous, so for those the first two joints must exist."""
    words, others = _FINGERS[finger]
    named = _NAMED if finger != 'Thumb' else (('metacarpal', 'proximal', 'distal'),) + _NAMED
    ways = [(tuple(word + ending for ending in endings), endings in _NUMBERED)
            for word in words for endings in named + _NUMBERED]
    best: List[Optional[str]] = [None] * 3
    for way, strict in ways + [(other, True) for other in others]:
        found = [names.sided(side, name) for name in way]
        if strict and None in found[:2]:
            continue
        if found.count(None) < best.count(None):
            best = found
    joints = _THUMB if finger == 'Thumb' else _PHALANGES
    return {side + finger + joint: name for joint, name in zip(joints, best)}


def map_names(names: List[str]) -> Dict[str, str]:
    """Maps each canonical joint (leftUpperArm), and fingers, eyes and jaw by VRM 1.0's names, to its name
    in this skeleton; joints that are not found are missing."""
    table = _Names(names)
    found = {joint: table.centre(*aliases) for joint, aliases in _CENTRE.items()}
    if found['hips'] is None and table.centre('torso1') is not None:  # mocopi
        found['hips'] = table.centre('root')
    found['spine'], found['chest'] = _back(table)
    by_joint = table.sided('left', 'knee') is not None and table.sided('left', 'ankle') is not None
    for joint, aliases in (_SIDED_BY_JOINT if by_joint else _SIDED).items():
        for side in ('left', 'right'):
            found[side + joint] = table.sided(side, *aliases)
    for side in ('left', 'right'):
        for finger in _FINGERS:
            found.update(_finger(table, side, finger))
        found[side + 'Eye'] = table.sided(side, 'eye', 'eyeball', 'faceeye', 'eyesmplhf')
    found['jaw'] = table.centre('jaw', 'jawroot', 'lowerjaw')
    return {joint: name for joint, name in found.items() if name is not None}
