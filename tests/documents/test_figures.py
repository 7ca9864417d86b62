"""README.md gives no figure that tests/bench/FIGURES.md does not have, measured with the weights that ship."""
import json
import os
import re
import subprocess
import sys
import unittest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..')
sys.path.insert(0, os.path.join(ROOT, 'tests', 'bench'))
import against  # noqa: E402
from figures import FIGURES, WEIGHTS, fnv1a64, rows_of  # noqa: E402

# Numbers of README.md that are not measured, each with its reason. Any other number is a figure.
NOT_MEASURED = {
    'Debian 12 or 13 or Ubuntu 24.04': 'names', 'Debian 12': 'a name', 'CVPR 2022': 'a year',
}
NUMBER = re.compile(r'(?<![\w.-])\d[\d.,]*\d?(?: (?:ms|s|Hz|%|cm/s|GB|MB|times|minutes))?(?![\w-])')


def read(*path):
    with open(os.path.join(ROOT, *path), encoding='utf-8') as text:
        return text.read()


def prose(page):
    """A page without code, links' targets, tables and the sentences of figures."""
    page = re.sub(r'<!--(\w+)-->.*?<!--/-->', '', page, flags=re.DOTALL)
    page = re.sub(r'^```.*?^```', '', page, flags=re.MULTILINE | re.DOTALL)
    page = re.sub(r'^\|.*$', '', page, flags=re.MULTILINE)
    page = re.sub(r'`[^`]*`', '', page)
    return re.sub(r'\]\([^)]*\)', ']', page)


def unexplained(page):
    """Numbers in a page's prose that no figure has and NOT_MEASURED does not name."""
    text = ' '.join(prose(page).split())
    for known in sorted(NOT_MEASURED, key=len, reverse=True):
        text = text.replace(known, '')
    return NUMBER.findall(text)


def sentences(page):
    """{name: sentence} between the comments of a page."""
    return {name: ' '.join(text.split())
            for name, text in re.findall(r'<!--(\w+)-->(.*?)<!--/-->', page, re.DOTALL)}


class FiguresTest(unittest.TestCase):
    def setUp(self):
        self.readme = read('README.md')
        self.rows = rows_of(read('tests', 'bench', 'FIGURES.md'))

    def test_readme_says_what_was_measured_and_nothing_else(self):
        self.assertEqual(set(FIGURES), set(self.rows))
        self.assertEqual({name: cells[0] for name, cells in self.rows.items()}, sentences(self.readme))
        self.assertEqual([], unexplained(self.readme))
        text = ' '.join(prose(self.readme).split())
        self.assertEqual([], [known for known in NOT_MEASURED if known not in text])

    def test_every_figure_has_its_command_weights_and_commit(self):
        for name, (_, command, weights, commit, machine, day) in self.rows.items():
            with self.subTest(figure=name):
                self.assertRegex(command, r'^`(env \S+ )?build/release/bin/\w+')
                self.assertIn(weights, ('-', fnv1a64(WEIGHTS)), 'the weights that ship have changed: measure again')
                self.assertTrue(machine)
                self.assertRegex(day, r'^\d{4}-\d\d-\d\d$')
                known = subprocess.run(['git', 'cat-file', '-e', commit], cwd=ROOT, capture_output=True, check=False)
                shallow = subprocess.run(['git', 'rev-parse', '--is-shallow-repository'], cwd=ROOT,
                                         capture_output=True, text=True, check=False).stdout.strip()
                self.assertTrue(known.returncode == 0 or shallow != 'false', f'no commit {commit}')

    def test_the_page_of_speed_says_what_was_measured(self):
        history = json.loads(read('tests', 'bench', 'history.json'))
        self.assertEqual(against.page_of(history), read('tests', 'bench', 'SPEED.md'))
        for entry in history:
            for row in entry['rows']:
                self.assertLessEqual(row['low'], row['ratio'], row['name'])
                self.assertLessEqual(row['ratio'], row['high'], row['name'])

    def test_a_ratio_has_the_interval_of_its_rounds(self):
        self.assertEqual((0.5, 0.5, 0.5), against.interval([0.5] * 5))
        ratio, low, high = against.interval([0.9, 1.0, 1.1, 1.0, 3.0])
        self.assertEqual(1.0, ratio)
        self.assertLess(low, 1.0)
        self.assertGreater(high, 1.0)
        rows = [{'name': 'step', 'ratio': 0.5}]
        history = [{'machine': 'm', 'against': 'a', 'commit': 'b', 'rows': rows},
                   {'machine': 'm', 'against': 'b', 'commit': 'c', 'rows': rows}]
        self.assertEqual({('m', 'step'): [('a', 1.0), ('b', 0.5), ('c', 0.25)]}, against.chains(history))

    def test_a_figure_that_is_made_up_is_found(self):
        self.assertEqual(['3.5 cm/s'], unexplained('Feet slide 3.5 cm/s.\n'))
        self.assertEqual([], unexplained('<!--wire-->none of 5,000<!--/--> `--rate 60` [x](y/5.md)\n| 7 |\n'))
        self.assertEqual(['99 %'], unexplained('It is 99 % sure, on Debian 12.'))


if __name__ == '__main__':
    unittest.main()
