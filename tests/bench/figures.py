#!/usr/bin/python3
"""Measures every figure of README.md and prints the table of them.

    tests/bench/figures.py [BUILD=build/release] [--only NAME] [--write]

Each row has the sentence that README.md says, the command, the weights' hash, the commit, the machine and
the day. --write puts the table into tests/bench/FIGURES.md and the sentences into README.md, between the
comments <!--NAME--> and <!--/-->. Nothing else should run at the same time; it takes about ten minutes, and
real-time priority (root). tests/documents/test_figures.py compares the three.
"""
import argparse
import datetime
import json
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
WEIGHTS = ROOT / 'model/weights/v2.safetensors'
TABLE = ROOT / 'tests/bench/FIGURES.md'
HEAD = """# The figures of README.md

`tests/bench/figures.py --write` measures them and writes this page and the sentences of README.md; nothing
here is written by hand. Weights: the hash of `model/weights/v2.safetensors`, as recordings name it, or "-" where the test has random ones.

| figure | what README says | command | weights | commit | machine | day |
|---|---|---|---|---|---|---|
"""


def fnv1a64(file):
    """The hash of a file of weights, as proto/recording names it."""
    value = 0xcbf29ce484222325
    for byte in file.read_bytes():
        value = (value ^ byte) * 0x100000001b3 & 0xffffffffffffffff
    return f'fnv1a64:{value:016x}'


def output(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT).stdout


def machine():
    name = re.search(r'^model name\s*: (.*)$', pathlib.Path('/proc/cpuinfo').read_text(), re.MULTILINE)
    flags = pathlib.Path('/proc/cpuinfo').read_text().split()
    wide = [flag for flag in ('avx512_bf16', 'amx_bf16', 'avx512f', 'avx2') if flag in flags][:1]
    cores = len(re.findall(r'^processor', pathlib.Path('/proc/cpuinfo').read_text(), re.MULTILINE))
    return f"{name.group(1).strip() if name else 'unknown'}, {cores} cores, {''.join(wide)}"


def wire(build):
    """From a sender's send to a subscriber's recv, beside an echo of the daemon's loop and sockets."""
    with tempfile.NamedTemporaryFile(suffix='.json') as out:
        command = [str(build / 'bin/styled_wire_bench'), '--performers', '16', '--rounds', '6', '--seconds', '10',
                   '--priority', '50', '--cpu', '1', '--only', 'echo, block', '--only', 'styled, block', '--json', out.name]
        sys.stderr.write(output(*command))
        rows = json.load(open(out.name, encoding='utf-8'))
    ours = rows['styled, block']
    echo = rows['echo, block']
    sentence = (f"Sixteen performers at 120 Hz: of {ours['sent']:,} frames {ours['lost'] or 'none'} got lost, and "
                f"{ours['over_period'] or 'none'} took longer than a frame's period (8.33 ms) from the sender's socket to the "
                f"subscriber's. The median is {ours['p50_us'] / 1000:.2f} ms, {ours['p50_us'] / echo['p50_us']:.1f} times "
                f"that of a bare echo loop ({echo['over_period'] or 'none'} of whose frames took longer).")
    return sentence, command, True


def standby(build):
    """A leader that is killed again and again, beside a daemon that is never killed."""
    command = ['env', 'STYLED_ROUNDS=50', str(build / 'bin/styled_standby_e2e_test'),
               '--gtest_filter=*KilledAgainAndAgain*']
    said = output(*command)
    sys.stderr.write(said)
    gaps = [int(ms) for ms in re.findall(r'kill \d+: (\d+) ms', said)]
    frames, lost, other = map(int, re.search(r'(\d+) frames, (\d+) lost, (\d+) with another pose', said).groups())
    sentence = (f"Of two daemons the leading one was killed {len(gaps)} times: of {frames:,} frames {lost or 'none'} got "
                f"lost, {other or 'none'} differed in a bit, and the other daemon went on within {max(gaps) / 1000:.2f} s.")
    return sentence, command, False


FIGURES = {'wire': wire, 'standby': standby}


def shown(command, build):
    """A command as a reader types it: no temporary file, no absolute path."""
    text = ' '.join(f'"{word}"' if ' ' in word else word for word in command)
    text = re.sub(r' --json \S+', '', text)
    return text.replace(str(build), 'build/release').replace(str(ROOT) + '/', '')


def rows_of(page):
    """{name: cells after it} of a table as this writes it."""
    return {cells[0]: cells[1:] for cells in
            (re.split(r' \| ', line.strip('| ')) for line in page.splitlines() if re.match(r'\| [a-z]+ \| \S', line))
            if cells[0] != 'figure'}


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument('build', nargs='?', default=ROOT / 'build/release', type=pathlib.Path)
    arguments.add_argument('--only', choices=FIGURES)
    arguments.add_argument('--write', action='store_true', help='README.md and tests/bench/FIGURES.md')
    options = arguments.parse_args()
    rows = rows_of(TABLE.read_text(encoding='utf-8')) if TABLE.exists() else {}
    commit = output('git', 'rev-parse', '--short=12', 'HEAD').strip()
    for name, measure in FIGURES.items():
        if options.only in (None, name):
            sentence, command, ours = measure(options.build)
            rows[name] = [sentence, f'`{shown(command, options.build)}`', fnv1a64(WEIGHTS) if ours else '-', commit,
                          machine(), datetime.date.today().isoformat()]
    table = HEAD + ''.join(f"| {' | '.join([name, *cells])} |\n" for name, cells in sorted(rows.items()))
    print(table)
    if options.write:
        TABLE.write_text(table, encoding='utf-8')
        readme = (ROOT / 'README.md').read_text(encoding='utf-8')
        for name, cells in rows.items():
            readme = re.sub(rf'(<!--{name}-->).*?(<!--/-->)', lambda found: found.group(1) + cells[0] + found.group(2),
                            readme, flags=re.DOTALL)
        (ROOT / 'README.md').write_text(readme, encoding='utf-8')


if __name__ == '__main__':
    main()
