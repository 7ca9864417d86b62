#!/usr/bin/env python3
"""Draws the moving picture of the README: a walk as captured, and the same walk in some styles.

    model/tools/strips/animate.py OUT.svg [--bin build/release/bin] [--styles youthful,elderly,...]

The synthetic performer of stylesim walks; stylize restyles its BVH with the shipped weights, frame after
frame as the daemon does; the figures are drawn from the side, on a treadmill, as an animated SVG that
repeats one gait cycle. The licence of the weights is written into it. Needs no package beyond Python's
own.
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

WEIGHTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', 'weights', 'v2.safetensors')
RATE_HZ = 60
DRAWN_HZ = 20
SETTLED_S = 4.0            # the style is fully there
CYCLE_S = (0.8, 2.6)       # of one or two gait cycles
VIEW = math.radians(25)    # of the camera from the performer's right side toward the front
UNITS_PER_CM = 4
COLUMN, HEIGHT, FLOOR = 560, 960, 860
LIMBS = {                  # drawn from back to front
    'left': [['leftUpperLeg', 'leftLowerLeg', 'leftFoot', 'leftToes'],
             ['leftUpperArm', 'leftLowerArm', 'leftHand']],
    'trunk': [['hips', 'spine', 'chest', 'neck'], ['leftUpperArm', 'neck', 'rightUpperArm'],
              ['leftUpperLeg', 'hips', 'rightUpperLeg']],
    'head': [['chin', 'crown']],
    'right': [['rightUpperLeg', 'rightLowerLeg', 'rightFoot', 'rightToes'],
              ['rightUpperArm', 'rightLowerArm', 'rightHand']],
}
HEAD_CM = {'chin': 5, 'crown': 11}  # middles of its round ends, above the joint
COLORS = {'right': '#cd4632', 'trunk': '#808080', 'left': '#246abe', 'head': '#808080'}
WIDTHS = {'right': 30, 'trunk': 34, 'left': 30, 'head': 60}


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


def outline(frame, chains, left):
    moves = []
    for chain in chains:
        points = [f'{round(left + frame[n][0])},{round(FLOOR - frame[n][1])}' for n in chain]
        moves.append('M' + 'L'.join(points))
    return ''.join(moves)


def licence_of(weights):
    """The licence in the weights' metadata."""
    with open(weights, 'rb') as file:
        length, = struct.unpack('<Q', file.read(8))
        metadata = json.loads(file.read(length))['__metadata__']
    return json.loads(metadata['styled'])['licence']


def svg(figures, seconds, licence):
    width = COLUMN * len(figures)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {HEIGHT}" width="{width // 4}" '
           f'height="{HEIGHT // 4}" fill="none" stroke-linecap="round" stroke-linejoin="round">',
           f'<title>One walk: {html.escape(", ".join(label for label, _ in figures))}</title>',
           f'<desc>Made with Styled. Licence, that of the weights: {html.escape(licence)}</desc>',
           f'<path d="M0,{FLOOR + 16}H{width}" stroke="#b0b0b0" stroke-width="6"/>']
    for column, (label, frames) in enumerate(figures):
        left = COLUMN * column + COLUMN // 2
        for part, chains in LIMBS.items():
            steps = [outline(frame, chains, left) for frame in frames]
            out.append(f'<path stroke="{COLORS[part]}" stroke-width="{WIDTHS[part]}" d="{steps[0]}">'
                       f'<animate attributeName="d" dur="{seconds:.2f}s" repeatCount="indefinite" '
                       f'values="{";".join(steps)}"/></path>')
        out.append(f'<text x="{left}" y="{HEIGHT - 12}" text-anchor="middle" font-family="sans-serif" '
                   f'font-size="64" fill="#808080">{label}</text>')
    return '\n'.join(out + ['</svg>', ''])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n', maxsplit=1)[0])
    parser.add_argument('out')
    parser.add_argument('--bin', default='build/release/bin', help='folder of stylesim and stylize')
    parser.add_argument('--weights', default=WEIGHTS, help='of stylize; default: v2.safetensors')
    parser.add_argument('--styles', default='youthful,active,elderly,angry', help='comma-separated')
    arguments = parser.parse_args()

    def run(program, *options):
        path = os.path.join(arguments.bin, program)
        if not os.access(path, os.X_OK):
            sys.exit(f'{path} is missing: build it, or give --bin FOLDER')
        done = subprocess.run([path, *options], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            sys.exit(f'{program}: {done.stderr.strip()}')

    with tempfile.TemporaryDirectory() as folder:
        walk = os.path.join(folder, 'input.bvh')
        run('stylesim', '--script', 'walk:20', '--seconds', str(SETTLED_S + CYCLE_S[1] + 1), '--rate', str(RATE_HZ),
            '--write', walk)
        names = ['input'] + arguments.styles.split(',')
        for name in names[1:]:
            run('stylize', '--weights', arguments.weights, '--style', name, walk, os.path.join(folder, name + '.bvh'))
        clips = []
        for name in names:
            bvh = Bvh(os.path.join(folder, name + '.bvh'))
            clips.append([bvh.positions(frame) for frame in range(len(bvh.frames))])
    start = round(SETTLED_S * RATE_HZ)
    count = gait_cycle(clips, start)
    labels = ['as captured'] + names[1:]
    picture = svg([(label, flattened(clip, start, count)) for label, clip in zip(labels, clips)], count / RATE_HZ,
                  licence_of(arguments.weights))
    with open(arguments.out, 'w', encoding='utf-8') as out:
        out.write(picture)
    print(f'{arguments.out}: {len(picture)} bytes, one cycle is {count / RATE_HZ:.2f} s')


if __name__ == '__main__':
    main()
