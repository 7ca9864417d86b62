#!/usr/bin/env python3
"""Draws the moving picture of the README: a walk as captured, and the same walk in some styles.

    model/tools/strips/animate.py OUT.svg [--bin build/release/bin] [--styles elderly,open:zombie,...]

The synthetic performer of stylesim walks; stylize restyles its BVH with shipped weights, frame after frame
as the daemon does. The figures are drawn from the side, on a treadmill, as an animated SVG that repeats one
gait cycle; behind each styled one stands the captured one, pale. Colours are of a middle lightness, so that
they are seen on white and on black pages. The licences of the weights are written into it. Needs no package
beyond Python's own.
"""
import argparse
import html
import json
import math
import os
import struct
import subprocess
import sys
import tempfile

WEIGHTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', 'weights')
RATE_HZ = 60
DRAWN_HZ = 15
SETTLED_S = 4.0            # the style is fully there
CYCLE_S = (0.8, 2.6)       # of one or two gait cycles
VIEW = math.radians(25)    # of the camera from the performer's right side toward the front
UNITS_PER_CM = 4
COLUMN, HEIGHT, FLOOR = 500, 980, 860
DASHES = 8                 # of the floor, in the way of one cycle
# Drawn from back to front: name, width, and chains of joints; a chain that ends where it begins is filled.
PARTS = [
    ('far', 34, [['leftUpperLeg', 'leftLowerLeg', 'leftFoot', 'leftToes']]),
    ('far', 26, [['leftUpperArm', 'leftLowerArm', 'leftHand']]),
    ('trunk', 40, [['leftUpperArm', 'rightUpperArm', 'rightUpperLeg', 'leftUpperLeg', 'leftUpperArm']]),
    ('trunk', 30, [['neck', 'chin']]),
    ('trunk', 72, [['chin', 'crown']]),
    ('near', 34, [['rightUpperLeg', 'rightLowerLeg', 'rightFoot', 'rightToes']]),
    ('near', 26, [['rightUpperArm', 'rightLowerArm', 'rightHand']]),
]
HEAD_CM = {'chin': 8, 'crown': 11}  # middles of its round ends, above the joint
CAPTURED = {'far': '#6f7b88', 'trunk': '#838f9c', 'near': '#99a5b2'}
STYLED = {'far': '#a8481f', 'trunk': '#cf5c28', 'near': '#ee7f45'}
LABEL, FLOOR_COLOR, PALE = '#858f9a', '#98a2ad', 0.3


class Bvh:
    """A clip: joints with parents and offsets, and the world positions of a frame, in cm."""

    def __init__(self, path):
        with open(path, encoding='utf-8') as text:
            hierarchy, motion = text.read().split('MOTION')
        self.joints = []   # (name, parent, offset, channels)
        above, name = [], ''
        words = iter(hierarchy.split())
        for word in words:
            if word in ('ROOT', 'JOINT'):
                name = next(words)
            elif word == 'End':
                next(words)
                name = None
            elif word == '{':
                self.joints.append([name, above[-1] if above else -1, None, []])
                above.append(len(self.joints) - 1)
            elif word == '}':
                above.pop()
            elif word == 'OFFSET':
                self.joints[above[-1]][2] = [float(next(words)) for _ in range(3)]
            elif word == 'CHANNELS':
                self.joints[above[-1]][3] = [next(words) for _ in range(int(next(words)))]
        lines = motion.strip().splitlines()
        self.frames = [[float(value) for value in line.split()] for line in lines[2:]]

    def positions(self, frame):
        """{joint: (x, y, z)}; and the places of HEAD_CM."""
        values = iter(self.frames[frame])
        rotations, places, named = [], [], {}
        for name, parent, offset, channels in self.joints:
            step = list(offset)
            turn = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
            for channel in channels:
                value = next(values)
                if channel.endswith('position'):
                    step['XYZ'.index(channel[0])] = value
                else:
                    turn = product(turn, about('XYZ'.index(channel[0]), math.radians(value)))
            if parent >= 0:
                step = [a + b for a, b in zip(places[parent], rotate(rotations[parent], step))]
                turn = product(rotations[parent], turn)
            rotations.append(turn)
            places.append(step)
            if name:
                named[name] = step
            if name == 'head':
                for place, above_cm in HEAD_CM.items():
                    named[place] = [a + b for a, b in zip(step, rotate(turn, [0, above_cm, 0]))]
        return named


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def rotate(a, v):
    return [sum(a[i][k] * v[k] for k in range(3)) for i in range(3)]


def about(axis, angle):
    c, s = math.cos(angle), math.sin(angle)
    j, k = (axis + 1) % 3, (axis + 2) % 3
    turn = [[float(i == n) for n in range(3)] for i in range(3)]
    turn[j][j] = turn[k][k] = c
    turn[j][k], turn[k][j] = -s, s
    return turn


def apart(a, b):
    """Sum of squared distances of two poses, each about its own hips."""
    return sum((a[n][i] - a['hips'][i] - b[n][i] + b['hips'][i]) ** 2 for n in a for i in range(3))


def gait_cycle(poses, start):
    """The number of frames after which all figures look most like their first frame."""
    low, high = (round(seconds * RATE_HZ) for seconds in CYCLE_S)
    return min(range(low, high), key=lambda n: sum(apart(clip[start], clip[start + n]) for clip in poses))


def flattened(poses, start, count):
    """For one clip: per drawn frame {joint: (x, y)} in the picture, on a treadmill; the last is the
    first."""
    begin, end = poses[start]['hips'], poses[start + count]['hips']
    way = [b - a for a, b in zip(begin, end)]
    heading = math.atan2(way[0], way[2])
    across = heading + VIEW  # direction in the floor that the picture's x axis shows
    frames = []
    drawn = round(count * DRAWN_HZ / RATE_HZ)
    for i in range(drawn + 1):
        share = i / drawn
        at, part = divmod(start + share * count, 1)
        now, after = poses[int(at)], poses[min(int(at) + 1, len(poses) - 1)]
        again = poses[start]
        frame = {}
        for name in now:
            p = [a + part * (b - a) for a, b in zip(now[name], after[name])]
            p = [a - b - share * w for a, b, w in zip(p, begin, way)]
            # Distribute the difference between the cycle's ends over the whole cycle.
            p = [a + share * (f - b - l + e) for a, f, b, l, e in
                 zip(p, again[name], begin, poses[start + count][name], end)]
            x = p[0] * math.sin(across) + p[2] * math.cos(across)
            frame[name] = (x * UNITS_PER_CM, (p[1] + begin[1]) * UNITS_PER_CM)
        frames.append(frame)
    return frames


def outline(frame, chains):
    """The path of one part of a figure, about the middle of its column."""
    moves = []
    for chain in chains:
        closed = chain[0] == chain[-1]
        points = [f'{round(frame[n][0])},{round(FLOOR - frame[n][1])}' for n in (chain[:-1] if closed else chain)]
        moves.append('M' + 'L'.join(points) + ('Z' if closed else ''))
    return ''.join(moves)


def drawn(frames, colors, seconds):
    """The moving paths of one figure."""
    out = []
    for part, width, chains in PARTS:
        steps = [outline(frame, chains) for frame in frames]
        fill = f' fill="{colors[part]}"' if 'Z' in steps[0] else ''
        out.append(f'<path stroke="{colors[part]}" stroke-width="{width}"{fill} d="{steps[0]}">'
                   f'<animate attributeName="d" dur="{seconds:.2f}s" repeatCount="indefinite" '
                   f'values="{";".join(steps)}"/></path>')
    return out


def licence_of(weights):
    """The licence in the weights' metadata."""
    with open(weights, 'rb') as file:
        length, = struct.unpack('<Q', file.read(8))
        metadata = json.loads(file.read(length))['__metadata__']
    return json.loads(metadata['styled'])['licence']


def svg(figures, way, seconds, licences):
    """The picture of [(label, frames)], the captured one first; `way`: how far all of them go in a cycle."""
    width = COLUMN * len(figures)
    names = ', '.join(label for label, _ in figures)
    dash = way / DASHES
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {HEIGHT}" width="{width // 4}" '
           f'height="{HEIGHT // 4}" fill="none" stroke-linecap="round" stroke-linejoin="round">',
           f'<title>One walk: {html.escape(names)}</title>',
           f'<desc>Made with Styled. Licence, that of the weights: {html.escape("; ".join(licences))}</desc>',
           f'<path d="M0,{FLOOR + 24}H{width}" stroke="{FLOOR_COLOR}" stroke-width="6" '
           f'stroke-dasharray="{dash * 0.6:.1f} {dash * 0.4:.1f}"><animate attributeName="stroke-dashoffset" '
           f'dur="{seconds:.2f}s" repeatCount="indefinite" values="0;{way:.1f}"/></path>']
    for column, (label, frames) in enumerate(figures):
        middle = COLUMN * column + COLUMN // 2
        captured = column == 0
        if not captured:
            out.append(f'<use href="#captured" x="{COLUMN * column}" opacity="{PALE}"/>')
        out += [f'<g transform="translate({middle})"' + (' id="captured">' if captured else '>'),
                *drawn(frames, CAPTURED if captured else STYLED, seconds), '</g>',
                f'<text x="{middle}" y="{HEIGHT - 24}" text-anchor="middle" font-family="sans-serif" font-size="60" '
                f'fill="{LABEL if captured else STYLED["trunk"]}">{html.escape(label)}</text>']
    return '\n'.join(out + ['</svg>', ''])


def weights_file(name):
    """The file of shipped weights by their name, or what is a file itself."""
    shipped = os.path.join(WEIGHTS, name + '.safetensors')
    return shipped if os.path.exists(shipped) else name


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n', maxsplit=1)[0])
    parser.add_argument('out')
    parser.add_argument('--bin', default='build/release/bin', help='folder of stylesim and stylize')
    parser.add_argument('--styles', default='elderly,giant,active,not-confident,open:zombie',
                        help='comma-separated; WEIGHTS:STYLE for other weights than v2')
    arguments = parser.parse_args()

    def run(program, *options):
        path = os.path.join(arguments.bin, program)
        if not os.access(path, os.X_OK):
            sys.exit(f'{path} is missing: build it, or give --bin FOLDER')
        done = subprocess.run([path, *options], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            sys.exit(f'{program}: {done.stderr.strip()}')

    styles = [style.rpartition(':')[::2] for style in arguments.styles.split(',')]
    styles = [(weights_file(weights or 'v2'), style) for weights, style in styles]
    with tempfile.TemporaryDirectory() as folder:
        files = [os.path.join(folder, f'{number}.bvh') for number in range(len(styles) + 1)]
        run('stylesim', '--script', 'walk:20', '--seconds', str(SETTLED_S + CYCLE_S[1] + 1), '--rate', str(RATE_HZ),
            '--write', files[0])
        for (weights, style), file in zip(styles, files[1:]):
            run('stylize', '--weights', weights, '--style', style, files[0], file)
        clips = []
        for file in files:
            bvh = Bvh(file)
            clips.append([bvh.positions(frame) for frame in range(len(bvh.frames))])
    start = round(SETTLED_S * RATE_HZ)
    count = gait_cycle(clips, start)
    labels = ['captured'] + [style for _, style in styles]
    way_cm = math.dist(*(clips[0][at]['hips'][::2] for at in (start, start + count)))
    picture = svg([(label, flattened(clip, start, count)) for label, clip in zip(labels, clips)],
                  way_cm * math.cos(VIEW) * UNITS_PER_CM, count / RATE_HZ,
                  dict.fromkeys(licence_of(weights) for weights, _ in styles))
    with open(arguments.out, 'w', encoding='utf-8') as out:
        out.write(picture)
    print(f'{arguments.out}: {len(picture)} bytes, one cycle is {count / RATE_HZ:.2f} s')


if __name__ == '__main__':
    main()
