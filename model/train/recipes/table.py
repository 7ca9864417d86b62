#!/usr/bin/env python3
"""A table (Markdown) of what styleeval and stylebaseline --json wrote, one line per ROW:

    TITLE=KEY@FILE[,FILE...]

KEY says which of a file's sets of clips: mean, noise, styled, real, neutral, offset, offset_per_content.
Several files are runs with several seeds: their mean ± their deviation; one file: its figure ± the spread over its
judges. Refuses files whose judges (by SHA-256), data, split or inputs differ. "-": not measured.

    FMD-c      Frechet distance by the content judge's features; its mean over styles
    accuracy   windows whose content is still recognized (CRA)
    FMD-a, accuracy-a    both by ST-GCN action classifiers, as Park et al. 2021 have them (--action-classifiers)
    FMD        the same distance by an auto-encoder of rotations
    SRA        windows that are recognized as the target style
    movement, legs    the same by judges of movement alone, of the legs' pose and of the legs' movement
    jerk       at 120 Hz, over the input's
    APD cm     distance between outputs of one input in one style (judge/codes.h)
"""
import json
import statistics
import sys

FIGURES = {'offset': 'baseline', 'offset_per_content': 'baseline_per_content'}
# The score of a real or neutral clip stands beside every set's own figures.
FMD = {'real': 'fmd_real_real', 'neutral': 'fmd_neutral_target'}
VARIETY = {'noise': 'noise', 'styled': 'examples'}
JUDGES = {'accuracy': 'content', 'SRA': 'style', 'movement': 'movement', 'legs, pose': 'legs_pose',
          'legs, movement': 'legs_movement'}
COLUMNS = ['FMD-a', 'accuracy-a', 'FMD-c', 'accuracy', 'FMD', 'SRA', 'movement', 'legs, pose', 'legs, movement', 'jerk', 'APD cm']
ACTIONS = 'action classifiers'
SAME = ('manifest', 'split', 'judges', 'data', 'inputs')


def mean_over_styles(figures, name):
    found = [style[name] for style in figures['styles'].values() if style[name] is not None]
    return statistics.fmean(found) if found else None


def figures_of(judged, key):
    """The columns of one set of clips in one file; None where there is no figure."""
    row = dict.fromkeys(COLUMNS)
    judges = {judge['key']: judge for judged_set in judged['judges'] if judged_set['key'] == key
              for judge in judged_set['judges']}
    row.update({column: judges[judge]['value'] for column, judge in JUDGES.items()})
    row['spreads'] = {column: judges[judge].get('spread') for column, judge in JUDGES.items()}
    figures = judged[FIGURES.get(key, key) if key not in FMD else 'styled' if 'styled' in judged else 'baseline']
    fmd = FMD.get(key, 'fmd')
    row['FMD'] = mean_over_styles(figures, fmd)
    row['FMD-c'] = mean_over_styles(figures, 'content_' + fmd)
    mean = figures.get('mean', {})  # none in files of before
    row['spreads']['FMD'], row['spreads']['FMD-c'] = mean.get(fmd + '_spread'), mean.get(f'content_{fmd}_spread')
    if key not in FMD:
        row['jerk'] = mean_over_styles(figures, 'jitter_120')
    actions = judged.get('actions', {'sets': {}})['sets'].get(key)
    if actions:
        row['FMD-a'], row['accuracy-a'] = actions['fmd'], actions['accuracy']
        row['spreads'].update({'FMD-a': actions['fmd_spread'], 'accuracy-a': actions['accuracy_spread']})
    codes = judged.get('codes')
    if codes and key in VARIETY:
        row['APD cm'] = codes[VARIETY[key]]['distance_cm']
    elif codes and key == 'real':
        row['APD cm'] = codes['real_cm']
    return row


def text(values, spreads=()):
    """A cell: several runs' mean ± deviation, or one run's figure ± the spread over judges."""
    values = [value for value in values if value is not None]
    if not values:
        return '-'
    spread = statistics.stdev(values) if len(values) > 1 else next(iter(spreads), None)
    return f'{statistics.fmean(values):.2f}' + ('' if spread is None else f' ± {spread:.2f}')


def table(rows):
    """Markdown of [(title, key, [judged])]."""
    lines = ['| ' + ' | '.join(['', *COLUMNS]) + ' |', '|---' * (len(COLUMNS) + 1) + '|']
    for title, key, runs in rows:
        figures = [figures_of(judged, key) for judged in runs]
        cells = [text([row[column] for row in figures], [row['spreads'].get(column) for row in figures])
                 for column in COLUMNS]
        lines.append('| ' + ' | '.join([title, *cells]) + ' |')
    made = provenance_of(rows[0][2][0])
    made[ACTIONS] = next((sha for _, _, runs in rows for run in runs if (sha := provenance_of(run)[ACTIONS])), None)
    lines += ['', f"Judges of SHA-256 {made['judges']['sha256'][:16]}, {made['manifest']}, split {made['split']}"]
    if made[ACTIONS]:
        lines[-1] += f', {ACTIONS} of SHA-256 {made[ACTIONS][:16]}'
    for title, _, runs in rows:
        files = {f"{run['provenance']['weights']['file']} {run['provenance']['weights']['sha256'][:16]}"
                 for run in runs if 'weights' in run['provenance']}
        lines += [f'{title}: {", ".join(sorted(files))}'] if files else []
    return '\n'.join(lines)


def provenance_of(judged):
    """The values that must be the same in all files of a table."""
    made = {part: judged['provenance'][part] for part in SAME}
    return {**made, ACTIONS: judged.get('actions', {'sha256': None})['sha256']}


def load(name, key):
    """The figures of a file that has those of the set of clips `key`."""
    with open(name, encoding='utf-8') as file:
        try:
            judged = json.load(file)
            if key not in [judged_set['key'] for judged_set in judged['judges']]:
                raise ValueError(f"{name}: has no set of clips '{key}'")
            figures_of(judged, key)
            provenance_of(judged)
        except json.JSONDecodeError as error:
            raise ValueError(f'{name}: expected JSON: {error}') from error
        except KeyError as error:
            raise ValueError(f'{name}: has no key {error}; styleeval and stylebaseline --json write it') from error
        except (AttributeError, TypeError) as error:
            raise ValueError(f'{name}: expected what styleeval and stylebaseline --json write: {error}') from error
    return judged


def read(arguments):
    """[(title, key, [judged])] of the command line; ValueError says which file does not belong."""
    rows, first = [], None
    for argument in arguments:
        title, equals, source = argument.rpartition('=')
        key, at, files = source.partition('@')
        if not (equals and at and files):
            raise ValueError(f"'{argument}': expected TITLE=KEY@FILE[,FILE...]")
        runs = []
        for name in files.split(','):
            runs.append(load(name, key))
            made = provenance_of(runs[-1])
            first = first or (name, made)
            for part in made:
                if part == ACTIONS and None in (made[part], first[1][part]):
                    first[1][part] = first[1][part] or made[part]  # "-" in the columns of files without
                    continue
                if made[part] != first[1][part]:
                    raise ValueError(f'{name}: {part}: not as in {first[0]}')
        rows.append((title, key, runs))
    return rows


def main():
    if len(sys.argv) < 2 or sys.argv[1] in ('-h', '--help'):
        print(__doc__)
        return 0 if len(sys.argv) > 1 else 2
    try:
        print(table(read(sys.argv[1:])))
    except (OSError, ValueError) as error:
        print(f'table.py: {error}', file=sys.stderr)
        return 1
    return 0


if __name__ == '__main__':
    sys.exit(main())
