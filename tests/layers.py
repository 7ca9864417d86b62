#!/usr/bin/env python3
"""Which folder may include which. Prints `FILE:LINE: INCLUDE: RULE` for each include that breaks a rule,
or `N includes, R rules, held`. Before that it breaks each rule once, by an include that is not in the tree: a
rule that does not notice is a failure too. The table of daemon/README.md and the picture tests/layers.svg must
say the same; `--write` writes both.

A folder's row covers the folders below that have no row. A folder may include itself; what a row names
means the folders below it, too. Generated and system headers are not looked at.
"""

import pathlib
import re
import subprocess
import sys

import layers_picture

STAGES = "model/base model/body model/rig"
ROWS = {
    # Motion without sockets: each stage knows only those before it.
    "model/base": "",
    "model/body": "model/base",
    "model/rig": "model/base model/body",
    "model/gait": "model/base model/body",
    "model/neutral": "model/base model/body model/gait",
    "model/synthetic": STAGES,
    "model/clip": STAGES,
    "model/feet": STAGES,
    "model/idle": STAGES + " model/feet",
    "model/devices": STAGES + " model/feet",
    "model/offline": STAGES + " model/clip model/gait model/neutral",
    "model/net": STAGES + " model/gait model/neutral model/net",
    "model/net/kernels": "model/base",
    "model/stylist": STAGES + " model/feet model/gait model/neutral model/net",
    "model/trial": STAGES + " model/net model/stylist model/synthetic",
    "model/train": STAGES + " model/clip model/gait model/neutral model/net",
    "model/train/erd": STAGES + " model/clip model/net model/train",
    "model/train/stgcn": STAGES + " model/clip model/net model/train",
    "model/train/stgcn_causal": STAGES + " model/clip model/net model/train",
    "model/train/baselines": STAGES + " model/clip model/net model/train",
    "model/train/judge": STAGES + " model/clip model/feet model/gait model/neutral model/net model/stylist model/trial model/train",
    "model/tools": "model",
    "model/library": STAGES + " model/clip model/neutral model/offline model/net model/stylist model/trial",
    # Bytes that cross a process border.
    "proto/ipc": "model/base",
    "proto/keys": "model/base",
    "proto/recording": "model/base proto/styled proto/rigs/native",
    "proto/arkit": "model/base",
    "proto/ptp": "model/base",
    "proto/rigs": "model/base proto/arkit",
    "proto/styled": "model/base model/body",
    # The daemon: a folder includes only folders further down.
    "daemon": "daemon model proto",
    "daemon/control": "daemon/styles daemon/looks daemon/security daemon/config daemon/runtime proto model/base"
                      " model/body",
    "daemon/replay": "daemon/pipeline daemon/styles daemon/looks daemon/source daemon/config daemon/runtime proto model",
    "daemon/pipeline": "daemon/standby daemon/perform daemon/decide daemon/styles daemon/looks daemon/log"
                       " daemon/publish daemon/source daemon/config daemon/runtime proto model",
    "daemon/standby": "daemon/perform daemon/decide daemon/styles daemon/looks daemon/log daemon/publish"
                      " daemon/source daemon/security daemon/config daemon/runtime proto/styled proto/rigs/native model",
    "daemon/perform": "daemon/styles daemon/looks daemon/log daemon/publish daemon/decide daemon/source"
                      " daemon/config daemon/runtime proto model",
    "daemon/styles": "daemon/looks daemon/config daemon/runtime proto model",
    "daemon/looks": "daemon/publish daemon/decide daemon/config daemon/runtime proto/styled model",
    "daemon/log": "daemon/decide daemon/source daemon/config daemon/runtime proto model/base model/body",
    "daemon/publish": "daemon/decide daemon/security daemon/config daemon/runtime proto/styled model/net " + STAGES,
    "daemon/decide": "daemon/source daemon/runtime proto/styled model/base",
    "daemon/source": "daemon/config daemon/runtime proto model/devices " + STAGES,
    "daemon/security": "daemon/config daemon/runtime proto/keys proto/ipc model/base",
    "daemon/config": "daemon/runtime proto/rigs proto/styled " + STAGES + " model/net model/stylist",
    "daemon/runtime": "model/base proto/ipc proto/ptp proto/rigs/native",
    # Senders and receivers: neither includes the daemon nor a network.
    "clients": "clients proto model/clip " + STAGES,
    "sim": "sim proto model/clip model/synthetic " + STAGES,
    "tests": "tests model proto daemon clients sim",
}
# Single headers beyond a row, each with its reason.
ALSO = {
    ("proto/rigs/vrchat", "proto/rigs/vmc/osc.h"): "both formats are OSC",
    ("clients/rec", "sim/player"): "a recording is played by what plays clips",
    ("proto/styled", "model/net/styles.h"): "the limits of what may be asked of a network, once",
    ("clients", "model/tools/number.h"): "an option's number, for all command lines",
    ("sim", "model/tools/number.h"): "an option's number, for all command lines",
}
# A family that runs another's network in another way, and that other one.
BUILT_ON = {"stgcn_causal": "stgcn"}
FAMILY_RULE = "a network's family is known to itself, model/train and model/net/load.cpp"
RIG_RULE = "a rig's codec includes no other rig's"
TESTS_RULE = "nobody includes tests/"
BEGIN, END = "<!-- written by tests/layers.py --write -->\n", "<!-- end -->\n"
INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"')


def within(path, folder):
    return path == folder or path.startswith(folder + "/")


def row_of(path):
    return max((row for row in ROWS if within(path, row)), key=len, default=None)


def family_of(path):
    """'erd' of model/net/erd/network.h; '' of what is of no family."""
    match = re.match(r"model/net/([\w-]+)/", path)
    return match[1] if match and match[1] != "kernels" else ""


def broken_rule(file, header):
    """The rule that `file` breaks when it includes `header`, else ''."""
    folder = file.rpartition("/")[0]
    row = row_of(folder)
    if row is None:
        return "a folder without a row in tests/layers.py"
    if within(header, "tests") and not within(file, "tests"):
        return TESTS_RULE
    family = family_of(header)
    if family and not within(file, "tests"):
        if within(file, f"model/net/{family}") or within(file, "model/train") or within(file, "model/tools"):
            return ""
        if BUILT_ON.get(family_of(file)) == family:
            return ""
        return "" if file == "model/net/load.cpp" else FAMILY_RULE
    if any(within(file, a) and within(header, b) for a, b in ALSO):
        return ""
    if row == row_of(header.rpartition("/")[0]):
        parts = header.split("/")  # files beside the rigs' folders are for all of them
        shared = row != "proto/rigs" or len(parts) == 3
        return "" if shared or parts[2] == file.split("/")[2] else RIG_RULE
    if any(within(header, to) for to in ROWS[row].split()):
        return ""
    return f"{row} may include {ROWS[row] or 'only itself'}"


def unnoticed(texts):
    """Rules that let an include pass that breaks them, rows of daemon/ that name one further up, and what is
    written here and may say something else."""
    missed = []
    above = set()
    for row, allowed in ROWS.items():
        above.add(row)
        missed += [f"{row}: {name} is further up" for name in allowed.split()
                   if name.startswith("daemon/") and name in above and row != "daemon"]
    for row, allowed in ROWS.items():
        forbidden = "daemon/supervisor.h" if row != "daemon" else "clients/cpp/control.h"
        if row != "tests" and not broken_rule(f"{row}/nobody.cpp", forbidden):
            missed.append(f"{row}: {allowed}")
    good = {file: write(text) for (file, write), text in zip(WRITTEN.items(), texts.values())}
    for file, text in good.items():
        if stale({**good, file: text.replace("runtime", "elsewhere")}) != [file]:
            missed.append(f"{file} with another folder")
    for file, header in (
            ("model/stylist/stylist.cpp", "model/net/erd/network.h"),
            ("daemon/pipeline/pipeline.cpp", "model/net/stgcn/network.h"),
            ("model/net/erd/network.cpp", "model/net/stgcn/network.h"),
            ("model/net/stgcn/network.cpp", "model/net/stgcn_causal/network.h"),
            ("daemon/config/config.h", "daemon/source/transport.h"),
            ("model/body/pose.h", "model/rig/rig.h"),
            ("model/train/trainer.cpp", "model/train/erd/learner.h"),
            ("model/tools/styleeval.cpp", "sim/player/player.h"),
            ("proto/rigs/vmc/vmc.cpp", "proto/rigs/mvn/mvn.h"),
            ("daemon/runtime/clock.h", "tests/support/daemon.h"),
            ("surprise/file.cpp", "model/base/status.h")):
        if not broken_rule(file, header):
            missed.append(f"{file} including {header}")
    return missed


def table():
    """The rows of daemon/, from the top down, for daemon/README.md."""
    lines = ["| folder | may include, of `daemon/` | and |", "|---|---|---|",
             "| `supervisor`, `files_thread`, `main` | all | all of `model/` and `proto/` |"]
    for row, allowed in ROWS.items():
        if not row.startswith("daemon/"):
            continue
        own = [name.removeprefix("daemon/") for name in allowed.split() if name.startswith("daemon/")]
        other = [name for name in allowed.split() if not name.startswith("daemon/")]
        cells = [", ".join(f"`{name}`" for name in names) for names in (own, other)]
        lines.append(f"| `{row.removeprefix('daemon/')}/` | {cells[0]} | {cells[1]} |")
    return "\n".join(lines) + "\n"


def written(readme):
    """The page with the table as it should be."""
    before, begin, rest = readme.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        sys.exit(f"daemon/README.md: expected {BEGIN.strip()} and {END.strip()}")
    return before + begin + table() + end + after


# The files of --write, and functions that return their text as it should be.
WRITTEN = {"daemon/README.md": written, "tests/layers.svg": lambda _: layers_picture.picture(ROWS)}


def stale(texts):
    """The files of WRITTEN that differ; `texts`: {file: its text}."""
    return [file for file, write in WRITTEN.items() if write(texts[file]) != texts[file]]


def main():
    root = pathlib.Path(__file__).resolve().parent.parent
    texts = {file: (root / file).read_text() for file in WRITTEN}
    if sys.argv[1:] == ["--write"]:
        for file, write in WRITTEN.items():
            (root / file).write_text(write(texts[file]))
        return 0
    missed = unnoticed(texts)
    for rule in missed:
        print(f"tests/layers.py: a rule does not notice when it is broken: {rule}")
    files = subprocess.run(["git", "-C", str(root), "ls-files", "*.h", "*.cpp"],
                           capture_output=True, text=True, check=True).stdout.split()
    known = set(files)
    includes = broken = 0
    for file in files:
        for number, line in enumerate((root / file).read_text().splitlines(), 1):
            match = INCLUDE.match(line)
            if not match or not (match[1] in known or match[1].endswith(".pb.h")):
                continue
            includes += 1
            rule = broken_rule(file, match[1])
            if rule:
                broken += 1
                print(f"{file}:{number}: {match[1]}: {rule}")
    if broken or missed:
        print(f"{broken} of {includes} includes break a rule")
        return 1
    old = stale(texts)
    for file in old:
        print(f"{file}: is not what tests/layers.py --write writes")
    if old:
        return 1
    print(f"{includes} includes, {len(ROWS) + 3} rules, held")
    return 0


if __name__ == "__main__":
    sys.exit(main())
