#!/usr/bin/env python3
"""How soon a stranger is styled, whether that drifts, and how much of a style is left while they stand and talk:
`strangers_time.py STYLIZE DATA WEIGHTS FOLDER`, in Markdown. strangers.sh runs it.

Degrees by which a joint is turned, the mean of all joints, live over what it is with the neutral learned from the
whole clip: in the second second and from 2.5 to 3.5 s of a walk that begins from nothing; in the first second where
another walk of the same person was shown before (calibrated); in the tenth minute of a walk that is repeated over what
it is in the first one. Then what it is while a stranger stands, waits and talks over what it is of the training's
performer who stands: a wave's first frame, held, since set 2 has no clip of a performer who only stands. Means of six styles, and the
least.
"""
import hashlib
import os
import subprocess
import sys

import numpy

STYLES = ('active', 'elderly', 'exhausted', 'feminine', 'masculine', 'youthful')
# A walk, and another one of the same person.
WALKS = [('accad/Female1/Female1_B03_Walk1.bvh', 'accad/Female1/Female1_B10_WalkTurnLeft45.bvh'),
         ('accad/Female1/Female1_B10_WalkTurnLeft45.bvh', 'accad/Female1/Female1_B03_Walk1.bvh'),
         ('accad/Male2/Male2_B3_Walk.bvh', 'accad/Male2/Male2_B10_WalkTurnLeft45.bvh'),
         ('accad/Male2/Male2_B10_WalkTurnLeft45.bvh', 'accad/Male2/Male2_B3_Walk.bvh')]
STANDING = ['accad/Female1/Female1_A01_Stand.bvh', 'accad/Female1/Female1_D2_Wait.bvh',
            'accad/Female1/Female1_D3_ConversationGestures.bvh', 'accad/Male2/Male2_A1_Stand.bvh',
            'accad/Male2/Male2_A4_LookAround.bvh']
PERFORMER = ['bandai-2-val/dataset-2_wave-both-hands_normal_025.bvh',
             'bandai-2-val/dataset-2_wave-left-hand_normal_026.bvh']
MINUTES, HELD_S = 10, 6


def about(axis, degrees):
    """Rotations about one axis as quaternions x, y, z, w."""
    quaternions = numpy.zeros((len(degrees), 4))
    quaternions[:, 'XYZ'.index(axis)] = numpy.sin(numpy.radians(degrees) / 2)
    quaternions[:, 3] = numpy.cos(numpy.radians(degrees) / 2)
    return quaternions


def product(a, b):
    ax, ay, az, aw = a.T
    bx, by, bz, bw = b.T
    return numpy.stack([aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
                        aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz], 1)


def read(file):
    """Seconds between frames, and the rotations of the joints [frames, joints, 4]."""
    with open(file) as text:
        hierarchy, motion = text.read().split('MOTION')
    channels = [line.split()[2:] for line in hierarchy.split('\n') if line.strip().startswith('CHANNELS')]
    lines = motion.strip().split('\n')
    frames = numpy.array([line.split() for line in lines[2:]], float)
    joints, column = [], 0
    for names in channels:
        rotation = numpy.tile([0, 0, 0, 1.0], (len(frames), 1))
        for name in names:
            if name.endswith('rotation'):
                rotation = product(rotation, about(name[0], frames[:, column]))
            column += 1
        joints.append(rotation)
    return float(lines[1].split()[2]), numpy.stack(joints, 1)


def repeat(file, seconds, to, frames=None):
    """Writes the first `frames` of a clip again and again; None: all."""
    with open(file) as text:
        hierarchy, motion = text.read().split('MOTION')
    lines = motion.strip().split('\n')
    frames = lines[2:][:frames]
    count = int(seconds / float(lines[1].split()[2]))
    with open(to, 'w') as text:
        text.write(f'{hierarchy}MOTION\nFrames: {count}\n{lines[1]}\n')
        text.writelines(frames[i % len(frames)] + '\n' for i in range(count))


class Turns:
    def __init__(self, stylize, weights, folder):
        self.stylize, self.weights, self.folder = stylize, weights, folder

    def of(self, clip, style, neutral):
        """A function of (begin, end): the mean turn of a joint between these seconds, degrees."""
        out = os.path.join(self.folder, 'styled.bvh')
        done = subprocess.run([self.stylize, clip, out, '--weights', self.weights, '--style', style, '--neutral',
                               neutral, '--overwrite', '--quiet'], capture_output=True, text=True)
        if done.returncode:
            sys.exit(f'strangers_time: {done.stderr.strip()}')
        dt_s, own = read(clip)
        cosines = numpy.abs((own * read(out)[1]).sum(2)).clip(0, 1)
        turned = numpy.degrees(2 * numpy.arccos(cosines)).mean(1)
        return lambda begin, end=None: turned[int(begin / dt_s):end and int(end / dt_s)].mean()


def in_time(turns, data, folder):
    repeated = os.path.join(folder, 'repeated.bvh')
    print('| walk | second second | 2.5 to 3.5 s | calibrated, first second | tenth minute over the first |')
    print('|---|---|---|---|---|')
    for walk, other in ((os.path.join(data, name) for name in names) for names in WALKS):
        repeat(walk, 60 * MINUTES, repeated)
        ratios = []
        for style in STYLES:
            whole, live = (turns.of(walk, style, neutral) for neutral in ('clip', 'live'))
            calibrated, long = turns.of(walk, style, other), turns.of(repeated, style, 'live')
            ratios.append([live(1, 2) / whole(1, 2), live(2.5, 3.5) / whole(2.5, 3.5),
                           calibrated(0, 1) / whole(0, 1),
                           long(60 * (MINUTES - 1), 60 * MINUTES) / long(5, 60)])
        cells = [f'{numpy.mean(some):.2f}; {min(some):.2f}' for some in zip(*ratios)]
        print('|', os.path.basename(walk), '|', ' | '.join(cells), '|', flush=True)


def standing(turns, data, folder):
    held = os.path.join(folder, 'held.bvh')
    performer = []
    for clip in PERFORMER:
        repeat(os.path.join(data, clip), HELD_S, held, frames=1)
        performer.append([turns.of(held, style, 'clip')(1) for style in STYLES])
    print('| who stands |', ' | '.join(STYLES), '|')
    print('|---' * (len(STYLES) + 1) + '|')
    for clip in STANDING:
        ratios = [turns.of(os.path.join(data, clip), style, 'clip')(1) for style in STYLES] / numpy.mean(performer, 0)
        print('|', os.path.basename(clip), '|', ' | '.join(f'{ratio:.2f}' for ratio in ratios), '|', flush=True)


def main():
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    stylize, data, weights, folder = sys.argv[1:]
    turns = Turns(stylize, weights, folder)
    with open(weights, 'rb') as file:
        print(f'Of {os.path.basename(weights)} (SHA-256 {hashlib.sha256(file.read()).hexdigest()[:16]})')
    in_time(turns, data, folder)
    print()
    standing(turns, data, folder)


if __name__ == '__main__':
    main()
