#!/usr/bin/env python3
"""Compiles every header alone: `headers.py BUILD [HEADER...]`, BUILD with its generated headers built. Prints
the headers that lack an include, or `N headers stand alone`; before that, one that lacks an include must be
found.

Two libraries take most of the time, Eigen and protobuf. A header that includes one of them, directly or by
others, would see all of it anyway; for these headers, and for no other, it comes precompiled.
"""

import concurrent.futures
import functools
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
FLAGS = ["-std=c++20", "-march=x86-64-v3", "-I", str(ROOT), "-isystem", "/usr/include/eigen3"]
LEFT_OUT = re.compile(r"^model/train/|_torch\.h$")  # libtorch's users: minutes each
INCLUDE = re.compile(r'^#include [<"]([^">]+)[">]', re.M)
# The includes of a generated header of lite messages.
MESSAGES = ["google/protobuf/" + name for name in (
    "io/coded_stream.h", "arena.h", "arenastring.h", "generated_message_util.h", "metadata_lite.h",
    "message_lite.h", "repeated_field.h", "extension_set.h")]


class Headers:
    def __init__(self, build):
        self.generated = pathlib.Path(build).resolve() / "generated"
        self.folder = tempfile.TemporaryDirectory()

    @functools.lru_cache(maxsize=None)
    def closure(self, name):
        """All that a header of ours includes, by the names it uses."""
        file = next((f for f in (ROOT / name, self.generated / name) if f.is_file()), None)
        if file is None:
            return frozenset([name])
        names = INCLUDE.findall(file.read_text())
        return frozenset([name]).union(*(self.closure(other) for other in names))

    def libraries(self, name):
        names = self.closure(name)
        found = [eigen for eigen in ("Eigen/Core", "Eigen/Geometry") if eigen in names]
        return tuple(found + (MESSAGES if any(n.endswith(".pb.h") for n in names) else []))

    @functools.lru_cache(maxsize=None)
    def precompiled(self, libraries):
        """The header of these libraries, compiled; None for none."""
        if not libraries:
            return None
        file = pathlib.Path(self.folder.name) / f"libraries{abs(hash(libraries))}.h"
        file.write_text("".join(f"#include <{name}>\n" for name in libraries))
        subprocess.run(["g++", *FLAGS, "-x", "c++-header", str(file), "-o", f"{file}.gch"], check=True)
        return file

    def errors(self, name, text=None):
        """The messages of g++ for a source that includes the header alone; "" for none."""
        before = self.precompiled(self.libraries(name))
        options = ["-include", str(before)] if before else []
        source = text or f'#include "{name}"\n'
        done = subprocess.run(["g++", *FLAGS, "-I", str(self.generated), *options, "-fsyntax-only", "-x", "c++", "-"],
                              input=source, capture_output=True, text=True, cwd=ROOT)
        return "" if done.returncode == 0 else done.stderr or "g++ failed"


def main():
    headers = Headers(sys.argv[1])
    names = sys.argv[2:] or subprocess.run(["git", "ls-files", "*.h"], cwd=ROOT, capture_output=True, text=True,
                                           check=True).stdout.split()
    names = [name for name in names if not LEFT_OUT.search(name)]
    control = "model/body/pose.h"  # has Eigen, but no std::map
    if not headers.errors(control, f'#include "{control}"\nstd::map<int, int> missing;\n'):
        sys.exit("headers: a missing include was not noticed")
    for name in names:  # before the threads: each library once
        headers.precompiled(headers.libraries(name))
    bad = 0
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        for name, errors in zip(names, pool.map(headers.errors, names)):
            if errors:
                bad += 1
                print(f"header is not self-contained: {name}\n{errors}")
    print(f"{bad} of {len(names)} headers do not stand alone" if bad else f"{len(names)} headers stand alone")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
