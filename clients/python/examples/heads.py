#!/usr/bin/env python3
"""A complete subscriber: sets a style for all performers, then prints the position of each performer's
head: heads.py [PUBLISHER [CONTROL [STYLE [FRAMES]]]]"""
import sys

import styled

publisher, control, style, enough, *_ = sys.argv[1:] + [
    styled.DEFAULT_PUBLISHER, styled.DEFAULT_CONTROL, 'old', '0'][len(sys.argv) - 1:]
with styled.Control(control) as daemon:
    try:
        daemon.set('*', style=style, strength=0.8)
    except styled.Error as error:
        print('style not set:', error, file=sys.stderr)

frames = 0
with styled.Subscriber(publisher, streams='canonical') as subscriber:
    for update in subscriber.frames(timeout=5):
        x, y, z = update.world()['head'].position
        print(f'{update.frame.performer} {x:.2f} {y:.2f} {z:.2f} m')
        frames += 1
        if frames == int(enough):  # 0: never
            break
print(f'{frames} frames, {subscriber.counters.missed} missed', file=sys.stderr)
