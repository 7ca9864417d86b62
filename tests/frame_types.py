#!/usr/bin/env python3
"""Types that a frame wears between the rig's translator and the subscriber: the records that the functions
on its way take, give and fill, without the objects that outlive a frame. Prints them; fails when there are
more than MOST, or when a function of the way is no longer found. Before that it checks itself on a way that
has one type too many."""

import pathlib
import re
import sys

MOST = 12
# The way, in its order: header, and the functions that a frame passes there.
WAY = [
    ("daemon/source/transport.h", ["OnFrames"]),
    ("daemon/perform/frame_processor.h", ["Process", "ProcessFrame", "Decide", "FillFrame", "Refuse"]),
    ("daemon/decide/decider.h", ["OfFrame"]),
    ("daemon/perform/performer/performer.h", ["Accept", "Style", "Finish", "Repeat", "Send"]),
    ("model/stylist/stylist.h", ["ProcessTogether", "Process"]),
    ("daemon/perform/performer/outputs.h", ["Retarget", "Serialize"]),
    ("daemon/publish/frame_message.h", ["SetHeader", "SetStyles", "SetPose", "Serialize"]),
    ("daemon/log/writer.h", ["OnFrames"]),
    ("daemon/log/frame_history.h", ["FillFate", "Add"]),
    ("daemon/log/entry.h", ["Write"]),
]
# Types that outlive a frame, and types of numbers.
LASTING = set("Admission Bundle CarriedProps Counter HotSection Layer Performer Publisher Styling Writer".split())
NUMBERS = set("Quat Timecode Vec3".split())
TYPE = re.compile(r"\b(?:\w+::)*([A-Z][a-z]\w*)\b(?=\s*[&*>]|\s+\w+\s*[,)=(])")


def signatures(text, function):
    """The declarations of `function` in a header: from the line before its name to the closing bracket."""
    text = re.sub(r"//[^\n]*", "", text)
    for match in re.finditer(r"[;{}:]\s*([^;{}]*?\b" + function + r"\s*\([^;{]*\))", text):
        yield match[1]


def types_of(signature, function):
    found = set()
    for name in TYPE.findall(signature):
        if name != function and name not in LASTING | NUMBERS:
            found.add(name)
    returned = re.match(r"(?:STYLED_REALTIME\s+)?(?:static\s+)?(?:std::span<const\s+)?(?:\w+::)*([A-Z][a-z]\w*)",
                        signature.strip())
    if returned and returned[1] not in LASTING | NUMBERS | {function}:
        found.add(returned[1])
    return found


def worn(read):
    """{type: header}, and the functions that were not found."""
    types, missing = {}, []
    for header, functions in WAY:
        text = read(header)
        for function in functions:
            found = list(signatures(text, function))
            if not found:
                missing.append(f"{header}: no {function}")
            for signature in found:
                for name in types_of(signature, function):
                    types.setdefault(name, header)
    return types, missing


def main():
    root = pathlib.Path(__file__).resolve().parent.parent
    read = lambda header: (root / header).read_text()
    types, missing = worn(read)
    more = lambda header: read(header) + "".join(f"\nvoid Accept(const Extra{i}& a);" for i in range(MOST))
    if len(worn(more)[0]) <= MOST or not worn(lambda header: "")[1]:
        print("tests/frame_types.py does not notice types that are too many, or functions that are gone")
        return 1
    for name, header in types.items():
        print(f"{name:16} {header}")
    for line in missing:
        print(line)
    print(f"{len(types)} types, expected at most {MOST}")
    return 0 if not missing and len(types) <= MOST else 1


if __name__ == "__main__":
    sys.exit(main())
