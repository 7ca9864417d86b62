"""Turns the bytes of frames and bodies into numbers, without our code and without protobuf's: the wire
format (protobuf.dev/programming-guides/encoding) by hand, forward kinematics by matrices in double
precision. Every client must agree with these numbers."""
import struct

import numpy

# Of proto/styled/v1: number to name and kind. v: varint, s: signed varint, q: fixed64, t: text,
# f: floats, u: unsigned numbers, b: bytes, m: a message.
STYLE = {1: ('style', 't'), 2: ('weight', 'f')}
EXPRESSION = {1: ('name', 't'), 2: ('value', 'f')}
PROP = {1: ('name', 't'), 2: ('position', 'F'), 3: ('rotation', 'F')}
TIMECODE = {1: ('hours', 'v'), 2: ('minutes', 'v'), 3: ('seconds', 'v'), 4: ('frames', 'v'),
            5: ('rate', 'f'), 6: ('drop_frame', 'v')}
BODY = {1: ('performer', 't'), 2: ('names', 'T'), 3: ('parents', 'S'), 4: ('offsets', 'F'),
        5: ('rest', 'F'), 6: ('metres_per_unit', 'f'), 7: ('dialect', 't'), 8: ('hash', 'q'),
        9: ('output', 'v'), 10: ('output_name', 't')}
FRAME = {1: ('performer', 't'), 2: ('epoch', 'q'), 3: ('sequence', 'v'), 4: ('source_time_ns', 'v'),
         5: ('timecode', TIMECODE), 6: ('receive_time_ns', 'v'), 7: ('publish_time_ns', 'v'),
         8: ('wall_time_ns', 'v'), 9: ('body_hash', 'q'), 10: ('output', 'v'),
         11: ('root_position', 'F'), 12: ('rotations', 'F'), 13: ('held_joints', 'V'),
         14: ('contacts', 'v'), 15: ('flags', 'v'), 16: ('styles', [STYLE]), 17: ('source_sequence', 'v'),
         18: ('expressions', [EXPRESSION]), 19: ('thru', 'B'),
         20: ('props', [PROP])}


def varint(data, at):
    value = shift = 0
    while True:
        byte = data[at]
        value |= (byte & 127) << shift
        at, shift = at + 1, shift + 7
        if byte < 128:
            return value, at


def zigzag(value):
    return (value >> 1) ^ -(value & 1)


def varints(data):
    at, values = 0, []
    while at < len(data):
        value, at = varint(data, at)
        values.append(value)
    return values


def read(data, fields):
    """A message's fields by name; unknown fields are skipped, absent ones have their default."""
    empty = {'t': '', 'f': 0.0, 'v': 0, 's': 0, 'q': 0}
    message = {}
    for name, kind in fields.values():
        message[name] = empty[kind] if isinstance(kind, str) and kind in empty else \
            None if isinstance(kind, dict) else []
    at = 0
    while at < len(data):
        key, at = varint(data, at)
        number, wire = key >> 3, key & 7
        if wire == 0:
            value, at = varint(data, at)
        elif wire == 1:
            value, at = data[at:at + 8], at + 8
        elif wire == 2:
            size, at = varint(data, at)
            value, at = data[at:at + size], at + size
        elif wire == 5:
            value, at = data[at:at + 4], at + 4
        else:
            raise ValueError(f'wire type {wire}')
        if number not in fields:
            continue
        name, kind = fields[number]
        if kind == 't':
            message[name] = value.decode()
        elif kind == 'T':
            message[name].append(value.decode())
        elif kind == 'B':
            message[name].append(bytes(value))
        elif kind == 'f':
            message[name] = struct.unpack('<f', value)[0]
        elif kind == 'F':
            message[name] += struct.unpack(f'<{len(value) // 4}f', value)
        elif kind == 'S':
            message[name] += map(zigzag, varints(value))
        elif kind == 'V':
            message[name] += varints(value)
        elif kind == 'q':
            message[name] = struct.unpack('<Q', value)[0]
        elif isinstance(kind, list):
            message[name].append(read(value, kind[0]))
        elif isinstance(kind, dict):
            message[name] = read(value, kind)
        else:
            message[name] = value
    return message


def write(message, fields):
    """The opposite, for frames made by hand."""
    out = b''

    def number(value):
        text = b''
        while value > 127:
            text += bytes([value & 127 | 128])
            value >>= 7
        return text + bytes([value])

    def tagged(field, wire, data):
        return number(field << 3 | wire) + (number(len(data)) if wire == 2 else b'') + data

    for field, (name, kind) in fields.items():
        value = message.get(name)
        if value is None or value == [] or value == '':
            continue
        if kind == 't':
            out += tagged(field, 2, value.encode())
        elif kind == 'T':
            out += b''.join(tagged(field, 2, text.encode()) for text in value)
        elif kind == 'B':
            out += b''.join(tagged(field, 2, data) for data in value)
        elif kind == 'f':
            out += tagged(field, 5, struct.pack('<f', value))
        elif kind == 'F':
            out += tagged(field, 2, struct.pack(f'<{len(value)}f', *value))
        elif kind == 'S':
            out += tagged(field, 2, b''.join(number(v << 1 ^ v >> 31) for v in value))
        elif kind == 'V':
            out += tagged(field, 2, b''.join(map(number, value)))
        elif kind == 'q':
            out += tagged(field, 1, struct.pack('<Q', value))
        elif isinstance(kind, list):
            out += b''.join(tagged(field, 2, write(v, kind[0])) for v in value)
        elif isinstance(kind, dict):
            out += tagged(field, 2, write(value, kind))
        else:
            out += tagged(field, 0, number(value))
    return out


def matrix(q):
    x, y, z, w = numpy.array(q, float) / numpy.linalg.norm(numpy.array(q, float))
    return numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def quaternion(m):
    """x, y, z, w: the eigenvector of Bar-Itzhack's matrix (2000) with the largest eigenvalue."""
    k = numpy.array([[m[0, 0] - m[1, 1] - m[2, 2], 0, 0, 0],
                     [m[0, 1] + m[1, 0], m[1, 1] - m[0, 0] - m[2, 2], 0, 0],
                     [m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], m[2, 2] - m[0, 0] - m[1, 1], 0],
                     [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], numpy.trace(m)]])
    return numpy.linalg.eigh(k, 'L')[1][:, 3]


def world(body, frame):
    """Positions and rotations of all joints: a 4 x 4 matrix each, parent by parent."""
    joints = []
    for joint, parent in enumerate(body['parents']):
        local = numpy.eye(4)
        local[:3, :3] = matrix(frame['rotations'][4 * joint:4 * joint + 4])
        local[:3, 3] = frame['root_position'] if parent < 0 else body['offsets'][3 * joint:3 * joint + 3]
        joints.append(local if parent < 0 else joints[parent] @ local)
    return [j[:3, 3] for j in joints], [quaternion(j[:3, :3]) for j in joints]
