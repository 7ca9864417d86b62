#!/usr/bin/env python3
"""The functions that libstyled exports: `test_symbols.py LIBRARY FOLDER`. Those of the header, no other, and
none of an earlier version is gone.
"""
import re
import subprocess
import sys

# Of versions 0.1.0 and 0.2.0. A program that uses them must still run: functions are only added.
PROMISED = """styled_adopt styled_calibrate styled_clip_body styled_clip_frames styled_clip_length styled_copy_clip styled_create
styled_destroy styled_find_style styled_frame styled_free_clip styled_learn styled_like styled_load styled_make_clip
styled_read_clip styled_release styled_reset styled_restore styled_restyle styled_save styled_set styled_style_count
styled_style_credit styled_style_licence styled_style_name styled_version styled_write_clip""".split()


def main():
    library, folder = sys.argv[1:]
    with open(folder + '/styled.h') as file:
        declared = set(re.findall(r'^STYLED_API [^(]*?\b(styled_\w+)\(', file.read(), re.M))
    listing = subprocess.run(['nm', '-D', '--defined-only', library], capture_output=True, text=True, check=True).stdout
    exported = {line.split()[-1].split('@')[0] for line in listing.splitlines() if ' A ' not in line}
    wrong = [f'{name}: is in the header, but not exported' for name in sorted(declared - exported)]
    wrong += [f'{name}: is exported, but not in the header' for name in sorted(exported - declared)]
    wrong += [f'{name}: has vanished, though programs use it' for name in PROMISED if name not in exported]
    print('\n'.join(wrong) or f'{len(exported)} functions exported, as declared')
    return 1 if wrong else 0


if __name__ == '__main__':
    sys.exit(main())
