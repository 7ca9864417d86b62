"""Skeletons at rest, those of bodies and those of armatures: where their joints are, and where up,
left and ahead are."""

from typing import Dict, List, NamedTuple, Optional

from mathutils import Matrix, Quaternion, Vector

from .humanoid import map_names

# Canonical axes (+X the body's left, +Y up, +Z ahead) from Blender's (+X, +Z, -Y), by rows.
BLENDER_AXES = Matrix(((1, 0, 0), (0, 0, 1), (0, -1, 0)))


_HIPS_ABOVE_TOES_M = 0.96  # of the canonical humanoid


class Rest(NamedTuple):
    names: List[str]
    positions: Dict[str, Vector]
    rotations: Dict[str, Matrix]        # of bodies: world from joint in the T-pose
    humanoid: Dict[str, str]            # canonical joint to the name that it has here

    def at(self, canonical: str) -> Optional[Vector]:
        return self.positions.get(self.humanoid.get(canonical))

    def direction(self, start: str, end: str) -> Optional[Vector]:
        """Between two canonical joints, of length 1."""
        start, end = self.at(start), self.at(end)
        if start is None or end is None or (end - start).length < 1e-9:
            return None
        return (end - start).normalized()


def quaternion(x: float, y: float, z: float, w: float) -> Quaternion:
    """From the order of the wire."""
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
    """In the armature's own space."""
    names = [bone.name for bone in armature.bones]
    return Rest(names, {bone.name: bone.head_local.copy() for bone in armature.bones}, {},
                map_names(names))


def _axis(direction: Vector) -> Vector:
    """The signed axis that is nearest."""
    largest = max(range(3), key=lambda i: abs(direction[i]))
    axis = Vector((0, 0, 0))
    axis[largest] = -1 if direction[largest] < 0 else 1
    return axis


def axes_of(rest: Rest) -> Optional[Matrix]:
    """Canonical from own axes, found as the daemon finds it: up goes from the hips to the head, left
    from the right thigh to the left one. Ahead is where the toes point: a left-handed skeleton is
    one, too, and its matrix mirrors. None where these joints are not known."""
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
    """From the lowest of feet and toes up to the hips, in own units."""
    hips = rest.at('hips')
    low = [rest.at(joint) for joint in ('leftFoot', 'rightFoot', 'leftToes', 'rightToes')]
    low = [axes[1].dot(place) for place in low if place is not None]
    if hips is None or not low:
        return None
    height = axes[1].dot(hips) - min(low)
    return height if height > 1e-6 else None


def metres_per_unit(body, rest: Rest, axes: Optional[Matrix]) -> float:
    """As the body says, or, like the daemon, by its hips' height."""
    if body.metres_per_unit > 0:
        return body.metres_per_unit
    height = None if axes is None else hips_height(rest, axes)
    return 1.0 if height is None else _HIPS_ABOVE_TOES_M / height


def lowest(rest: Rest, axes: Matrix) -> float:
    return min(axes[1].dot(place) for place in rest.positions.values())
