#!/usr/bin/env python3
"""Checks STYLED_REALTIME through every call: such a function may only call functions of which Clang (20
or later) sees that they do not allocate, lock, block or throw.

  effects.py CLANG BUILD    CLANG: the compiler, e.g. clang++-22; BUILD: a build folder with its
                            compile_commands.json and generated headers

Calls that Clang cannot see (a library's functions, memory that was reserved before) are listed in effects.txt
with the reason why it is allowed there. Fails for a call that is not in the list, for a row of the list
that no longer stands for a call, and where the negative control, a function that allocates, passes.
"""

import json
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
WARNING = re.compile(
    r"^(?P<file>[^:\s]+):\d+:\d+: warning: .*must not (?P<what>.*?) ?\[-Wfunction-effects\]")
CALL = re.compile(r"call non-'nonblocking' (\w+) '(.*)'$")
CONTROL = """#include <vector>
#include "model/base/realtime.h"
STYLED_REALTIME void Grow(std::vector<int>& values) noexcept { values.push_back(1); }
"""


def flags(command):
    """The settings with which a source is compiled: its include folders, definitions and target."""
    words = shlex.split(command)
    kept = []
    for index, word in enumerate(words):
        if word == "-isystem":
            kept += [word, words[index + 1]]
        elif word.startswith(("-I", "-D", "-march", "-std")):
            kept.append(word)
    return kept


def calls(clang, arguments, folder):
    """The calls in one source that Clang does not accept, as (file, callee)."""
    run = subprocess.run([clang, "-fsyntax-only", "-Wno-everything", "-Wfunction-effects", *arguments],
                         cwd=folder, capture_output=True, text=True)
    if run.returncode != 0:
        sys.exit(f"{arguments[-1]} does not compile:\n{run.stderr[:2000]}")
    found = set()
    for line in run.stderr.splitlines():
        match = WARNING.match(line)
        if not match:
            continue
        call = CALL.match(match["what"])
        callee = re.sub(r"\(lambda at [^)]*\)", "(lambda)", call[2] if call else match["what"])
        path = pathlib.Path(folder, match["file"]).resolve()
        if path.is_relative_to(ROOT):
            found.add((str(path.relative_to(ROOT)), callee))
    return found


def allowed():
    rows = {}
    for line in (ROOT / "tests/realtime/effects.txt").read_text().splitlines():
        if line and not line.startswith("#"):
            file, _, callee = line.strip().partition(": ")
            rows[file, callee] = line
    return rows


def main():
    clang, build = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        control = pathlib.Path(folder, "control.cpp")
        control.write_text(CONTROL)
        run = subprocess.run([clang, "-fsyntax-only", "-std=c++20", f"-I{ROOT}", "-Wfunction-effects",
                              str(control)], capture_output=True, text=True)
        if "push_back" not in run.stderr:
            sys.exit(f"{clang} does not notice that the control allocates:\n{run.stderr[:1000]}")
    found, sources = set(), 0
    for entry in json.loads((build / "compile_commands.json").read_text()):
        path = pathlib.Path(entry["file"])
        if not path.is_relative_to(ROOT) or path.is_relative_to(build):
            continue
        name = str(path.relative_to(ROOT))
        # kernel.cpp compiles itself once per SIMD target, in a way that only GCC's flags suit.
        if not name.startswith(("model/", "daemon/", "proto/rigs/")) or name.endswith("kernel.cpp"):
            continue
        if name.startswith(("model/train", "model/tools")):
            continue
        found |= calls(clang, [*flags(entry["command"]), str(path)], entry["directory"])
        sources += 1
    rows = allowed()
    new, gone = sorted(found - rows.keys()), sorted(rows.keys() - found)
    for file, callee in new:
        print(f"{file}: {callee}: not known to be safe on the hot path, and not in effects.txt")
    for row in gone:
        print(f"effects.txt: \"{rows[row]}\" stands for no call any more")
    print(f"{sources} sources, {len(found)} calls that need a reason, {len(new)} without one")
    return 1 if new or gone or not sources else 0


if __name__ == "__main__":
    sys.exit(main())
