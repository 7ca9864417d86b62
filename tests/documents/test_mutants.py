"""The breaks of tests/mutants.txt still apply: tests/mutants.sh tries them, which takes many minutes."""
import os
import unittest

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..'))
TABLE = os.path.join(ROOT, 'tests', 'mutants.txt')


def read(text):
    """Blocks of five lines: name, file, old text, new text, test binary and filter."""
    lines = [line for line in text.splitlines() if line and not line.startswith('#')]
    for at in range(0, len(lines), 5):
        name, file, old, new, test = lines[at:at + 5]
        assert old[:4] in ('  - ', '  = ') and new.startswith('  + '), f'{name}: expected "- " or "= ", then "+ "'
        yield name, file.strip(), old[4:], new[4:], test.strip()


class Mutants(unittest.TestCase):
    def setUp(self):
        with open(TABLE, encoding='utf-8') as text:
            self.table = list(read(text.read()))

    def test_each_text_is_in_its_file_once_and_is_changed(self):
        for name, file, old, new, _ in self.table:
            with self.subTest(name), open(os.path.join(ROOT, file), encoding='utf-8') as source:
                self.assertEqual(source.read().count(old), 1, f'mutant {name} no longer applies to {file}')
                self.assertNotEqual(old, new)

    def test_each_test_binary_is_built(self):
        lists = ''
        for folder, _, files in os.walk(os.path.join(ROOT, 'tests')):
            if 'CMakeLists.txt' in files:
                with open(os.path.join(folder, 'CMakeLists.txt'), encoding='utf-8') as text:
                    lists += text.read()
        for name, _, _, _, test in self.table:
            with self.subTest(name):
                self.assertRegex(lists, rf'styled_test\(\s*{test.split()[0]}\b')
                self.assertEqual(len(test.split()), 2)

    def test_names_differ(self):
        names = [name for name, *_ in self.table]
        self.assertEqual(len(names), len(set(names)))

    def test_a_table_that_went_out_of_date_is_noticed(self):
        (block,) = read('name\n  file\n  - a + b\n  + a\n  binary Filter*\n')
        self.assertEqual(block, ('name', 'file', 'a + b', 'a', 'binary Filter*'))


if __name__ == '__main__':
    unittest.main()
