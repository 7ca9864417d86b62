#!/usr/bin/env python3
"""Prints which tests were skipped, by reason, and the output of those that failed, from the JUnit files of ctest.

outcomes.py FILE...    a line per reason: how many tests, why, and the name of one of them; then the
                       last lines of each failed test, of at most twelve tests
"""
import collections
import re
import sys
import xml.etree.ElementTree as tree


def reason_of(output):
    """The reason a test gave when it skipped itself: GoogleTest's message, or its last line."""
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    for at, line in enumerate(lines):
        if line.endswith(': Skipped') and at + 1 < len(lines):
            return lines[at + 1]
    said = [line for line in lines if re.search(r'\bskip|\bno\b', line, re.IGNORECASE)]
    return (said or lines or ['gives no reason'])[-1]


_MOST_LINES = 40  # of one test: a failure of Python's unittest with its traceback, and what came before
_MOST_TESTS = 12  # more are one fault


def failed(file):
    for case in tree.parse(file).iter('testcase'):
        if case.find('failure') is not None:
            yield case.get('name'), (case.findtext('system-out') or '').splitlines()[-_MOST_LINES:]


def skipped(file):
    for case in tree.parse(file).iter('testcase'):
        if case.find('skipped') is None or case.get('status') == 'disabled':
            continue
        yield case.get('name'), reason_of(case.findtext('system-out') or '')


def main(files):
    by_reason = collections.defaultdict(list)
    for file in files:
        for name, reason in skipped(file):
            # The same reason, whatever the folder.
            by_reason[re.sub(r' in "?/\S*', '', reason)].append(name)
    for reason, names in sorted(by_reason.items(), key=lambda row: -len(row[1])):
        print(f'skipped {len(names)}: {reason} ({names[0]}{", ..." if len(names) > 1 else ""})')
    bad = [test for file in files for test in failed(file)]
    for name, lines in bad[:_MOST_TESTS]:
        print(f'FAILED {name}:', *lines, sep='\n  ')
    if len(bad) > _MOST_TESTS:
        print(f'and {len(bad) - _MOST_TESTS} more failed')


if __name__ == '__main__':
    main(sys.argv[1:])
