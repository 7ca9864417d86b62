#!/usr/bin/env python3
"""Prints which tests were skipped, by reason, from the JUnit files that ctest wrote.

skipped.py FILE...    a line per reason: how many tests, why, and the name of one of them
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


if __name__ == '__main__':
    main(sys.argv[1:])
