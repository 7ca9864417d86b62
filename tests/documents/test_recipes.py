"""The recipes of model/train/recipes are commands that styletrain and styleeval could be given."""
import glob
import json
import os
import re
import shlex
import subprocess
import tempfile
import unittest

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..'))
RECIPES = os.path.join(ROOT, 'model', 'train', 'recipes')
WEIGHTS = os.path.join(ROOT, 'model', 'weights', 'v2.safetensors')


def run(recipe, *arguments, **environment):
    clean = {name: value for name, value in os.environ.items() if not name.startswith('STYLED_')}
    return subprocess.run([os.path.join(RECIPES, recipe), *arguments], capture_output=True, text=True, check=False,
                          env=dict(clean, **environment))


def known_options():
    found = {'--name', '--replace'}
    for pattern in ('model/tools/**/*.cpp', 'model/train/**/*.cpp', 'model/tools/**/*.h'):
        for file in glob.glob(os.path.join(ROOT, pattern), recursive=True):
            with open(file, encoding='utf-8') as text:
                found.update(re.findall(r'(--[a-z][\w-]*)', text.read()))
    return found


def wrong(commands, known):
    """The errors in lines of commands: options that no program has, files that are not in the tree."""
    found = []
    for line in commands:
        words = shlex.split(line)
        found += [word for word in words if word.startswith('--') and word not in known]
        found += [word for word in words if word.startswith(ROOT) and not os.path.exists(word.split(':')[0])]
    return found


class RecipesTest(unittest.TestCase):
    def setUp(self):
        self.recipes = sorted(set(map(os.path.basename, glob.glob(os.path.join(RECIPES, '*.sh')))) - {'recipe.sh', 'get_data.sh'})

    def commands(self, recipe):
        with open(os.path.join(RECIPES, recipe), encoding='utf-8') as text:
            needs = re.search("recipe_needs='(.*) '", text.read())
        named = [{'WEIGHTS': WEIGHTS, 'DIR': ROOT}[needs[1]]] if needs else []
        arguments = ['--dry-run'] + named + ['RUNS']
        done = run(recipe, *arguments)
        self.assertEqual((0, ''), (done.returncode, done.stderr))
        return [line for line in done.stdout.splitlines() if line.startswith('style')]

    def test_each_prints_commands_with_options_and_files_that_exist(self):
        self.assertGreater(len(self.recipes), 3)
        known = known_options()
        for recipe in self.recipes:
            with self.subTest(recipe=recipe):
                commands = self.commands(recipe)
                self.assertGreater(len(commands), 0)
                self.assertEqual([], wrong(commands, known))

    def test_arguments_are_checked(self):
        for arguments, environment, said in (
                ([], {}, 'expected 1 arguments, found 0'),
                (['--fast', 'RUNS'], {}, "unknown option '--fast'"),
                (['RUNS'], {}, 'STYLED_DATA is not set'),
                (['RUNS'], {'STYLED_DATA': ROOT}, 'has no folder bandai-1')):
            with self.subTest(said=said):
                done = run('st_gcn.sh', *arguments, **environment)
                self.assertEqual(2, done.returncode)
                self.assertIn(said, done.stderr)

    def test_seeds_and_minutes_of_a_table_are_numbers(self):
        for variable, value in (('STYLED_SEEDS', 'a'), ('STYLED_SEEDS', '1 -2'), ('STYLED_MINUTES', 'x')):
            with self.subTest(variable=variable, value=value):
                done = run('st_gcn_table_2.sh', '--dry-run', WEIGHTS, 'RUNS', **{variable: value})
                self.assertEqual((2, ''), (done.returncode, done.stdout))
                self.assertIn(f'{variable}: found ', done.stderr)

    def test_what_does_not_exist_is_found(self):
        lost = os.path.join(ROOT, 'model', 'weights', 'manifests', 'lost.toml')
        self.assertEqual(['--quickly', lost], wrong([f'styletrain --quickly --manifest {lost}'], known_options()))

    def test_the_rows_of_st_gcns_first_table_differ_by_one_loss_each(self):
        commands = self.commands('st_gcn_table_1.sh')
        trainings = [shlex.split(line) for line in commands if line.startswith('styletrain')]
        self.assertEqual(9, len(trainings))  # three rows, three seeds
        rows = []
        for row in ('adversarial', 'style', 'diversity'):
            seeds = [words for words in trainings if f'RUNS/{row}-' in ' '.join(words)]
            self.assertEqual(['1', '2', '3'], [words[words.index('--seed') + 1] for words in seeds])
            rows.append([word for word in seeds[0] if f'RUNS/{row}-' not in word])
        self.assertEqual([{'--w-style'}, {'--w-diversity'}],
                         [set(more) - set(less) - {'0'} for more, less in zip(rows, rows[1:])])
        targets = [row[row.index('--diversity-target') + 1] for row in rows]
        self.assertEqual(['0', '0'], targets[:2])
        self.assertGreater(float(targets[2]), 0)


def judged(fmd=10.0, accuracy=0.9, sha256='a', split='validation', actions='c'):
    """The output of styleeval --json, as far as a table reads it; the second style has no measurements."""
    names = ('fmd', 'fmd_real_real', 'fmd_neutral_target', 'jitter_120')
    figures = {'styles': {
        'odd': {**{name: fmd for name in names}, **{'content_' + name: fmd / 2 for name in names}},
        'rare': {**{name: None for name in names}, **{'content_' + name: None for name in names}}}}
    figures['mean'] = {'fmd': fmd, 'fmd_spread': 3.0, 'content_fmd': fmd / 2, 'content_fmd_spread': None}
    judges = [{'key': key, 'value': accuracy, 'spread': 0.04} for key in ('style', 'content', 'movement', 'legs_pose')]
    judges.append({'key': 'legs_movement', 'value': None, 'spread': None})
    return {'styled': figures, 'noise': figures,
            'judges': [{'key': key, 'judges': judges} for key in ('styled', 'noise', 'real')],
            'actions': {'sha256': actions, 'sets': {'noise': {'fmd': fmd / 4, 'fmd_spread': 0.5, 'accuracy': 0.8,
                                                              'accuracy_spread': None}}},
            'codes': {'noise': {'distance_cm': 2.5}, 'examples': {'distance_cm': None}, 'real_cm': 3.0},
            'provenance': {'manifest': 'm', 'split': split, 'judges': {'sha256': sha256}, 'data': {}, 'inputs': 2}}


class TableTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def file(self, name, figures):
        path = os.path.join(self.folder, name)
        with open(path, 'w', encoding='utf-8') as file:
            json.dump(figures, file)
        return path

    def test_a_row_is_the_mean_of_its_runs_and_their_deviation(self):
        first, second = self.file('a', judged(10, 0.5)), self.file('b', judged(12, 0.7))
        done = run('table.py', f'by noise=noise@{first},{second}', f'examples=styled@{first}', f'real=real@{first}')
        self.assertEqual((0, ''), (done.returncode, done.stderr))
        lines = done.stdout.splitlines()
        noise, examples, real = [line.strip('| ').split(' | ') for line in lines[2:5]]
        self.assertEqual(['by noise', '2.75 ± 0.35', '0.80 ± 0.00', '5.50 ± 0.71', '0.60 ± 0.14', '11.00 ± 1.41', '0.60 ± 0.14', '0.60 ± 0.14',
                          '0.60 ± 0.14', '-', '11.00 ± 1.41', '2.50 ± 0.00'], noise)
        half = '0.50 ± 0.04'  # over judges
        self.assertEqual(['examples', '-', '-', '5.00', half, '10.00 ± 3.00', half, half, half, '-', '10.00', '-'], examples)
        self.assertEqual(['real', '-', '-', '5.00', half, '10.00', half, half, half, '-', '-', '3.00'], real)
        self.assertEqual(['', 'Judges of SHA-256 a, m, split validation, action classifiers of SHA-256 c'], lines[5:])

    def test_what_is_not_comparable_is_refused(self):
        first, other = self.file('a', judged()), self.file('b', judged(sha256='b'))
        test = self.file('f', judged(split='test'))
        graphs, none = self.file('g', judged(actions='d')), self.file('h', {**judged(), 'actions': {'sha256': None, 'sets': {}}})
        empty, bare = self.file('c', {}), self.file('d', {**judged(), 'noise': {}})
        listed = self.file('e', [])
        for arguments, said in (([f'x=noise@{first}', f'y=noise@{other}'], f'{other}: judges: not as in {first}'),
                                ([f'x=noise@{first},{test}'], f'{test}: split: not as in {first}'),
                                ([f'x=noise@{none}', f'y=noise@{first}', f'z=noise@{graphs}'],
                                 f'{graphs}: action classifiers: not as in {none}'),
                                ([f'x=noise@{first},{graphs}'], f'{graphs}: action classifiers: not as in {first}'),
                                ([f'x=noise@{empty}'], f"{empty}: has no key 'judges'"),
                                ([f'x=noise@{bare}'], f"{bare}: has no key 'styles'"),
                                ([f'x=noise@{listed}'], f'{listed}: expected what styleeval'),
                                ([f'x=mean@{first}'], f"{first}: has no set of clips 'mean'"),
                                (['x'], "'x': expected TITLE=KEY@FILE"), (['x=noise@lost'], 'lost')):
            with self.subTest(said=said):
                done = run('table.py', *arguments)
                self.assertEqual((1, ''), (done.returncode, done.stdout))
                self.assertIn(said, done.stderr)


def report():
    """The output of styleeval --json, as far as card.py reads it."""
    keys = ('style', 'content', 'movement', 'legs_pose', 'legs_movement', 'arms_pose', 'arms_movement', 'trunk_pose',
            'trunk_movement')
    judges = [{'key': key, 'value': 0.5, 'spread': 0.25, 'low': 0.4, 'high': 0.6, 'windows': 1200, 'styles': {'odd': 0.5},
               'styles_spread': {'odd': None}} for key in keys]
    share = {'value': 0.5, 'spread': 0.25, 'low': 0.4, 'high': 0.6, 'windows': 1200}
    names = ('expression', 'expression_cosine', 'expression_of_training_clips', 'expression_cosine_of_training_clips', 'fmd',
             'fmd_real_real', 'fmd_neutral_target', 'content_fmd', 'content_fmd_real_real', 'content_fmd_neutral_target',
             'jitter_120', 'jitter_120_of_real', 'skate_in_cm_s', 'skate_out_cm_s')
    figures = {'styles': {'odd': {'sra': share, 'cra': share, 'fmd_spread': 0.5, **dict.fromkeys(names, 2.0)}}}
    return {'styled': figures, 'baseline': figures,
            'judges': [{'key': key, 'title': title, 'judges': judges} for key, title in (
                ('real', 'real clips'), ('offset', 'constant offset'), ('styled', 'v9'))],
            'provenance': {'manifest': 'm', 'split': 'test', 'inputs': 2, 'judges': {'sha256': 'ab' * 32, 'count': 5},
                           'weights': {'file': 'v9.safetensors', 'sha256': 'cd' * 32}}}


class CardTest(unittest.TestCase):
    def card(self, text):
        with tempfile.NamedTemporaryFile('w', suffix='.json', encoding='utf-8') as file:
            file.write(text)
            file.flush()
            return run('card.py', file.name, 'abcd1234')

    def test_each_table_says_which_weights_judges_and_programs_it_is_of(self):
        done = self.card(json.dumps(report()))
        self.assertEqual((0, ''), (done.returncode, done.stderr))
        lines = done.stdout.splitlines()
        self.assertEqual('|  | v9 | constant offset | real clips |', lines[0])
        self.assertIn('| movement alone recognized | 0.50 ± 0.25 [0.40, 0.60] |', done.stdout)
        self.assertIn('| odd | 0.50 ± 0.25 [0.40, 0.60] | 0.50 ± 0.25 | 2.00 | 2.00 | 2.0 ± 0.5 (2) | 0.50 | 0.50; 0.50 |',
                      done.stdout)
        said = [line for line in lines if line.startswith('Of ')]
        self.assertEqual(['Of `v9.safetensors`, SHA-256 cdcdcdcdcdcdcdcd, commit abcd1234, 5 judges of SHA-256 '
                          'abababababababab, split test of m, 1,200 windows of 2 clips.'] * 2, said)

    def test_what_is_no_report_is_refused(self):
        for text, said in (('{}', 'expected what styleeval --json writes'), ('no', 'Expecting value'), ('[]', 'expected what')):
            done = self.card(text)
            self.assertEqual((1, ''), (done.returncode, done.stdout))
            self.assertIn(said, done.stderr)


if __name__ == '__main__':
    unittest.main()
