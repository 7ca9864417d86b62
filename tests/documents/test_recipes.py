"""The recipes of model/train/recipes are commands that styletrain and styleeval could be given."""
import glob
import os
import re
import shlex
import subprocess
import unittest

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..'))
RECIPES = os.path.join(ROOT, 'model', 'train', 'recipes')
WEIGHTS = os.path.join(ROOT, 'model', 'weights', 'v1.safetensors')


def run(recipe, *arguments, **environment):
    clean = {name: value for name, value in os.environ.items() if not name.startswith('STYLED_')}
    return subprocess.run([os.path.join(RECIPES, recipe), *arguments], capture_output=True, text=True, check=False,
                          env=dict(clean, **environment))


def known_options():
    found = {'--name', '--replace'}
    for pattern in ('model/tools/style*.cpp', 'model/train/**/*.cpp', 'model/tools/**/*.h'):
        for file in glob.glob(os.path.join(ROOT, pattern), recursive=True):
            with open(file, encoding='utf-8') as text:
                found.update(re.findall(r'(--[a-z][\w-]*)', text.read()))
    return found


def wrong(commands, known):
    """What is wrong with lines of commands: options that no program has, files that are not in the tree."""
    found = []
    for line in commands:
        words = shlex.split(line)
        found += [word for word in words if word.startswith('--') and word not in known]
        found += [word for word in words if word.startswith(ROOT) and not os.path.exists(word.split(':')[0])]
    return found


class RecipesTest(unittest.TestCase):
    def setUp(self):
        self.recipes = sorted(set(map(os.path.basename, glob.glob(os.path.join(RECIPES, '*.sh')))) - {'recipe.sh'})

    def commands(self, recipe):
        arguments = ['--dry-run'] + ([WEIGHTS] if recipe == 'evaluate.sh' else []) + ['RUNS']
        done = run(recipe, *arguments)
        self.assertEqual((0, ''), (done.returncode, done.stderr))
        return [line for line in done.stdout.splitlines() if line.startswith('style')]

    def test_each_prints_commands_with_options_and_files_that_exist(self):
        self.assertGreater(len(self.recipes), 3)
        known = known_options()
        for recipe in self.recipes:
            with self.subTest(recipe=recipe):
                commands = self.commands(recipe)
                self.assertGreater(len(commands), 1)
                self.assertEqual([], wrong(commands, known))

    def test_arguments_are_checked(self):
        for arguments, environment, said in (
                ([], {}, 'expected 1 arguments, found 0'),
                (['--fast', 'RUNS'], {}, "unknown option '--fast'"),
                (['RUNS'], {}, 'STYLED_DATA is not set'),
                (['RUNS'], {'STYLED_DATA': ROOT}, 'has no folder bandai-1')):
            with self.subTest(said=said):
                done = run('v0.sh', *arguments, **environment)
                self.assertEqual(2, done.returncode)
                self.assertIn(said, done.stderr)

    def test_what_does_not_exist_is_found(self):
        lost = os.path.join(ROOT, 'model', 'weights', 'manifests', 'lost.toml')
        self.assertEqual(['--quickly', lost], wrong([f'styletrain --quickly --manifest {lost}'], known_options()))


if __name__ == '__main__':
    unittest.main()
