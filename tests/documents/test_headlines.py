"""Every table of figures of weights names the file that it was measured of, by its SHA-256, and the commit of the programs."""
import hashlib
import os
import re
import subprocess
import unittest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..')
WEIGHTS = os.path.join(ROOT, 'model', 'weights')
PAGES = ('README.md', 'RESULTS.md')  # of model/weights
# Sections whose tables are no figures of shipped weights, each with its reason.
OTHER = {
    'Model card: the shipped weights': 'which files there are', 'Model': 'what v2 is', 'Training': 'what was written by what',
    'The trial run': 'bounds', 'The judges': 'judges, not weights',
    'Table 1: what each part of the training is worth': 'networks that are not shipped',
    'Park\'s network at the paper\'s width': 'a network that is not shipped, beside st-gcn',
    'The paper\'s losses at v2\'s budget': 'networks that are not shipped, beside v2',
    'A style added to frozen weights (the paper\'s future work, C.1)': 'networks that are not shipped',
    'Table 2: runtime': 'times', 'The whole stylist': 'times', 'Runtime': 'times',
    'Table 1 of the paper: what the losses are worth': 'networks that are not shipped',
}
OF = re.compile(r'`?([\w-]+\.safetensors)`?,? (?:of )?SHA-256 `?([0-9a-f]+)`?')
COMMIT = re.compile(r'commit `?([0-9a-f]{8,40})`?')
ROW = re.compile(r'^\|', re.MULTILINE)


def read(*path):
    with open(os.path.join(WEIGHTS, *path), encoding='utf-8') as text:
        return text.read()


def sections(page):
    """[(heading, text)] of a page, code left out."""
    page = re.sub(r'^```.*?^```', '', page, flags=re.MULTILINE | re.DOTALL)
    parts = re.split(r'^#+ (.*)$', page, flags=re.MULTILINE)
    return list(zip(parts[1::2], parts[2::2]))


def shipped():
    """{name: the first 16 digits of its SHA-256} of the files of weights in the tree."""
    found = {}
    for name in sorted(os.listdir(WEIGHTS)):
        if name.endswith('.safetensors'):
            with open(os.path.join(WEIGHTS, name), 'rb') as file:
                found[name] = hashlib.sha256(file.read()).hexdigest()[:16]
    return found


def wrong(page, files):
    """What is wrong with a page: a sentence for each section."""
    found = []
    for heading, text in sections(page):
        said = ' '.join(text.split())
        for name, digits in OF.findall(said):
            if files.get(name) != digits:
                found.append(f"{heading}: {name} has SHA-256 {files.get(name, 'no such file')}, the page says {digits}")
        if heading in OTHER or not ROW.search(text):
            continue
        if not OF.search(said):
            found.append(f'{heading}: a table, and no "NAME.safetensors, SHA-256 ..." (16 digits)')
        if not COMMIT.search(said):
            found.append(f'{heading}: a table, and no "commit ..."')
    return found


class HeadlinesTest(unittest.TestCase):
    def test_every_table_is_of_a_file_that_ships(self):
        files = shipped()
        self.assertGreater(len(files), 3)
        for page in PAGES:
            with self.subTest(page=page):
                self.assertEqual([], wrong(read(page), files))

    def test_every_commit_is_known(self):
        shallow = subprocess.run(['git', 'rev-parse', '--is-shallow-repository'], cwd=ROOT, capture_output=True,
                                 text=True, check=False).stdout.strip()
        for page in PAGES:
            for commit in COMMIT.findall(read(page)):
                known = subprocess.run(['git', 'cat-file', '-e', commit], cwd=ROOT, capture_output=True, check=False)
                self.assertTrue(known.returncode == 0 or shallow != 'false', f'{page}: no commit {commit}')

    def test_every_exempt_section_is_there(self):
        headings = {heading for page in PAGES for heading, _ in sections(read(page))}
        self.assertEqual(set(), set(OTHER) - headings)

    def test_the_ledger_names_weights_and_judges(self):
        lines = [line.split('\t') for line in read('TESTED.tsv').splitlines()]
        self.assertEqual(['manifest', 'weights_sha256', 'files', 'judges_sha256', 'commit', 'day', 'figures'], lines[0])
        for line in lines[1:]:
            with self.subTest(line=line):
                self.assertEqual(7, len(line))
                self.assertRegex(line[1], r'^[0-9a-f]{64}(\+[0-9a-f]{64})*$')
                self.assertRegex(line[3], r'^[0-9a-f]{64}$')

    def test_another_file_and_a_bare_table_are_found(self):
        files = {'v2.safetensors': '0123456789abcdef'}
        good = '## A\nOf `v2.safetensors`, SHA-256 0123456789abcdef, commit 12345678:\n\n| a |\n|---|\n| 1 |\n'
        self.assertEqual([], wrong(good, files))
        self.assertEqual([], wrong('## A\nNo table, 0.9.\n', files))
        self.assertEqual([], wrong('## Model\n| a |\n', files))
        self.assertEqual(['A: v2.safetensors has SHA-256 0123456789abcdef, the page says fedcba9876543210'],
                         wrong(good.replace('0123456789abcdef', 'fedcba9876543210'), files))
        self.assertEqual(['A: v1.safetensors has SHA-256 no such file, the page says 0123456789abcdef'],
                         wrong(good.replace('v2', 'v1'), files))
        self.assertEqual(2, len(wrong('## A\n| a |\n|---|\n| 1 |\n', files)))


if __name__ == '__main__':
    unittest.main()
