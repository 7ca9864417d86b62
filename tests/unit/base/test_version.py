"""Every program of bin says its version, the commit that was built, and which weights it would load; and the
commit's header changes only with the commit."""
import hashlib
import os
import re
import shutil
import subprocess
import tempfile
import unittest

BIN, ROOT, CMAKE = os.environ['STYLED_BIN'], os.environ['STYLED_ROOT'], os.environ['CMAKE']
VERSION = os.environ['STYLED_VERSION']
SCRIPT = os.path.join(ROOT, 'model', 'base', 'write_commit.cmake')
# For users and for training; styled_* are tests and their tools.
PROGRAMS = [name for name in sorted(os.listdir(BIN)) if re.fullmatch(r'styled|style(?!d)[a-z]+|stylize', name)]
LOAD_WEIGHTS = {'styled', 'stylize', 'stylerefine'} & set(PROGRAMS)


def said(program, **environment):
    done = subprocess.run([os.path.join(BIN, program), '--version'], capture_output=True, text=True, stdin=subprocess.DEVNULL,
                          env=dict(os.environ, **environment), timeout=60)
    assert (done.returncode, done.stderr) == (0, ''), (program, done.returncode, done.stderr)
    return done.stdout.splitlines()


class ProgramsTest(unittest.TestCase):
    def test_each_says_version_and_commit(self):
        self.assertGreaterEqual(len(PROGRAMS), 9)
        for program in PROGRAMS:
            self.assertRegex(said(program)[0], rf'^{program} {re.escape(VERSION)}(, commit [0-9a-f]{{12}}(, changed)?)?$')
            if os.path.exists(os.path.join(ROOT, '.git')) and shutil.which('git'):
                self.assertIn(', commit ', said(program)[0])

    def test_programs_that_load_weights_name_them(self):
        file = os.path.join(ROOT, 'model', 'weights', 'open.safetensors')
        with open(file, 'rb') as weights:
            digits = hashlib.sha256(weights.read()).hexdigest()[:12]
        for program in PROGRAMS:
            lines = said(program, STYLED_WEIGHTS='open')
            if program in LOAD_WEIGHTS:
                self.assertEqual(lines[1:], [f'weights open {digits} ({os.path.realpath(file)})'], program)
            else:
                self.assertEqual(len(lines), 1, program)

    def test_weights_that_are_not_there_are_no_error(self):
        for program in LOAD_WEIGHTS:
            self.assertIn('/nonexistent.safetensors', said(program, STYLED_WEIGHTS='/nonexistent.safetensors')[1])


@unittest.skipUnless(shutil.which('git'), 'no git')
class CommitTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.tree = os.path.join(folder.name, 'tree')
        self.out = os.path.join(folder.name, 'commit.h')
        os.mkdir(self.tree)
        self.change('one')

    def change(self, text):
        with open(os.path.join(self.tree, 'file'), 'w') as file:
            file.write(text)

    def git(self, *arguments, tree=None):
        identity = ['-c', 'user.name=a', '-c', 'user.email=a@b', '-c', 'commit.gpgsign=false', '-c', 'core.hooksPath=/dev/null']
        return subprocess.run(['git', *identity, '-C', tree or self.tree, *arguments], check=True, capture_output=True,
                              text=True).stdout.strip()

    def commit(self):
        self.git('add', '-A')
        self.git('commit', '-q', '-m', 'a')
        return self.git('rev-parse', 'HEAD')[:12]

    def written(self, commit=''):
        subprocess.run([CMAKE, '-D', f'SOURCE={self.tree}', '-D', f'OUT={self.out}', '-D', f'COMMIT={commit}', '-P', SCRIPT],
                       check=True, capture_output=True)
        with open(self.out) as header:
            return re.search(r'STYLED_COMMIT "(.*)"', header.read())[1]

    def test_names_the_commit_and_changes_to_it(self):
        self.git('init', '-q')
        self.assertEqual(self.written(), '')  # no commit yet
        first = self.commit()
        self.assertEqual(self.written(), first)
        self.change('two')
        self.assertEqual(self.written(), first + ', changed')
        second = self.commit()
        self.assertNotEqual(second, first)
        self.assertEqual(self.written(), second)
        with open(os.path.join(self.tree, 'note'), 'w'):
            pass  # not a part of the tree
        self.assertEqual(self.written(), second)

    def test_touches_nothing_while_the_commit_stays(self):
        self.git('init', '-q')
        self.commit()
        self.written()
        os.utime(self.out, (1, 1))
        self.written()
        self.assertEqual(os.stat(self.out).st_mtime, 1)
        self.change('two')
        self.commit()
        self.written()
        self.assertNotEqual(os.stat(self.out).st_mtime, 1)

    def test_a_tree_without_git_has_none_unless_it_is_given(self):
        self.assertEqual(self.written(), '')
        self.assertEqual(self.written('0123456789ab'), '0123456789ab')

    def test_another_repository_around_the_tree_is_not_its_own(self):
        around = os.path.dirname(self.tree)
        self.git('init', '-q', tree=around)
        self.git('add', 'tree', tree=around)
        self.git('commit', '-q', '-m', 'a', tree=around)
        self.assertEqual(self.written(), '')


if __name__ == '__main__':
    unittest.main()
