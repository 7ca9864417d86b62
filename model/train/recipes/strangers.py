#!/usr/bin/env python3
"""The table "Strangers" of RESULTS.md, in Markdown: `strangers.py [options] WEIGHTS [TITLE=WEIGHTS...]`, the
figures of styleacts for one file beside those of others. strangers.sh runs it.

A cell is a clip in one of the six styles of set 2. RESULTS.md names the clips that training and tuning used.
"""
import argparse
import glob
import hashlib
import json
import os
import subprocess
import sys

STYLES = 'active,elderly,exhausted,feminine,masculine,youthful'
FEMALE, MALE, XIA, SET_2 = 'accad/Female1/Female1_', 'accad/Male2/Male2_', 'xia/', 'bandai-2-val/dataset-2_'
# Title, patterns of clips, and which content of the manifest they show, where that is known.
ROWS = [
    ('Female1, walks', [FEMALE + x for x in ('B01_*', 'B02_WalkToStand.bvh', 'B03_*', 'B10_*', 'B13_*')], 'walk'),
    ('Male2, walks', [MALE + x for x in ('B1_*', 'B2_*', 'B3_*', 'B10_*', 'B13_*')], 'walk'),
    ('Female1, a run', [FEMALE + 'C03_*'], 'run'),
    ('Male2, runs', [MALE + x for x in ('C1_*', 'C3_*')], 'run'),
    ('Female1, stands, waits, talks', [FEMALE + x for x in ('A01_*', 'A02_*', 'A04_*', 'D2_*', 'D3_*')], None),
    ('Male2, stands, sways, looks', [MALE + x for x in ('A1_*', 'A2_*', 'A4_*')], None),
    ('Female1, boxes, swings, skips, crouches', [FEMALE + x for x in ('A03*', 'A05*', 'A06*', 'A07*', 'A13*', 'A14*',
                                                                      'A15*')], None),
    ('Female1, lies and crawls', [FEMALE + x for x in ('A08*', 'A09*', 'A10*', 'A11*', 'A12*')], None),
    ('Male2, blows and blocks', [MALE + 'E1[0-8]_*'], None),
    ('Male2, kicks', [MALE + x for x in ('G2_*', 'G4_*', 'G6_*', 'G1[2-57-9]_*', 'G20_*')], None),
    ("Xia's nine clips", [XIA + '*.bvh'], None),
    ('set 2, walks', [SET_2 + 'walk_normal*'], 'walk'),
    ('set 2, runs', [SET_2 + 'run_normal*'], 'run'),
    ('set 2, waves', [SET_2 + 'wave*normal*'], None),
]
# Title, key of styleacts' JSON, digits.
COLUMNS = [('turned, degrees', 'turned_deg', 1), ('moved, cm', 'moved_cm', 1), ('unseen', 'unseen', 2),
           ('faint', 'faint', 2), ('told', 'told', 2), ('expression', 'expression', 2),
           ('least expression of a style', 'least', 2), ('legs shown', 'legs', 2), ('jerk', 'jerk', 2),
           ('largest jerk', 'largest_jerk', 2), ('least reach', 'least_reach', 2),
           ('degrees off', 'direction_deg', 1), ('least kick', 'least_kick_height', 2),
           ('least knee', 'least_knee_deg', 1), ('slide, cm/s', 'skate_cm_s', 1)]


def measure(options, weights, files, content, name):
    """The output of styleacts for these clips; None for weights that it cannot run."""
    out = os.path.join(options.out, name + '.json')
    command = [options.styleacts, '--weights', weights, '--styles', STYLES, '--json', out]
    if content:
        command += ['--real', options.manifest, '--data', options.data, '--content', content]
    done = subprocess.run(command + files, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f'strangers: {name}: {done.stderr.strip()}')
    with open(out) as file:
        figures = json.load(file)
    row = figures['all']
    row['legs'] = (row['shown']['left-leg'] + row['shown']['right-leg']) / 2
    of_styles = [style.get('expression') for style in figures['styles'].values()]
    row['least'] = None if None in of_styles else min(of_styles)
    return row


def named(weights):
    """A file of weights by its name and the first digits of its SHA-256."""
    with open(weights, 'rb') as file:
        return f'{os.path.basename(weights)} (SHA-256 {hashlib.sha256(file.read()).hexdigest()[:16]})'


def cell(rows, key, digits):
    values = ['-' if row.get(key) is None else f'{row[key]:.{digits}f}' for row in rows]
    if set(values) == {'-'}:
        return ''
    return values[0] + (f' ({", ".join(values[1:])})' if len(values) > 1 else '')


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for option in ('styleacts', 'data', 'manifest', 'out'):
        parser.add_argument('--' + option, required=True)
    parser.add_argument('weights')
    parser.add_argument('others', nargs='*', metavar='TITLE=WEIGHTS')
    options = parser.parse_args()
    others = [other.partition('=')[::2] for other in options.others]
    os.makedirs(options.out, exist_ok=True)
    print('Of', named(options.weights))
    if others:
        print('In brackets:', ', '.join(f'{title}, {named(file)}' for title, file in others))
    print('| clips | cells |', ' | '.join(title for title, _, _ in COLUMNS), '|')
    print('|---' * (len(COLUMNS) + 2) + '|')
    for title, patterns, content in ROWS:
        files = sorted(sum((glob.glob(os.path.join(options.data, pattern)) for pattern in patterns), []))
        if not files:
            sys.exit(f'strangers: {title}: no clips like {os.path.join(options.data, patterns[0])}')
        rows = [measure(options, weights, files, content, f'{title} {number}'.replace("'", ''))
                for number, weights in enumerate([options.weights] + [file for _, file in others])]
        cells = [cell(rows, key, digits) for _, key, digits in COLUMNS]
        print('|', title, '|', len(files) * len(STYLES.split(',')), '|', ' | '.join(cells), '|', flush=True)


if __name__ == '__main__':
    main()
