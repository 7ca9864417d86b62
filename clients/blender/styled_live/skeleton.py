"""Rest skeletons of bodies and armatures: positions of their joints, and the axes that point up, left
and forward."""

from typing import Dict, List, NamedTuple, Optional

from mathutils import Matrix, Quaternion, Vector

from .humanoid import map_names

# Canonical axes (+X the body's left, +Y up, +Z forward) from Blender's (+X, +Z, -Y), by rows.
BLENDER_AXES = Matrix(((1, 0, 0), (0, 0, 1), (0, -1, 0)))


_HIPS_ABOVE_TOES_M = 0.96  # of the canonical humanoid


class Rest(NamedTuple):
    names: List[str]
    positions: Dict[str, Vector]
    rotations: Dict[str, Matrix]  # of bodies: world from joint in the T-pose
    humanoid: Dict[str, str]      # canonical joint to its name in this skeleton

    def at(self, canonical: str) -> Optional[Vector]:
        return self.positions.get(self.humanoid.get(canonical))

    def direction(self, start: str, end: str) -> Optional[Vector]:
        """The unit vector between two canonical joints."""
        start, end = self.at(start), self.at(end)
        if start is None or end is None or (end - start).length < 1e-9:
            return None
        return (end - start).normalized()


def quaternion(x: float, y: float, z: float, w: float) -> Quaternion:
    """From the component order of the wire."""
    return Quaternion((w, x, y, z))


def rest_of_body(body) -> Rest:
    """The T-pose, in the body's own units and axes."""
    names = list(body.names)
    positions, rotations = {}, {}
    for joint, name in enumerate(names):
        turn = quaternion(*body.rest[4 * joint:4 * joint + 4]) if body.rest else Quaternion()
        rotations[name] = turn.normalized().to_matrix()
        position = Vector(body.offsets[3 * joint:3 * joint + 3])
        if joint:
            parent = names[body.parents[joint]]
            position = positions[parent] + rotations[parent] @ position
        positions[name] = position
    return Rest(names, positions, rotations, map_names(names))


def rest_of_armature(armature) -> Rest:
    """The rest pose, in the armature's own space."""
    names = [bone.name for bone in armature.bones]
    return Rest(names, {bone.name: bone.head_local.copy() for bone in armature.bones}, {},
                map_names(names))


def _axis(direction: Vector) -> Vector:
    """The nearest signed axis."""
    largest = max(range(3), key=lambda i: abs(direction[i]))
    axis = Vector((0, 0, 0))
    axis[largest] = -1 if direction[largest] < 0 else 1
    return axis


def axes_of(rest: Rest) -> Optional[Matrix]:
    """The matrix from own to canonical axes, found like the daemon does: up from the hips to the head,
    left from the right thigh to the left one, forward where the toes point. Left-handed skeletons are
    supported; the matrix then contains a reflection. None if these joints are not known."""
    upward = rest.direction('hips', 'head') or rest.direction('hips', 'neck')
    leftward = rest.direction('rightUpperLeg', 'leftUpperLeg') or \
        rest.direction('rightUpperArm', 'leftUpperArm')
    if upward is None or leftward is None:
        return None
    up = _axis(upward)
    left = _axis(leftward - up * leftward.dot(up))
    ahead = left.cross(up)
    toes = rest.direction('leftFoot', 'leftToes')
    if toes is not None and toes.dot(ahead) < -0.2:
        ahead.negate()
    return Matrix((left, up, ahead))


def hips_height(rest: Rest, axes: Matrix) -> Optional[float]:
    """Height of the hips above the lowest of feet and toes, in own units."""
    hips = rest.at('hips')
    low = [rest.at(joint) for joint in ('leftFoot', 'rightFoot', 'leftToes', 'rightToes')]
    low = [axes[1].dot(place) for place in low if place is not None]
    if hips is None or not low:
        return None
    height = axes[1].dot(hips) - min(low)
    return height if height > 1e-6 else None


def metres_per_unit(body, rest: Rest, axes: Optional[Matrix]) -> float:
    """As the body states; else estimated from the height of the hips, like the daemon does."""
    if body.metres_per_unit > 0:
        return body.metres_per_unit
    height = None if axes is None else hips_height(rest, axes)
    return 1.0 if height is None else _HIPS_ABOVE_TOES_M / height


def floor(rest: Rest, axes: Matrix) -> float:
    """The height of the floor, in own units: 0, except for skeletons whose origin is at the hips the
    lowest joint."""
    height = hips_height(rest, axes)
    low = min(axes[1].dot(place) for place in rest.positions.values())
    return low if height is not None and low < -0.25 * height else 0.0
