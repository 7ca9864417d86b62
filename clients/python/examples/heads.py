#!/usr/bin/env python3
"""A complete subscriber: sets a style for all performers, then prints the position of each performer's
head."""
import argparse
import sys

import styled

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument('publisher', nargs='?', default=styled.DEFAULT_PUBLISHER)
parser.add_argument('control', nargs='?', default=styled.DEFAULT_CONTROL)
parser.add_argument('style', nargs='?', default='old')
parser.add_argument('frames', nargs='?', type=int, default=0, help='number of frames to show; 0: no limit')
a = parser.parse_args()
try:
    daemon, subscriber = styled.Control(a.control), styled.Subscriber(a.publisher, streams='canonical')
except ValueError as error:  # a wrong endpoint
    parser.error(str(error))

with daemon:
    try:
        daemon.set('*', style=a.style, strength=0.8)
    except styled.Error as error:
        print('style not set:', error, file=sys.stderr)

frames = 0
with subscriber:
    for update in subscriber.frames(timeout=5):
        x, y, z = update.world()['head'].position
        print(f'{update.frame.performer} {x:.2f} {y:.2f} {z:.2f} m')
        frames += 1
        if frames == a.frames:
            break
print(f'{frames} frames, {subscriber.counters.missed} missed', file=sys.stderr)
