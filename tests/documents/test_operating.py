"""daemon/OPERATING.md explains every counter, flag and error code that exists, and no other."""
import os
import re
import unittest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..')
COUNTER = re.compile(r'\{Counter::k\w+, "([\w.]+)"(, true)?\}')
ROW = re.compile(r'^\| `([\w.]+)` \|(.*)\|$', re.MULTILINE)


def read(*path):
    with open(os.path.join(ROOT, *path), encoding='utf-8') as text:
        return text.read()


def section(page, title):
    """The text below the heading `## title`, up to the next one of its level."""
    return re.search(rf'^## {title}\n(.*?)(?=^## |\Z)', page, re.MULTILINE | re.DOTALL).group(1)


def rows(text):
    """{name: [cells after it]} of all tables in the text."""
    found = {}
    for name, cells in ROW.findall(text):
        if name in found:
            raise ValueError(f'{name} has two rows')
        found[name] = [cell.strip() for cell in cells.split('|')]
    return found


def counters(source):
    """{name: whether the log has a line when it grows}, as counters.cpp has them."""
    return {name: bool(trouble) for name, trouble in COUNTER.findall(source)}


def members(proto, name):
    """{member: number} of an enumeration of a .proto file."""
    body = re.search(rf'enum {name} \{{(.*?)\n\}}', proto, re.DOTALL).group(1)
    return {member: int(number) for member, number in re.findall(r'^  (\w+) = (\d+);', body, re.MULTILINE)}


def differences(code, page):
    """The differences, one sentence each; [] where both have the same names."""
    return ([f'{name} has no row' for name in sorted(set(code) - set(page))] +
            [f'{name} has a row and does not exist' for name in sorted(set(page) - set(code))])


class OperatingTest(unittest.TestCase):
    def setUp(self):
        self.page = read('daemon', 'OPERATING.md')
        self.counters = counters(read('daemon', 'runtime', 'counters.cpp'))
        self.rows = rows(section(self.page, 'Counters'))

    def test_every_counter_has_a_row_and_every_row_a_counter(self):
        self.assertGreater(len(self.counters), 80)
        self.assertEqual([], differences(self.counters, self.rows))

    def test_a_row_says_whether_it_is_bad_whether_it_is_logged_and_what_to_do(self):
        for name, cells in self.rows.items():
            with self.subTest(counter=name):
                meaning, bad, logged, action = cells
                self.assertTrue(meaning)
                self.assertIn(bad, ('no', 'some', 'yes'))
                self.assertTrue(action or bad == 'no', 'bad, and nothing to do about it')
                self.assertEqual('yes' if self.counters[name] else 'no', logged)

    def test_every_flag_has_a_row_with_its_value(self):
        flags = members(read('proto', 'styled', 'v1', 'frame.proto'), 'Flag')
        found = rows(section(self.page, 'Flags of a frame'))
        self.assertEqual([], differences(flags, found))
        self.assertEqual(flags, {name: int(cells[0]) for name, cells in found.items()})

    def test_every_error_code_has_a_row(self):
        codes = members(read('proto', 'styled', 'v1', 'control.proto'), 'Code')
        found = rows(section(self.page, 'Error codes of the control socket'))
        self.assertEqual([], differences(codes, found))

    def test_a_reason_of_status_is_a_counter(self):
        found = rows(section(self.page, 'What `stylectl status` shows'))
        reasons = [name for name in found if '.' in name]
        self.assertGreater(len(reasons), 5)
        self.assertEqual([], [name for name in reasons if name not in self.counters])

    def test_a_missing_row_and_an_invented_one_are_found(self):
        name, cells = next(iter(self.rows.items()))
        without = {other: row for other, row in self.rows.items() if other != name}
        self.assertEqual([f'{name} has no row'], differences(self.counters, without))
        more = dict(self.rows, **{'pipeline.invented': cells})
        self.assertEqual(['pipeline.invented has a row and does not exist'],
                         differences(self.counters, more))
        with self.assertRaises(ValueError):
            rows('| `a.b` | x |\n| `a.b` | y |\n')


if __name__ == '__main__':
    unittest.main()
