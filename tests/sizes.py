#!/usr/bin/env python3
"""The longest file, the longest function and the longest blocks that stand twice, of all C++ in git:
where to look first, not limits. A function is found by the layout that clang-format gives it."""

import collections
import pathlib
import re
import subprocess

BLOCK = 8  # lines of code that make a duplicate
SHOWN = 5
NO_FUNCTION = re.compile(r"(if|for|while|switch|else|do|try|catch|namespace|class|struct|enum|union|"
                         r"extern|return|case|default|using)\b|[}\[{]|\w+ = ")


def functions(lines):
    """(length, first line, name) of each function: unindented, or by 2 in a class."""
    in_class = False
    for at, line in enumerate(lines):
        if re.match(r"\w|}", line):
            in_class = bool(re.match(r"(template <.*> )?(class|struct) .*\{$", line))
        if not line.endswith("{") or line.strip() == "{":
            continue
        first = at  # a header of several lines: its continuations are indented by 4 and more
        while first > 0 and re.match(" {4}", lines[first]):
            first -= 1
        indent = len(lines[first]) - len(lines[first].lstrip())
        header = " ".join(part.strip() for part in lines[first:at + 1])
        name = re.match(r"(?:template <.*?> )?[^(=]*?([~\w:]+|operator\S+)\(", header)
        if indent not in (0, 2 if in_class else 0) or not name or NO_FUNCTION.match(header):
            continue
        for last in range(at + 1, len(lines)):
            if lines[last] == " " * indent + "}":
                test = re.match(r"TEST\w*\((\w+), (\w+)\)", header)
                yield last - first + 1, first + 1, f"{test[1]}.{test[2]}" if test else name[1]
                break


def code(lines):
    """(line number, text) of what says something: no comment, include, lone punctuation."""
    for number, line in enumerate(lines, 1):
        text = " ".join(line.split("//")[0].split())
        if re.search(r"\w", text) and not text.startswith(("#include", "using ", "namespace ")):
            yield number, text


def duplicates(files):
    """Longest first: (lines, (file, first, last), (file, first, last)), each run once."""
    seen = collections.defaultdict(list)
    texts = {file: list(code(lines)) for file, lines in files.items()}
    for file, text in texts.items():
        for i in range(len(text) - BLOCK + 1):
            seen[tuple(line for _, line in text[i:i + BLOCK])].append((file, i))
    found, covered = [], set()
    for places in seen.values():
        for (a, i), (b, j) in zip(places, places[1:]):
            if (a, i, b, j) in covered or (a == b and j - i < BLOCK):
                continue
            size = 0
            while (i + size < len(texts[a]) and j + size < len(texts[b]) and
                   texts[a][i + size][1] == texts[b][j + size][1]):
                covered.add((a, i + size, b, j + size))
                size += 1
            found.append((size, (a, texts[a][i][0], texts[a][i + size - 1][0]),
                          (b, texts[b][j][0], texts[b][j + size - 1][0])))
    return sorted(found, reverse=True)


def main():
    root = pathlib.Path(__file__).resolve().parent.parent
    names = subprocess.run(["git", "-C", str(root), "ls-files", "*.h", "*.cpp"], capture_output=True,
                           text=True, check=True).stdout.split()
    files = {name: (root / name).read_text().splitlines() for name in names}
    for what, chosen in (("product", [n for n in names if not n.startswith("tests/")]),
                         ("tests", [n for n in names if n.startswith("tests/")])):
        longest = max(chosen, key=lambda name: len(files[name]))
        size, line, function, file = max((*f, name) for name in chosen for f in functions(files[name]))
        print(f"{what}: longest file {longest} ({len(files[longest])} lines), "
              f"longest function {file}:{line} {function} ({size} lines)")
    found = duplicates(files)
    print(f"{len(found)} blocks of {BLOCK} and more lines of code stand twice")
    for size, (a, a0, a1), (b, b0, b1) in found[:SHOWN]:
        print(f"  {size} lines: {a}:{a0}-{a1} ~ {b}:{b0}-{b1}")


if __name__ == "__main__":
    main()
