"""Every Python source parses, and the client's package has every message that its messages import: both are seen only
when the client is used, and a text with an apostrophe has broken it before."""

import ast
import os
import re
import subprocess
import unittest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..')


def read(*path):
    with open(os.path.join(ROOT, *path), encoding='utf-8') as text:
        return text.read()


def broken(name, text):
    try:
        ast.parse(text, name)
    except SyntaxError as error:
        return f'{name}:{error.lineno}: {error.msg}'
    return None


def missing(listed, imports):
    """The messages that a listed one imports and that are not listed."""
    return sorted({name for of in listed for name in imports(of)} - set(listed))


def imports_of(message):
    return re.findall(r'^import "proto/styled/v1/(\w+)\.proto";', read('proto', 'styled', 'v1', message + '.proto'), re.MULTILINE)


class Python(unittest.TestCase):

    def test_every_source_parses(self):
        files = subprocess.run(['git', '-C', ROOT, 'ls-files', '*.py'], capture_output=True, text=True, check=True).stdout.split()
        self.assertGreater(len(files), 50)
        self.assertEqual([], [why for why in (broken(file, read(file)) for file in files) if why])

    def test_every_message_that_is_imported_is_in_the_package(self):
        listed = re.search(r'^set\(messages ([\w ]+)\)', read('clients', 'python', 'CMakeLists.txt'), re.MULTILINE).group(1).split()
        self.assertIn('control', listed)
        self.assertEqual([], missing(listed, imports_of))

    def test_both_are_found(self):
        self.assertRegex(broken('a.py', "text = 'the performer's own'\n"), '^a.py:1: ')
        self.assertIsNone(broken('a.py', 'text = "the performer\'s own"\n'))
        self.assertEqual(['fate'], missing(['control', 'look'], {'control': ['fate', 'look'], 'look': []}.get))


if __name__ == '__main__':
    unittest.main()
