"""Compares what our reader and Blender's importer made of texts.py: compare.py FOLDER.

Prints a table: the text, what Blender did, what ours did, and whether that is as expected.
"""
import json
import math
import pathlib
import sys

from texts import TEXTS

MOST = 2e-3  # of 100 units: Blender computes with single precision


def farthest(one, other):
    """The largest distance of a joint between two readings, or what else differs."""
    one = {name.replace(' ', '_'): rows for name, rows in one.items()}  # as Blender writes names
    if not one or set(one) != set(other):
        return f'other joints: {sorted(set(one) ^ set(other))}'
    worst = 0.0
    for name, places in one.items():
        if len(places) != len(other[name]):
            return f'{len(places)} frames, not {len(other[name])}'
        for here, there in zip(places, other[name]):
            worst = max(worst, math.dist(here, there))
    return worst


def alike(one, other):
    """'' if two readings are the same, else how they differ."""
    apart = farthest(one['joints'], other['joints'])
    if isinstance(apart, str):
        return apart
    if not apart < MOST:
        return f'{apart:.3g} apart'
    # Ours takes 0.0333333 s for 30 Hz.
    return '' if abs(one['hz'] / other['hz'] - 1) < 1e-4 else f"{one['hz']:.4g} Hz"


def judge(expected, ours, blender, all_of_ours):
    """'' if our reading is as expected, else what is wrong."""
    if expected.startswith('refuses: '):
        if 'error' not in ours:
            return 'ours reads it'
        return '' if expected.removeprefix('refuses: ') in ours['error'] else ours['error']
    if 'error' in ours or expected == 'reads':
        return ours.get('error', '')
    if expected == 'row before':
        plain = all_of_ours['plain']
        held = {name: [rows[0], rows[0], rows[2]] for name, rows in plain['joints'].items()}
        return alike(ours, plain | {'joints': held})
    if expected.startswith('as '):
        return alike(ours, all_of_ours[expected.removeprefix('as ')])
    if 'error' in blender:
        return 'Blender refuses it'
    left_out = {'Prop'} if expected == 'blender without Prop' else set()
    theirs = {name: rows for name, rows in blender['joints'].items() if name not in left_out}
    return alike(ours, blender | {'joints': theirs})


def main():
    """Exit code 1 if a reading is not as expected."""
    folder = pathlib.Path(sys.argv[1])
    ours = json.loads((folder / 'ours.json').read_text())
    blender = json.loads((folder / 'blender.json').read_text())
    # The comparison must see a difference of one number.
    failed = int(alike(ours['plus'], blender['plain']) == '')
    for name, (_, expected, *_) in TEXTS.items():
        wrong = judge(expected, ours[name], blender[name], ours)
        failed += wrong != ''
        if 'error' in blender[name]:
            theirs = 'refuses: ' + blender[name]['error'][:50]
        else:
            theirs = 'reads it'
            if 'error' not in ours[name]:
                apart = alike(ours[name], blender[name])
                theirs = f'reads something else: {apart}' if apart else 'reads the same'
        mine = ours[name].get('error', ours[name].get('remark') or 'reads it')
        mine = mine.removeprefix(f'{folder}/')
        print(f"{'FAILED' if wrong else 'ok':6} {name:30} Blender {theirs:55.55} ours: {mine:.90}"
              + (f'\n       expected {expected}: {wrong}' if wrong else ''))
    print(f'{len(TEXTS)} texts, {failed} not as expected')
    return 1 if failed else 0


if __name__ == '__main__':
    sys.exit(main())
