"""Forward kinematics: from a frame's rotations to the joints' world transforms.

A frame contains, for each joint, its rotation relative to its parent (joint 0: to the world); a body
contains each joint's offset from its parent. Both use the body's own units and axes. The canonical
humanoid has metres, right-handed axes, +Y up, +Z forward, +X the body's left. Quaternions are
(x, y, z, w).
"""

import difflib
import functools
import math
from typing import Any, Iterator, List, NamedTuple, Optional, Sequence, Tuple, Union, overload

from styled.v1 import body_pb2, frame_pb2

MAX_JOINTS = 1024  # a larger body is considered a damaged message

Vector = Tuple[float, float, float]
Quaternion = Tuple[float, float, float, float]


class Transform(NamedTuple):
    """The transform of a joint in its skeleton's world."""
    position: Vector
    rotation: Quaternion  # world from joint, unit length


class World(Sequence[Transform]):
    """The joints of a skeleton in its world: a sequence of Transform in the order of `names`, and by
    name: world['head'], `'jaw' in world`, world.get('jaw'). Of several joints of one name the first
    counts. The number of joints, and their names beyond the 21 of the canonical humanoid, depend on
    the body: look them up by name.

    names      of the joints
    positions  J x 3, in the body's unit; an array where numpy is installed, else a list
    rotations  J x 4 (x, y, z, w), world from joint, unit length; the same
    """

    def __init__(self, names: Sequence[str], transforms: Sequence[Transform]):
        self.names: Tuple[str, ...] = tuple(names)
        self._transforms = transforms

    @property
    def positions(self) -> Any:
        return _array([t.position for t in self._transforms])

    @property
    def rotations(self) -> Any:
        return _array([t.rotation for t in self._transforms])

    def get(self, name: str, default: Optional[Transform] = None) -> Optional[Transform]:
        """The transform of the joint of this name, or `default`."""
        return self._transforms[self.names.index(name)] if name in self.names else default

    @overload
    def __getitem__(self, joint: Union[str, int]) -> Transform: ...

    @overload
    def __getitem__(self, joint: slice) -> Sequence[Transform]: ...

    def __getitem__(self, joint):
        if not isinstance(joint, str):
            return self._transforms[joint]
        if joint not in self.names:
            near = difflib.get_close_matches(joint, self.names, 3, 0.4) or self.names
            raise KeyError(f"no joint '{joint}'; there is {', '.join(near)}")
        return self._transforms[self.names.index(joint)]

    def __contains__(self, joint: object) -> bool:
        return joint in (self.names if isinstance(joint, str) else self._transforms)

    def __iter__(self) -> Iterator[Transform]:
        return iter(self._transforms)

    def __len__(self) -> int:
        return len(self._transforms)

    def __repr__(self) -> str:
        return f'World({len(self)} joints: {", ".join(self.names[:3])} ...)'


# Imported late: it takes longer than all the rest, and most programs need no arrays.
@functools.lru_cache(maxsize=None)
def _numpy() -> Any:
    try:
        import numpy
    except ImportError:
        return None
    return numpy


def _array(rows: List[Any]) -> Any:
    numpy = _numpy()
    return rows if numpy is None else numpy.array(rows)


def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """The rotation b followed by a."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz)


def rotate(q: Quaternion, v: Vector) -> Vector:
    """v rotated by the unit quaternion q."""
    x, y, z, w = q
    vx, vy, vz = v
    tx, ty, tz = 2 * (y * vz - z * vy), 2 * (z * vx - x * vz), 2 * (x * vy - y * vx)
    return (vx + w * tx + y * tz - z * ty, vy + w * ty + z * tx - x * tz,
            vz + w * tz + x * ty - y * tx)


def check_body(body: body_pb2.Body) -> str:
    """The error of a body; "" if it is valid."""
    joints = len(body.names)
    if not 1 <= joints <= MAX_JOINTS:
        return f'{joints} joints, expected 1 to {MAX_JOINTS}'
    if (len(body.parents), len(body.offsets)) != (joints, 3 * joints) or \
            len(body.rest) not in (0, 4 * joints):
        return f'parents, offsets or rest are not those of {joints} joints'
    if body.parents[0] != -1 or any(not 0 <= p < j for j, p in enumerate(body.parents) if j):
        return 'joint 0 is not the only root, or a parent does not precede its child'
    if not all(map(math.isfinite, body.offsets)):
        return 'an offset is not finite'
    return ''


def check_frame(frame: frame_pb2.Frame, body: body_pb2.Body) -> str:
    """The error of a frame on a body that passed check_body; "" if it is valid."""
    if frame.body_hash != body.hash or frame.output != body.output:
        return 'the frame is of another body'
    if len(frame.root_position) != 3 or len(frame.rotations) != 4 * len(body.names):
        return f'root_position or rotations are not those of {len(body.names)} joints'
    if not all(map(math.isfinite, frame.root_position)):
        return 'root_position is not finite'
    for i in range(0, len(frame.rotations), 4):
        if not _is_rotation(frame.rotations, i):
            return f'rotation of joint {i // 4} is zero or not finite'
    for prop in frame.props:
        if (len(prop.position), len(prop.rotation)) != (3, 4) or \
                not all(map(math.isfinite, prop.position)) or not _is_rotation(prop.rotation, 0):
            return f'position or rotation of prop "{prop.name}" is not 3 and 4 finite numbers'
    return ''


def _is_rotation(q: Sequence[float], i: int) -> bool:
    return 1e-12 <= q[i]**2 + q[i + 1]**2 + q[i + 2]**2 + q[i + 3]**2 < math.inf


def world_transforms(body: body_pb2.Body, frame: frame_pb2.Frame) -> World:
    """Forward kinematics: the world transform of each joint of `body`, in its order and by name, in
    `frame`. Raises ValueError if they do not belong together."""
    wrong = check_frame(frame, body)
    if wrong:
        raise ValueError(wrong)
    rotations, offsets, parents = frame.rotations, body.offsets, body.parents
    world: List[Transform] = []
    for joint, parent in enumerate(parents):
        x, y, z, w = rotations[4 * joint:4 * joint + 4]
        size = math.sqrt(x * x + y * y + z * z + w * w)
        local = (x / size, y / size, z / size, w / size)
        if parent < 0:
            world.append(Transform(tuple(frame.root_position), local))
            continue
        position, rotation = world[parent]
        dx, dy, dz = rotate(rotation, tuple(offsets[3 * joint:3 * joint + 3]))
        world.append(Transform((position[0] + dx, position[1] + dy, position[2] + dz),
                               multiply(rotation, local)))
    return World(body.names, world)


def world_arrays(body: body_pb2.Body, frame: frame_pb2.Frame) -> Tuple[Any, Any]:
    """World.positions and World.rotations."""
    world = world_transforms(body, frame)
    return world.positions, world.rotations
