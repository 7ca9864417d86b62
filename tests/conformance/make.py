#!/usr/bin/env python3
"""Makes the goldens: bodies and frames as the real daemon publishes them, and some by hand, with what
wire.py reads from them. `make.py` writes them again (STYLED_BIN: the programs); `make.py --check` reads
the bytes that are here again and compares the numbers."""
import base64
import json
import os
import sys

import wire

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.join(HERE, '..', '..')
FIELDS = ('performer', 'epoch', 'sequence', 'source_time_ns', 'receive_time_ns', 'publish_time_ns',
          'wall_time_ns', 'body_hash', 'output', 'held_joints', 'contacts', 'flags', 'styles', 'timecode',
          'source_sequence', 'expressions', 'thru', 'props')
BIG = ('epoch', 'body_hash', 'hash', 'sequence', 'source_time_ns', 'receive_time_ns', 'publish_time_ns',
       'wall_time_ns', 'source_sequence')


def rounded(numbers):
    return [float(f'{x:.9g}') + 0.0 for x in numbers]


def plain(message, names):
    """As in JSON: 64-bit numbers as text, since JSON's are doubles in many languages; bytes in
    base64."""
    def value(name):
        if name == 'thru':
            return [base64.b64encode(data).decode() for data in message[name]]
        return str(message[name]) if name in BIG else message[name]

    return {name: value(name) for name in names}


def case(body_bytes, frames_bytes):
    body = wire.read(body_bytes, wire.BODY)
    made = {'body': body_bytes.hex(),
            'body_fields': plain(body, [name for name, _ in wire.BODY.values()]), 'frames': []}
    for frame_bytes in frames_bytes:
        frame = wire.read(frame_bytes, wire.FRAME)
        positions, rotations = wire.world(body, frame)
        made['frames'].append({'frame': frame_bytes.hex(), 'fields': plain(frame, FIELDS),
                               'positions': [rounded(p) for p in positions],
                               'rotations': [rounded(q) for q in rotations]})
    return made


def live(options, topic, rig_type='udp'):
    """Three frames, a third of a second apart, of a topic, and their body."""
    import subprocess

    import zmq

    sys.path.insert(0, os.path.join(ROOT, 'tests', 'e2e', 'python'))
    from daemon import BIN, Daemon
    daemon = Daemon(source=rig_type)
    sim = subprocess.Popen([os.path.join(BIN, 'stylesim'), '--to', 'udp://' + daemon.udp, *options],
                           stdout=subprocess.DEVNULL)
    bodies, frames = {}, []
    try:
        with zmq.Context() as context, context.socket(zmq.SUB) as socket:
            socket.connect(daemon.publish)
            performer = topic.split('/')[1]
            for prefix in (f'body/{performer}/', topic):
                socket.setsockopt_string(zmq.SUBSCRIBE, prefix)
            while len(frames) < 100 or not bodies:
                name, payload = socket.recv_multipart()
                if name.startswith(b'body/'):
                    body = wire.read(payload, wire.BODY)
                    bodies[body['hash'], body['output']] = payload
                else:
                    frames.append(payload)
    finally:
        sim.kill()
        sim.wait()
        daemon.close()
    last = wire.read(frames[-1], wire.FRAME)
    return case(bodies[last['body_hash'], last['output']], [frames[i] for i in (19, 59, 99)])


def hand_body(**changes):
    body = {'performer': 'rig.anna', 'names': ['root', 'knee', 'foot', 'Arm_äö'],
            'parents': [-1, 0, 1, 0], 'offsets': [0, 90, 0, 1.5, -40, 0.25, 0, -42, 3, 20, 55, -1],
            'metres_per_unit': 0.01, 'dialect': 'auto', 'hash': 0xFEDCBA9876543210, 'output': 1}
    return wire.write({**body, **changes}, wire.BODY)


def hand_prop(**changes):
    return {'name': 'sword', 'position': [-60.5, 120, 30.25], 'rotation': [0.1, -0.7, 0.7, -0.1], **changes}


def hand_frame(**changes):
    frame = {'performer': 'rig.anna', 'epoch': 0xFFFFFFFFFFFFFFF1, 'sequence': 9007199254740993,
             'source_time_ns': 18446744073709551615,
             'timecode': {'hours': 23, 'minutes': 59, 'seconds': 58, 'frames': 28, 'rate': 29.97,
                          'drop_frame': 1},
             'receive_time_ns': 9223372036854775809, 'publish_time_ns': 9223372036854775810,
             'wall_time_ns': 1700000000123456789, 'body_hash': 0xFEDCBA9876543210, 'output': 1,
             'root_position': [-12.5, 88, 1000.125],
             'rotations': [0, 1, 0, 0, 0.5, 0.5, 0.5, -0.5, 0.2, -0.3, 0.1, 0.9, 0, 0, 2, 2],
             'held_joints': [1, 300], 'contacts': 3, 'flags': 0x98,
             'styles': [{'style': 'elderly', 'weight': 0.25}, {'style': 'not-confident', 'weight': 1.5}],
             'source_sequence': 41,
             'expressions': [{'name': 'Joy', 'value': 0.75}, {'name': 'jaw_öffnen', 'value': 0.1}],
             'thru': [b'/VMC/x\0\0,i\0\0\xff\0\x80\1', b''],
             'props': [hand_prop(), hand_prop(name='stühle', position=[1e-3, 0, -7e4])]}
    return wire.write({**frame, **changes}, wire.FRAME)


def hand():
    """Quaternions of any length and either sign; every field; one of a later version."""
    later = b'\xa2\x3f\x03new' + b'\xa8\x3f\x07'
    body = hand_body(rest=[0, 0, 0, 1, 0.6, 0, 0, 0.8, 0, 1, 0, 0, 0.5, 0.5, -0.5, 0.5], output_name='Anna')
    return case(body, [hand_frame(), hand_frame() + later,
                       hand_frame(timecode=None, styles=[], held_joints=[], contacts=None, flags=None,
                                  expressions=[], thru=[], props=[], rotations=[0, 0, 0, -1e-3] * 4)])


def refused():
    nan, inf = float('nan'), float('inf')
    four = [0, 0, 0, 1]
    bodies = {
        'no joint': hand_body(names=[], parents=[], offsets=[]),
        'a parent too few': hand_body(parents=[-1, 0, 1]),
        'an offset too many': hand_body(offsets=[0] * 13),
        'rest of another size': hand_body(rest=four * 3),
        'joint 0 has a parent': hand_body(parents=[0, 0, 1, 0]),
        'two roots': hand_body(parents=[-1, -1, 1, 0]),
        'a parent behind its child': hand_body(parents=[-1, 2, 1, 0]),
        'a joint is its own parent': hand_body(parents=[-1, 0, 2, 0]),
        'an offset is not a number': hand_body(offsets=[0] * 11 + [nan]),
        'an offset is infinite': hand_body(offsets=[0] * 11 + [inf]),
        '1025 joints': hand_body(names=[str(i) for i in range(1025)], parents=[-1] + [0] * 1024,
                                 offsets=[0] * 3075),
        'cut short': hand_body()[:-1],
    }
    frames = {
        'of another body': hand_frame(body_hash=1),
        'of another output': hand_frame(output=2),
        'a rotation too few': hand_frame(rotations=four * 3),
        'a number too many': hand_frame(rotations=four * 4 + [0]),
        'no root': hand_frame(root_position=[]),
        'root of two numbers': hand_frame(root_position=[1, 2]),
        'root is not a number': hand_frame(root_position=[0, nan, 0]),
        'a rotation is not a number': hand_frame(rotations=four * 3 + [0, 0, nan, 1]),
        'a rotation is infinite': hand_frame(rotations=four * 3 + [0, 0, inf, 1]),
        'a rotation of no length': hand_frame(rotations=four * 3 + [0, 0, 0, 0]),
        'a prop of two numbers': hand_frame(props=[hand_prop(position=[1, 2])]),
        'a prop without a rotation': hand_frame(props=[hand_prop(rotation=[])]),
        'a prop is not a number': hand_frame(props=[hand_prop(), hand_prop(position=[0, nan, 0])]),
        'a prop of no rotation': hand_frame(props=[hand_prop(rotation=[0, 0, 0, 0])]),
        'cut short': hand_frame()[:-1],
        'a length beyond the end': hand_frame() + b'\x0a\x7f',
        'a wire type that is none': hand_frame() + b'\x0f',
    }
    return {'body': hand_body().hex(),
            'bodies': [{'why': why, 'body': data.hex()} for why, data in bodies.items()],
            'frames': [{'why': why, 'frame': data.hex()} for why, data in frames.items()]}


def path(name):
    return os.path.join(HERE, name + '.json')


def make():
    clip = os.path.join(ROOT, 'tests', 'parity', 'fixtures', 'synthetic.bvh')
    walk = ['--script', 'walk:1,wave-left:1,turn-left:1']
    goldens = {
        'canonical': live(walk, 'styled/rig.sim/canonical/'),
        'fifty-five-joints': live(['--as', 'vmc', '--quirk', 'full', '--rate', '60'] + walk,
                                  'styled/rig.rig/rig/', 'vmc'),
        'centimetres': live(['--bvh', clip, '--loop'], 'source/rig.sim/'),
        'hand': hand(),
        'refused': refused(),
    }
    for name, golden in goldens.items():
        with open(path(name), 'w') as out:
            json.dump(golden, out, indent=None, separators=(',', ':'))
            out.write('\n')


def check():
    """Whether the numbers in the files are those of the bytes in them."""
    for name in ('canonical', 'fifty-five-joints', 'centimetres', 'hand'):
        with open(path(name)) as text:
            golden = json.load(text)
        again = case(bytes.fromhex(golden['body']),
                     [bytes.fromhex(frame['frame']) for frame in golden['frames']])
        near(again, golden, name)
    with open(path('refused')) as text:
        assert json.load(text) == refused(), 'refused.json is not what make.py makes'
    print('all goldens are what their bytes say')


def near(a, b, where):
    """Equal, except for the last places, which another machine's numpy may round otherwise."""
    if isinstance(a, dict):
        assert a.keys() == b.keys(), where
        for key in a:
            near(a[key], b[key], f'{where}.{key}')
    elif isinstance(a, list):
        assert len(a) == len(b), where
        signs = (1, -1) if '.rotations' in where and a and isinstance(a[0], float) else (1,)
        if signs == (1,):
            for i, (x, y) in enumerate(zip(a, b)):
                near(x, y, f'{where}[{i}]')
            return
        assert min(max(abs(s * x - y) for x, y in zip(a, b)) for s in signs) < 1e-8, where
    elif isinstance(a, float):
        assert abs(a - b) <= 1e-8 * max(1, abs(b)), (where, a, b)
    else:
        assert a == b, (where, a, b)


if __name__ == '__main__':
    check() if sys.argv[1:] == ['--check'] else make()
