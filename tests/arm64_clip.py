#!/usr/bin/env python3
"""The largest difference between two BVH files of one skeleton: `arm64_clip.py FILE FILE`. Fails above what
tests/golden allows between SIMD paths: 0.01 degrees of a joint, 0.01 cm of a position.
"""
import math
import sys

MOST_DEG, MOST_CM = 0.01, 0.01


def read(file):
    """The channels' names, and a list of numbers for each frame."""
    channels, frames, motion = [], [], False
    with open(file) as lines:
        for words in map(str.split, lines):
            if words[:1] == ['CHANNELS']:
                channels += words[2:]
            elif words[:1] == ['MOTION']:
                motion = True
            elif motion and words and not words[0].startswith('Frame'):
                frames.append([float(word) for word in words])
    return channels, frames


def product(p, q):
    (a, b, c, d), (e, f, g, h) = p, q
    return (a * e - b * f - c * g - d * h, a * f + b * e + c * h - d * g,
            a * g - b * h + c * e + d * f, a * h + b * g - c * f + d * e)


def rotation(axes, angles):
    turned = (1.0, 0.0, 0.0, 0.0)
    for axis, angle in zip(axes, angles):
        half = math.radians(angle) / 2
        turned = product(turned, (math.cos(half), *(math.sin(half) * (name == axis) for name in 'XYZ')))
    return turned


def between_deg(p, q):
    turn = product((p[0], -p[1], -p[2], -p[3]), q)
    return math.degrees(2 * math.atan2(math.hypot(*turn[1:]), abs(turn[0])))


def main(first, second):
    (channels, one), (others, two) = read(first), read(second)
    if channels != others or len(one) != len(two) or not one:
        sys.exit(f'{second}: found {len(two)} frames of {len(others)} channels, '
                 f'expected {len(one)} of {len(channels)}, at least one frame')
    starts = [at for at, name in enumerate(channels) if name.endswith('rotation')][::3]
    places = [at for at, name in enumerate(channels) if name.endswith('position')]
    most_deg = most_cm = 0.0
    for a, b in zip(one, two):
        most_cm = max([most_cm, *(abs(a[at] - b[at]) for at in places)])
        for at in starts:
            axes = [name[0] for name in channels[at:at + 3]]
            most_deg = max(most_deg, between_deg(rotation(axes, a[at:at + 3]), rotation(axes, b[at:at + 3])))
    print(f'{len(one)} frames of {len(starts)} joints: at most {most_deg:.6f} degrees and {most_cm:.6f} cm apart; '
          f'the goldens allow {MOST_DEG} and {MOST_CM}')
    return most_deg > MOST_DEG or most_cm > MOST_CM


if __name__ == '__main__':
    sys.exit(main(*sys.argv[1:]))
