"""model/PAPERS.md names where each element of the two papers is: the places and the commands exist.

python3 tests/documents/test_papers.py --write    sets the line numbers
"""
import pathlib
import re
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
TABLE = ROOT / 'model' / 'PAPERS.md'
# `FILE:12` `Symbol`: the line of the file has the symbol.
PLACE = re.compile(r'`([\w./-]+\.(?:cpp|h|py|sh|md|toml)):(\d+)` `([^`]+)`')
COMMAND = re.compile(r'`((?:styletrain|styleeval|stylebaseline|styleacts|styleunseen|ctest|tests/|model/)[^`:]*)`')
FLAG = re.compile(r'(?<![\w-])(--[a-z][a-z0-9-]*)')


def line_of(path, symbol):
    """The first line of a file that has the symbol as a whole word, from 1; None if none has."""
    word = re.compile(r'(?<!\w)' + re.escape(symbol) + r'(?!\w)')
    for number, line in enumerate((ROOT / path).read_text(encoding='utf-8').splitlines(), 1):
        if word.search(line):
            return number
    return None


def wrong_places(text):
    """Sentences on places that are not there."""
    wrong = []
    for path, number, symbol in PLACE.findall(text):
        if not (ROOT / path).is_file():
            wrong.append(f'{path}: no such file')
            continue
        lines = (ROOT / path).read_text(encoding='utf-8').splitlines()
        if not 1 <= int(number) <= len(lines) or symbol not in lines[int(number) - 1]:
            wrong.append(f'{path}:{number}: found no "{symbol}", expected it (--write sets the numbers)')
    return wrong


def sources(*folders):
    """The text of all sources in the folders."""
    return '\n'.join(file.read_text(encoding='utf-8') for folder in folders
                     for file in sorted((ROOT / folder).rglob('*')) if file.suffix in ('.cpp', '.h', '.py', '.sh', '.txt'))


def wrong_commands(text):
    """Sentences on commands whose program, script, test or flag is not there."""
    wrong = []
    programs = {file.stem for file in (ROOT / 'model' / 'tools').glob('style*.cpp')}
    flags = set(FLAG.findall(sources('model/tools', 'model/train')))
    # "TEST(Suite, Name)" as ctest calls it
    tests = sources('tests/unit', 'tests/parity').replace(', ', '.')
    for command in COMMAND.findall(text):
        words = command.split()
        if words[0] == 'ctest':
            for name in words[words.index('-R') + 1].strip("'").split('|'):
                if name.strip('.*^$') not in tests:
                    wrong.append(f'{command}: no test is called {name}')
        elif '/' in words[0]:
            if not (ROOT / words[0]).exists():
                wrong.append(f'{command}: no such file')
        else:
            if words[0] not in programs:
                wrong.append(f'{command}: no program is called {words[0]}')
            wrong += [f'{command}: no flag {flag}' for flag in FLAG.findall(command) if flag not in flags]
    return wrong


class Papers(unittest.TestCase):
    def test_places_are_there(self):
        text = TABLE.read_text(encoding='utf-8')
        self.assertGreater(len(PLACE.findall(text)), 50)
        self.assertEqual(wrong_places(text), [])

    def test_commands_are_there(self):
        text = TABLE.read_text(encoding='utf-8')
        self.assertGreater(len(COMMAND.findall(text)), 20)
        self.assertEqual(wrong_commands(text), [])

    def test_what_is_not_there_is_found(self):
        self.assertTrue(wrong_places('`model/none.cpp:1` `X`'))
        self.assertTrue(wrong_places('`model/PAPERS.md:1` `NoSuchSymbolAnywhere`'))
        self.assertTrue(wrong_commands('`styletrain --no-such-flag`'))
        self.assertTrue(wrong_commands('`ctest -R NoSuchTest`'))
        self.assertTrue(wrong_commands('`model/train/recipes/none.sh RUNS`'))


def write():
    def number(match):
        path, _, symbol = match.groups()
        line = line_of(path, symbol) if (ROOT / path).is_file() else None
        if line is None:
            print(f'{path}: no {symbol}', file=sys.stderr)
            return match.group(0)
        return f'`{path}:{line}` `{symbol}`'

    TABLE.write_text(PLACE.sub(number, TABLE.read_text(encoding='utf-8')), encoding='utf-8')


if __name__ == '__main__':
    if sys.argv[1:] == ['--write']:
        write()
    else:
        unittest.main()
