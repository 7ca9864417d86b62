#!/usr/bin/env python3
"""The manifest of The 100STYLE Dataset's unpacked archive, on standard output: each style's walk (FW), run (FR) and
idle (ID), within the frames of Frame_Cuts.csv. What is missing or cut wrongly is said on standard error and left out;
the exit status is 1 if nothing is left."""

import csv
import pathlib
import re
import sys

TAKES = {"FW": "walk", "FR": "run", "ID": "stand"}
NEUTRAL = "Neutral"


def frames_of(bvh):
    """The number of frames that the file states; 0 if it states none."""
    with open(bvh, errors="replace") as lines:
        for line in lines:
            found = re.match(r"\s*Frames:\s*(\d+)", line)
            if found:
                return int(found[1])
    return 0


def find(folder, name):
    """STYLE/STYLE_FW.bvh, or STYLE_FW.bvh in the folder itself; None if there is neither."""
    style = name.rpartition("_")[0]
    for path in (folder / style / f"{name}.bvh", folder / f"{name}.bvh"):
        if path.is_file():
            return path
    return None


def cuts_of(folder, complain):
    """{style: {take: (first, last)}} of Frame_Cuts.csv."""
    file = folder / "Frame_Cuts.csv"
    if not file.is_file():
        complain(f"{file}: not found; expected the archive's table of frame cuts")
        return {}
    cuts = {}
    with open(file, newline="", encoding="utf-8-sig") as table:
        for row in csv.DictReader(table, skipinitialspace=True):
            style = (row.get("STYLE_NAME") or "").strip()
            for take in TAKES:
                first, last = ((row.get(f"{take}_{end}") or "").strip() for end in ("START", "STOP"))
                if style and first.isdigit() and last.isdigit():
                    cuts.setdefault(style, {})[take] = (int(first), int(last))
                elif style:
                    complain(f"{file}: {style}: {take}: found '{first}' to '{last}', expected two frames; skipped")
    return cuts


def part_of(folder, style, take, cut, complain):
    """(path, share of the first frame, share of the last), or None."""
    path = find(folder, f"{style}_{take}")
    if path is None:
        complain(f"{style}_{take}.bvh: not found; skipped")
        return None
    frames = frames_of(path)
    first, last = cut
    if not 0 <= first < last <= frames:
        complain(f"{path}: has {frames} frames, Frame_Cuts.csv says {first} to {last}; skipped")
        return None
    return path.relative_to(folder), first / frames, last / frames


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: 100style.py DIR")
    folder = pathlib.Path(sys.argv[1])

    def complain(text):
        print(f"100style: {text}", file=sys.stderr)

    clips = []
    for style, takes in cuts_of(folder, complain).items():
        for take, cut in takes.items():
            part = part_of(folder, style, take, cut, complain)
            if part:
                clips.append((style, TAKES[take], *part))
    styles = sorted({clip[0] for clip in clips}, key=lambda style: (style != NEUTRAL, style))
    if not styles or styles[0] != NEUTRAL:
        complain(f"{folder}: found no take of {NEUTRAL}; expected the unpacked archive")
        sys.exit(1)
    complain(f"{len(clips)} takes of {len(styles)} styles")
    print('name = "100style"')
    print('licence = "CC BY 4.0; The 100STYLE Dataset - Ian Mason; cut in time, resampled, retargeted"')
    print(f'neutral = "{NEUTRAL.lower()}"')
    print("styles = [")
    for style in styles:
        print(f'  {{ name = "{style.lower()}", labels = ["{style}"], licence = "CC BY 4.0",'
              ' credit = "The 100STYLE Dataset - Ian Mason" },')
    print("]")
    print("contents = [" + ", ".join(f'{{ name = "{content}" }}' for content in TAKES.values()) + "]")
    for style, content, path, first, last in clips:
        print(f'[[clips]]\npattern = "{path}"\nstyle = "{style.lower()}"\ncontent = "{content}"\nrig = "auto"\n'
              f'split = "train"\ntime = [{first:.6f}, {last:.6f}]')


main()
