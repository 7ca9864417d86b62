"""BVH files of joints in the canonical axes, written and read. Needs only mathutils."""

from math import degrees, radians
from typing import List, NamedTuple

from mathutils import Matrix, Quaternion, Vector


class Joint(NamedTuple):
    name: str
    parent: int  # -1: the root, the first joint
    offset: Vector


class Clip(NamedTuple):
    joints: List[Joint]
    frame_s: float
    positions: List[Vector]            # of the root, per frame
    rotations: List[List[Quaternion]]  # parent from joint, per frame and joint


def write(path: str, clip: Clip) -> None:
    lines = ['HIERARCHY']
    order: List[int] = []  # of the joints in the file: depth first

    def write_joint(index: int, indent: str) -> None:
        joint = clip.joints[index]
        order.append(index)
        lines.append(f'{indent}{"JOINT" if index else "ROOT"} {joint.name}')
        lines.append(indent + '{')
        lines.append(f'{indent}  OFFSET ' + ' '.join(f'{x:.9g}' for x in joint.offset))
        place = '' if index else 'Xposition Yposition Zposition '
        lines.append(f'{indent}  CHANNELS {3 if index else 6} {place}Zrotation Xrotation Yrotation')
        children = [i for i, other in enumerate(clip.joints) if other.parent == index]
        for child in children:
            write_joint(child, indent + '  ')
        if not children:
            lines.extend([indent + '  End Site', indent + '  {', indent + '    OFFSET 0 0 0', indent + '  }'])
        lines.append(indent + '}')

    write_joint(0, '')
    lines += ['MOTION', f'Frames: {len(clip.positions)}', f'Frame Time: {clip.frame_s:.9g}']
    for position, rotations in zip(clip.positions, clip.rotations):
        numbers = list(position)
        for index in order:
            turn = rotations[index].to_euler('YXZ')  # Rz Rx Ry
            numbers += [degrees(turn.z), degrees(turn.x), degrees(turn.y)]
        lines.append(' '.join(f'{x:.7g}' for x in numbers))
    with open(path, 'w', encoding='utf-8') as out:
        out.write('\n'.join(lines) + '\n')


def read(path: str) -> Clip:
    """A file that `stylize` wrote. Raises ValueError."""
    with open(path, encoding='utf-8') as text:
        words = iter(text.read().split())
    joints: List[Joint] = []
    channels: List[List[str]] = []
    above: List[int] = []
    at, ended = -1, False
    frames = None
    try:
        for word in words:
            if word in ('ROOT', 'JOINT'):
                joints.append(Joint(next(words), above[-1] if above else -1, Vector()))
                channels.append([])
                at, ended = len(joints) - 1, False
            elif word == 'End':
                next(words)
                ended = True
            elif word == '{':
                above.append(at)
            elif word == '}':
                above.pop()
                ended = False
            elif word == 'OFFSET':
                offset = Vector([float(next(words)) for _ in range(3)])
                if not ended:
                    joints[at] = joints[at]._replace(offset=offset)
            elif word == 'CHANNELS':
                channels[at] = [next(words) for _ in range(int(next(words)))]
            elif word == 'Frames:':
                frames = int(next(words))
                next(words), next(words)  # Frame Time:
                frame_s = float(next(words))
                numbers = [float(number) for number in words]
    except (StopIteration, IndexError) as error:
        raise ValueError(f'{path}: no BVH file') from error
    if not joints or frames is None:
        raise ValueError(f'{path}: no BVH file')
    return _motion(joints, channels, frames, frame_s, numbers)


def _motion(joints, channels, frames, frame_s, numbers) -> Clip:
    width = sum(map(len, channels))
    if len(numbers) != frames * width:
        raise ValueError(f'{len(numbers)} numbers, expected {frames} frames of {width}')
    positions, rotations = [], []
    for begin in range(0, len(numbers), width):
        row = iter(numbers[begin:begin + width])
        turns = []
        for joint, names in enumerate(channels):
            place, turn = joints[joint].offset.copy(), Matrix.Identity(3)
            for name in names:
                value, axis = next(row), name[0]
                if name.endswith('position'):
                    place['XYZ'.index(axis)] = value
                else:
                    turn = turn @ Matrix.Rotation(radians(value), 3, axis)
            turns.append(turn.to_quaternion())
            if joint == 0:
                positions.append(place)
        rotations.append(turns)
    return Clip(joints, frame_s, positions, rotations)
