"""Compares this commit's speed with another's: `run.py --against COMMIT`.

Builds both, runs each benchmark of both in turn, and prints the ratio of the times with its interval. A
ratio of one round is of two runs one after the other, so that other work on the machine disturbs both.
"""
import datetime
import json
import pathlib
import random
import re
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
HISTORY = ROOT / 'tests/bench/history.json'
# Times that a user feels, as (program, pattern, what it is). Names must not change between commits; rows that one of
# the two lacks are left out, and said.
BENCHES = [
    ('styled_step_bench', r'Hot<ShippedRun>/styles:1$', 'one step of v2'),
    ('styled_step_bench', r'ReadWeights<ShippedRun>/styles:1$', 'reading the bytes of that step once'),
    ('styled_stylist_bench', r'WholeStylist/styles:1/feet:1/network:6/neutral:1$', 'one frame of v2'),
    ('styled_stylist_bench', r'WholeStylist/styles:1/feet:1/network:8/neutral:1$', 'one frame of v2, AVX2'),
    ('styled_stylist_bench', r'WholeStylist/styles:1/feet:1/network:2/neutral:0$', 'one frame of graph'),
    ('styled_stylist_bench', r'Crowd/network:6/together:16$', '64 performers of v2, sixteen together'),
    ('styled_stylist_bench', r'Paced/network:6/', 'one frame of v2 at 120 Hz, caches cold'),
    ('styled_rig_bench', r'Crowd/threads:1/graph:0', '64 performers of v2 through the pipeline'),
    ('styled_rig_bench', r'Crowd/threads:2/graph:0', 'the same, two styling threads'),
    ('styled_rig_bench', r'Published/vmc$', "a VMC sender's frame, decoded to published"),
]


def output(*command, cwd=ROOT):
    return subprocess.run([*map(str, command)], check=True, capture_output=True, text=True, cwd=cwd).stdout


def build(commit, folder, benches):
    """A worktree of the commit in `folder`, with the programs of these benches built."""
    if not folder.exists():
        output('git', 'worktree', 'add', '--detach', folder, commit)
    targets = sorted({program for program, _, _ in benches})
    print(f'.. building {commit} in {folder}', file=sys.stderr)
    output('cmake', '--preset', 'release', '-DSTYLED_UNITY=ON', '-DSTYLED_TESTS=ON', '-DSTYLED_TRAIN=OFF', cwd=folder)
    output('cmake', '--build', '--preset', 'release', '--target', *targets, cwd=folder)
    return folder / 'build/release/bin'


def microseconds(bin_folder, program, pattern, seconds):
    """The time of one benchmark, or None if this build lacks it."""
    ran = subprocess.run([bin_folder / program, f'--benchmark_filter={pattern}', f'--benchmark_min_time={seconds}',
                          '--benchmark_format=json'], check=True, capture_output=True, text=True).stdout
    if '"benchmarks"' not in ran:
        return None
    rows = json.loads(ran[ran.index('{'):])['benchmarks']
    if not rows:
        return None
    row = rows[0]
    return row['real_time'] * {'ns': 1e-3, 'us': 1, 'ms': 1e3}[row['time_unit']]


def interval(ratios, draws=2000):
    """The median, and the middle 95 of 100 medians of as many ratios drawn from these (bootstrap)."""
    dice = random.Random(1)
    medians = sorted(statistics.median(dice.choices(ratios, k=len(ratios))) for _ in range(draws))
    return statistics.median(ratios), medians[int(0.025 * draws)], medians[int(0.975 * draws)]


def compare(ours, theirs, benches, rounds, seconds):
    """Rows of {name, us, ratio, low, high}: this build's time, and it divided by the other's."""
    rows = []
    for program, pattern, name in benches:
        pairs = []
        for turn in range(rounds):
            order = (theirs, ours) if turn % 2 == 0 else (ours, theirs)
            times = {folder: microseconds(folder, program, pattern, seconds) for folder in order}
            if None in times.values():
                break
            pairs.append((times[ours], times[theirs]))
        if not pairs:
            print(f'.. {name}: only one of the two has it', file=sys.stderr)
            continue
        ratio, low, high = interval([a / b for a, b in pairs])
        rows.append({'name': name, 'us': round(statistics.median(a for a, _ in pairs), 2), 'ratio': round(ratio, 3),
                     'low': round(low, 3), 'high': round(high, 3)})
        print(f'.. {name}: {ratio:.2f}', file=sys.stderr)
    return rows


def show(entry):
    print(f"{entry['commit']} to {entry['against']}, weights {entry['weights']}, {entry['machine']}, load "
          f"{entry['load']}, {entry['rounds']} rounds in turn")
    width = max(len(row['name']) for row in entry['rows'])
    print(f"{'':{width}} {'us':>9}  ratio  interval")
    for row in entry['rows']:
        print(f"{row['name']:{width}} {row['us']:9.1f}  {row['ratio']:5.2f}  {row['low']:.2f} to {row['high']:.2f}")


def run(commit, options, machine, weights):
    named = output('git', 'rev-parse', '--short=12', commit).strip()
    changed = output('git', 'status', '--porcelain').strip()
    ours = output('git', 'rev-parse', '--short=12', 'HEAD').strip() + ('+' if changed else '')
    benches = [bench for bench in BENCHES if re.search(options.only, bench[2])]
    theirs = build(named, ROOT / 'build/against' / named, benches)
    load = pathlib.Path('/proc/loadavg').read_text().split()[0]
    entry = {'commit': ours, 'against': named, 'weights': weights, 'machine': machine, 'load': load,
             'day': datetime.date.today().isoformat(), 'rounds': options.rounds,
             'rows': compare(options.build.resolve() / 'bin', theirs, benches, options.rounds, options.seconds / 10)}
    show(entry)
    if not options.write:
        return
    if changed:
        sys.exit('--write: there are changes that no commit has; commit them, build, and measure again')
    history = json.loads(HISTORY.read_text()) if HISTORY.exists() else []
    history = [kept for kept in history if (kept['commit'], kept['machine']) != (ours, machine)] + [entry]
    HISTORY.write_text(re.sub(r'\{\s+"name": ([^{}]*?)\s+\}', lambda m: '{"name": ' + ' '.join(m.group(1).split()) + '}',
                              json.dumps(history, indent=1)) + '\n')
    write_page(history)


PAGE = ROOT / 'tests/bench/SPEED.md'
PLOT = ROOT / 'tests/bench/speed.svg'
HEAD = """# Speed over commits

`tests/bench/run.py --against COMMIT --write` measures and writes this page; nothing here is written by hand. A
ratio is this commit's time to the other's, each benchmark of both in turn; the numbers behind it hold 95 of
100 such medians. Microseconds belong to the machine; ratios may be compared.

![Speed over commits](speed.svg)

"""


def page_of(history):
    parts = [HEAD]
    for entry in reversed(history):
        parts.append(f"## {entry['commit']} to {entry['against']}\n\n{entry['day']}, {entry['machine']}, load "
                     f"{entry['load']}, {entry['rounds']} rounds, weights {entry['weights']}\n\n"
                     '| what | us | ratio | |\n|---|---|---|---|\n')
        parts += [f"| {row['name']} | {row['us']:.1f} | {row['ratio']:.2f} | {row['low']:.2f} to {row['high']:.2f} |\n"
                  for row in entry['rows']]
        parts.append('\n')
    return ''.join(parts).rstrip('\n') + '\n'


def chains(history):
    """{(machine, row name): [(commit, time relative to the first commit of its chain)]}."""
    found = {}
    for entry in history:
        for row in entry['rows']:
            chain = found.setdefault((entry['machine'], row['name']), [(entry['against'], 1.0)])
            before = dict(chain).get(entry['against'])
            if before is not None:
                chain.append((entry['commit'], before * row['ratio']))
    return found


def write_page(history):
    PAGE.write_text(page_of(history))
    try:
        import matplotlib
    except ImportError:
        sys.exit('the plot is not drawn: python3-matplotlib is not installed')
    matplotlib.use('svg')
    matplotlib.rcParams.update({'svg.fonttype': 'none', 'svg.hashsalt': 'styled'})
    from matplotlib import pyplot
    machines = sorted({entry['machine'] for entry in history})
    _, axes = pyplot.subplots(len(machines), 1, figsize=(8, 4 * len(machines)), squeeze=False)
    for axis, name in zip(axes[:, 0], machines):
        for (machine, row), chain in chains(history).items():
            if machine == name:
                axis.plot([commit[:8] for commit, _ in chain], [value for _, value in chain], 'o-', label=row)
        axis.set_title(name, fontsize=9)
        axis.set_ylabel('time, first commit = 1')
        axis.set_ylim(bottom=0)
        axis.legend(fontsize=6)
    pyplot.tight_layout()
    pyplot.savefig(PLOT, metadata={'Date': None})
