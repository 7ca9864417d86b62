"""Every statement of daemon/security/README.md has a test that exists."""
import glob
import os
import re
import unittest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', '..')
PAGE = os.path.join(ROOT, 'daemon', 'security', 'README.md')
NAME = re.compile(r'`([\w/]+\.(?:cpp|py|mjs)):(\w+)`')
MACROS = r'TEST(?:_F|_P)?\(\s*\w+,\s*{}\s*\)|def {}\('


def missing(file, test):
    """The error in FILE:TEST; '' where it exists."""
    paths = [path for path in glob.glob(os.path.join(ROOT, 'tests', '**', '*'), recursive=True)
             if path.endswith('/' + file)]
    if len(paths) != 1:
        return f'{file}: {len(paths)} files of that name in tests/, expected one'
    with open(paths[0], encoding='utf-8') as text:
        if not re.search(MACROS.format(test, test), text.read()):
            return f'{file} has no test {test}'
    return ''


def rows(page):
    """(line number, last cell) of every row of a table whose last column is `test`."""
    inside = False
    for number, line in enumerate(page.splitlines(), 1):
        if not line.startswith('|'):
            inside = False
            continue
        cells = [cell.strip() for cell in line.strip().strip('|').split('|')]
        if cells[-1] == 'test':
            inside = True
        elif not set(line) <= set('|-'):
            yield number, cells[-1] if inside else None


class ThreatModelTest(unittest.TestCase):
    def setUp(self):
        with open(PAGE, encoding='utf-8') as text:
            self.page = text.read()

    def test_every_test_that_is_named_exists(self):
        named = NAME.findall(self.page)
        self.assertGreater(len(named), 50)
        self.assertEqual([], [wrong for wrong in (missing(*name) for name in named) if wrong])

    def test_every_row_names_a_test_or_says_that_there_is_none(self):
        found = list(rows(self.page))
        self.assertGreater(len(found), 40)
        for number, cell in found:
            with self.subTest(line=number):
                self.assertIsNotNone(cell, 'a table without a column of tests')
                self.assertTrue(cell == '—' or NAME.search(cell), cell)

    def test_what_does_not_exist_is_found(self):
        self.assertIn('has no test', missing('security_test.cpp', 'WhoHasAKey'))
        self.assertIn('0 files', missing('nowhere_test.cpp', 'Anything'))
        self.assertIn('2 files', missing('access_test.cpp', 'Anything'))


if __name__ == '__main__':
    unittest.main()
