#!/usr/bin/python3
"""Runs the benches of a build and prints one table: name, goal, measurement.

    tests/bench/run.py [BUILD=build/release] [--out FOLDER] [--seconds S] [--rounds N] [--priority P]
    tests/bench/run.py [BUILD] --against COMMIT [--write]     this commit beside another one: against.py

Every figure is a ratio within one run, or a count. All are also written to FOLDER/bench.json, and two
plots if Debian's python3-matplotlib is installed. Nothing else should run at the same time.
"""
import argparse
import json
import pathlib
import subprocess
import sys

import against
import figures as of_readme

ROOT = pathlib.Path(__file__).resolve().parents[2]
PERIOD_US = 1e6 / 120

arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
arguments.add_argument('build', nargs='?', default=ROOT / 'build/release', type=pathlib.Path)
arguments.add_argument('--out', default=None, type=pathlib.Path, help='default: BUILD/bench')
arguments.add_argument('--seconds', default=5.0, type=float, help='of each round on the wire')
arguments.add_argument('--rounds', default=3, type=int)
arguments.add_argument('--priority', default=0, type=int, help='SCHED_FIFO of the loops; 0: normal')
arguments.add_argument('--most', default=1000, type=int, help='performers at most')
arguments.add_argument('--against', metavar='COMMIT', help='build it, too, and print ratios of times')
arguments.add_argument('--only', default='', metavar='REGEX', help='with --against: rows whose names match')
arguments.add_argument('--write', action='store_true', help='with --against: history.json, SPEED.md and its plot')
options = arguments.parse_args()
if options.against:
    against.run(options.against, options, of_readme.machine(), of_readme.fnv1a64(of_readme.WEIGHTS))
    sys.exit()
out = options.out or options.build / 'bench'
out.mkdir(parents=True, exist_ok=True)
rows, figures = [], {}


def run(program, *arguments):
    binary = options.build / 'bin' / program
    if not binary.exists():
        sys.exit(f'{binary}: not built; see README.md')
    print('..', program, *arguments, file=sys.stderr)
    subprocess.run([binary, *map(str, arguments)], check=True, stdout=sys.stderr)


def row(what, goal, measured, reached):
    rows.append({'what': what, 'goal': goal, 'measured': measured, 'reached': reached})


def at_most(what, value, limit, unit='', note=''):
    row(what, f'<= {limit:g}{unit}', f'{value:.2f}{unit}{note}', value <= limit)


def steps():
    file = out / 'step.json'
    run('styled_step_bench', '--benchmark_repetitions=5', '--benchmark_report_aggregates_only=true',
        f'--benchmark_out={file}', '--benchmark_out_format=json')
    medians = {b['run_name']: b for b in json.loads(file.read_text())['benchmarks']
               if b['aggregate_name'] == 'median'}
    figures['step'] = medians

    def us(name):
        return medians[name]['cpu_time'] * {'ns': 1e-3, 'us': 1}[medians[name]['time_unit']]

    hot = us('Hot<OurRun>/styles:1')
    at_most('step, hot, to plain Eigen', hot / us('Hot<PlainRun>/styles:1'), 0.8, note=f' ({hot:.1f} us)')
    at_most('the same, to reading its weights as fast as caches give them',
            hot / us('ReadWeights/styles:1'), 1.3)
    row('the same, to as many multiplications from registers', '',
        f'{hot / us("MultiplyWeights/styles:1"):.2f}', None)
    at_most('512 performers together, to one by one',
            us('Crowd<true>/performers:512') / us('Crowd<false>/performers:512'), 0.6)

    def paced(before_us, polled):
        start = f'Paced/before_us:{before_us}/polled:{polled}/'
        return next(b for name, b in medians.items() if name.startswith(start))

    cold = paced(0, 0)['p50_us'] / hot
    for before_us, polled in ((250, 1), (50, 0), (100, 0), (250, 0)):
        found = paced(before_us, polled)
        at_most(f'step, at 120 Hz, prewarmed {before_us} us before, then {"polled" if polled else "slept"}, '
                'to hot', found['p50_us'] / hot, 1.5,
                note=f' (without: {cold:.2f}; the prewarm itself takes {found["prewarm_p50_us"]:.0f} us)')


def wire(name, performers, subscribers, variants, rounds=None, seconds=None):
    file = out / f'{name}.json'
    more = ['--priority', options.priority] if options.priority else []
    run('styled_wire_bench', '--performers', performers, '--subscribers', subscribers, '--rounds',
        rounds or options.rounds, '--seconds', seconds or options.seconds, '--json', file, *more,
        '--only', *variants)
    figures[name] = json.loads(file.read_text())
    return figures[name]


def wires():
    block = ['echo, block', 'styled, block', 'styled, block, prewarm']
    hybrid = ['styled, hybrid, prewarm', 'styled, busy']
    one = wire('wire-1', 1, 1, block + hybrid)
    styled, echo = one['styled, block'], one['echo, block']
    row('where the pipeline spends a frame', 'stated',
        ', '.join(f'{stage} {styled["stages_us"][stage]:.1f} us'
                  for stage in ('take', 'style', 'serialize', 'send')), None)
    at_most('its CPU per frame, to echo', styled['cpu_us_per_frame'] / echo['cpu_us_per_frame'], 2)
    at_most('the same, with prewarm',
            one['styled, block, prewarm']['cpu_us_per_frame'] / echo['cpu_us_per_frame'], 2)
    at_most('hybrid with prewarm, p50, to block',
            one['styled, hybrid, prewarm']['p50_us'] / styled['p50_us'], 0.6,
            note=f' (busy: {one["styled, busy"]["p50_us"] / styled["p50_us"]:.2f})')
    for name, performers, subscribers, most_p50, most_p99 in (
            ('wire-16', 16, 1, 1.7, 2), ('wire-16-32', 16, 32, None, 2)):
        found = wire(name, performers, subscribers, block[:2])
        styled, echo = found['styled, block'], found['echo, block']
        what = f'{performers} performers, {subscribers} subscriber{"s" * (subscribers > 1)}'
        if most_p50:
            at_most(f'{what}: p50 to echo', styled['p50_us'] / echo['p50_us'], most_p50)
        at_most(f'{what}: p99 to echo', styled['p99_us'] / echo['p99_us'], most_p99)
        row(f'{what}: lost', '0', str(styled['lost']), styled['lost'] == 0)
        row(f'{what}: over 8.33 ms, beyond echo', '0',
            f'{styled["over_period"]} (echo {echo["over_period"]})',
            styled['over_period'] <= echo['over_period'])


def crowds():
    """The most performers with no lost frame and 99 % of frames within a period."""
    good, last = 0, {}
    for performers in range(100, options.most + 1, 100):
        found = wire(f'crowd-{performers}', performers, 1, ['echo, block', 'styled, block'], rounds=1)
        last = found['styled, block']
        if last['lost'] or last['p99_us'] > PERIOD_US:
            break
        good = performers
    row('performers with none lost and p99 within 8.33 ms', '>= 300, aim 500', str(good), good >= 300)
    load = last['cpu_us_per_frame'] * 120 * performers * 1e-6
    echo = figures[f'crowd-{performers}']['echo, block']
    row(f'at {performers}', '', f'lost {last["lost"]}, p99 {last["p99_us"] / 1000:.1f} ms, the pipeline '
        f'{100 * load:.0f} % of a core, {last["rss_mb"]:.0f} MB; echo lost {echo["lost"]}', None)


def plot():
    try:
        import matplotlib
    except ImportError:
        return print('no plots: python3-matplotlib is not installed', file=sys.stderr)
    matplotlib.use('svg')
    from matplotlib import pyplot
    pyplot.figure(figsize=(7, 4))
    for name, found in figures['wire-1'].items():
        shares, values = zip(*found['quantiles_us'])
        pyplot.plot(values, shares, label=name, drawstyle='steps-post')
    pyplot.xscale('log')
    pyplot.xlabel('send to receive, us')
    pyplot.ylabel('share of frames')
    pyplot.legend()
    pyplot.tight_layout()
    pyplot.savefig(out / 'latency.svg')
    crowd = sorted((int(name[6:]), found) for name, found in figures.items() if name.startswith('crowd-'))
    pyplot.figure(figsize=(7, 4))
    for variant in ('styled, block', 'echo, block'):
        pyplot.plot([n for n, _ in crowd], [f[variant]['p99_us'] / 1000 for _, f in crowd], 'o-',
                    label=variant)
    pyplot.axhline(PERIOD_US / 1000, linestyle=':')
    pyplot.xlabel('performers at 120 Hz')
    pyplot.ylabel('p99, ms')
    pyplot.legend()
    pyplot.tight_layout()
    pyplot.savefig(out / 'performers.svg')


steps()
wires()
crowds()
(out / 'bench.json').write_text(json.dumps({'rows': rows, 'figures': figures}, indent=1))
width = max(len(r['what']) for r in rows)
for r in rows:
    verdict = {True: 'reached', False: 'NOT REACHED', None: ''}[r['reached']]
    print(f'{r["what"]:{width}}  {r["goal"]:16}  {verdict:12} {r["measured"]}')
plot()
