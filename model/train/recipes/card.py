#!/usr/bin/env python3
"""The tables (Markdown) of the model card and of RESULTS.md from what styleeval --json wrote: `card.py FILE [COMMIT]`.
First the means of each set of clips beside a constant offset and real clips, then the main set by style, each with
the line that says which weights, judges and programs they are of. ± is the deviation over judges, [] the 95 % interval
over clips, "-" not measured.
"""
import json
import statistics
import sys

# A set's key among the judges' figures, and among the others.
SETS = [('styled', 'styled'), ('mean', 'mean'), ('examples', 'examples'), ('examples_neutral', 'examples_neutral'),
        ('noise', 'noise'), ('offset', 'baseline'), ('offset_per_content', 'baseline_per_content')]
JUDGES = [('style recognized (SRA)', ['style'], 3), ('content recognized (CRA)', ['content'], 3),
          ('movement alone recognized', ['movement'], 2),
          ('legs recognized by pose; by movement', ['legs_pose', 'legs_movement'], 2),
          ('arms recognized by pose; by movement', ['arms_pose', 'arms_movement'], 2),
          ('trunk recognized by pose; by movement', ['trunk_pose', 'trunk_movement'], 2)]


def number(value, digits=2, spread=None):
    if value is None:
        return '-'
    return f'{value:.{digits}f}' + ('' if spread is None else f' ± {spread:.{digits}f}')


def share(of, digits=2):
    text = number(of['value'], digits, of.get('spread'))
    return text if of['value'] is None else f"{text} [{number(of['low'])}, {number(of['high'])}]"


def mean(figures, key):
    """Over the styles that have it."""
    found = [style[key] for style in figures['styles'].values() if style[key] is not None]
    return statistics.fmean(found) if found else None


def judges_of(judged, key):
    return next({judge['key']: judge for judge in one['judges']} for one in judged['judges'] if one['key'] == key)


def table(head, rows):
    return '\n'.join('| ' + ' | '.join(row) + ' |' for row in [head, ['---'] * len(head), *rows])


def means(judged):
    """Of each set of clips, one column; real clips last."""
    sets = [pair for pair in SETS if pair[1] in judged]
    titles = {one['key']: one['title'] for one in judged['judges']}
    real, base = judges_of(judged, 'real'), judged['baseline']
    rows = []
    for title, keys, digits in JUDGES:
        cells = [judges_of(judged, key) for key, _ in sets] + [real]
        rows.append([title, *('; '.join(share(of[key], digits) for key in keys) for of in cells)])
    for title, key, of_real, digits in (
            ('expression', 'expression', 'expression_of_training_clips', 2),
            ('its cosine', 'expression_cosine', 'expression_cosine_of_training_clips', 2),
            (f"FMD (neutral to target {number(mean(base, 'fmd_neutral_target'), 0)})", 'fmd', 'fmd_real_real', 1),
            (f"FMD-c (neutral to target {number(mean(base, 'content_fmd_neutral_target'), 1)})", 'content_fmd',
             'content_fmd_real_real', 1),
            ("jerk over the input's", 'jitter_120', 'jitter_120_of_real', 2),
            (f"skate, cm/s (input {number(mean(base, 'skate_in_cm_s'), 1)})", 'skate_out_cm_s', None, 1)):
        cells = [number(mean(judged[figures], key), digits) for _, figures in sets]
        rows.append([title, *cells, number(mean(base, of_real), digits) if of_real else ''])
    return table(['', *(titles[key] for key, _ in sets), titles['real']], rows)


def by_style(judged):
    """The main set: a row per style, its mean, the constant offset and real clips."""
    key = 'styled' if 'styled' in judged else 'baseline'
    shown = judges_of(judged, key if key == 'styled' else 'offset')
    part = lambda of, style: number(of['styles'][style], 2, of['styles_spread'][style])  # noqa: E731
    rows = []
    for name, style in judged[key]['styles'].items():
        rows.append([name, share(style['sra']), number(style['cra']['value'], 2, style['cra']['spread']),
                     number(style['expression']), number(style['expression_cosine']),
                     f"{number(style['fmd'], 1, style['fmd_spread'])} ({number(style['fmd_neutral_target'], 0)})",
                     part(shown['movement'], name),
                     f"{part(shown['legs_pose'], name)}; {part(shown['legs_movement'], name)}",
                     f"{part(shown['trunk_pose'], name)}; {part(shown['trunk_movement'], name)}",
                     number(style['jitter_120']), number(style['skate_out_cm_s'], 1)])
    for title, one, figures in (('mean', shown, judged[key]), ('constant offset', judges_of(judged, 'offset'), judged['baseline'])):
        all_of = lambda name, one=one: number(one[name]['value'], 2, one[name]['spread'])  # noqa: E731
        rows.append([title, share(one['style']), all_of('content'), number(mean(figures, 'expression')),
                     number(mean(figures, 'expression_cosine')),
                     f"{number(mean(figures, 'fmd'), 1)} ({number(mean(figures, 'fmd_neutral_target'), 0)})", all_of('movement'),
                     f"{all_of('legs_pose')}; {all_of('legs_movement')}", f"{all_of('trunk_pose')}; {all_of('trunk_movement')}",
                     number(mean(figures, 'jitter_120')), number(mean(figures, 'skate_out_cm_s'), 1)])
    base, real = judged['baseline'], judges_of(judged, 'real')
    of_real = lambda name: number(real[name]['value'], 2, real[name]['spread'])  # noqa: E731
    rows.append(['real clips', share(real['style']), of_real('content'), number(mean(base, 'expression_of_training_clips')),
                 number(mean(base, 'expression_cosine_of_training_clips')), number(mean(base, 'fmd_real_real'), 1),
                 of_real('movement'), f"{of_real('legs_pose')}; {of_real('legs_movement')}",
                 f"{of_real('trunk_pose')}; {of_real('trunk_movement')}", number(mean(base, 'jitter_120_of_real')), ''])
    return table(['style', 'SRA', 'CRA', 'expression', 'cosine', 'FMD (neutral to target)', 'movement', 'legs: pose; movement',
                  'trunk: pose; movement', 'jerk of means', 'skate, cm/s'], rows)


def made_of(judged, commit):
    made = judged['provenance']
    weights = made.get('weights')
    of = f"`{weights['file']}`, SHA-256 {weights['sha256'][:16]}, " if weights else ''
    judges = made['judges']
    return (f"Of {of}commit {commit}, {judges['count']} judges of SHA-256 {judges['sha256'][:16]}, split {made['split']} of "
            f"{made['manifest']}, {judges_of(judged, 'offset')['style']['windows']:,.0f} windows of {made['inputs']} clips.")


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[1] in ('-h', '--help'):
        print(__doc__)
        return 0 if len(sys.argv) > 1 else 2
    try:
        with open(sys.argv[1], encoding='utf-8') as file:
            judged = json.load(file)
        line = made_of(judged, sys.argv[2] if len(sys.argv) > 2 else 'not said')
        print('\n\n'.join([means(judged), line, by_style(judged), line]))
    except (OSError, json.JSONDecodeError) as error:
        print(f'card.py: {sys.argv[1]}: {error}', file=sys.stderr)
        return 1
    except (KeyError, TypeError, StopIteration) as error:
        print(f'card.py: {sys.argv[1]}: expected what styleeval --json writes: {error!r}', file=sys.stderr)
        return 1
    return 0


if __name__ == '__main__':
    sys.exit(main())
