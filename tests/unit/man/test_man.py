"""Manual pages and bash completion agree with the programs' --help; the completion knows the styles and
performers of the running daemon."""
import functools
import os
import re
import subprocess
import unittest

from daemon import Daemon, wait_for

BIN, MAN = os.environ['STYLED_BIN'], os.environ['STYLED_MAN']
COMPLETION = os.path.join(os.environ['STYLED_ROOT'], 'clients', 'man', 'styled.bash')
# Those for users; the others there are tests and their tools.
PROGRAMS = [name for name in ('styled', 'stylectl', 'stylemon', 'stylesim', 'stylerec', 'stylevmc', 'stylenats',
                              'styleoscquery', 'styleweb', 'stylize', 'styletrain', 'styleeval', 'styleunseen', 'stylerefine')
            if os.path.exists(os.path.join(BIN, name))]


@functools.lru_cache(maxsize=None)
def help_of(*command):
    environment = {name: value for name, value in os.environ.items() if name != 'STYLED_DATA'}
    done = subprocess.run([os.path.join(BIN, command[0]), *command[1:], '--help'], capture_output=True, text=True,
                          env=environment)
    assert done.returncode == 0, (command, done.stderr)
    return done.stdout


def section(text, name):
    """The heads of the entries of a section of the help."""
    found = re.search(rf'(?m)^{name}:\n((?:  .*\n)*)', text)
    return re.findall(r'(?m)^  (\S+)', found[1]) if found else []


# Of options; styletrain has more than one.
GROUPS = ('Options', 'Start', 'Data', 'Network', 'Losses', 'Schedule', 'Machine', 'Output')


def options(text):
    return [name for group in GROUPS for head in section(text, group)
            for name in head.replace('{false}', '').split(',')]


def commands_of(program):
    return [(program,)] + [(program, name) for name in section(help_of(program), 'Subcommands')]


def families_of(program):
    """Families of networks other than the first, whose options the help shows where they are named."""
    found = re.search(r'--family TEXT:\{([^}]*)\}', help_of(program))
    return [(program, '--family', family) for family in found[1].split(',')[1:]] if found else []


def values(text):
    """The names of options, and the description of their values in the help: type, range or words,
    default."""
    return [(re.escape(names.split(',')[-1]), value)
            for names, value in re.findall(r'(?m)^  (-\S+) ((?:TEXT|INT|UINT|FLOAT|BOOLEAN)[:=]\S+)', text)
            if not value.startswith(('FLOAT:FLOAT', 'INT:INT'))]


SCRIPT = f'''source {COMPLETION}
while IFS= read -r line; do
  read -ra COMP_WORDS <<<"$line"
  [[ $line == *' ' ]] && COMP_WORDS+=('')
  COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1))
  _styled_complete "${{COMP_WORDS[0]}}" "${{COMP_WORDS[COMP_CWORD]}}" "${{COMP_WORDS[COMP_CWORD-1]}}"
  printf '%s ' "${{COMPREPLY[@]}}"
  echo
done'''


def complete_each(lines, environment=None):
    """The suggestions of bash for the last word of each line."""
    done = subprocess.run(['bash', '-c', SCRIPT], input='\n'.join(f'{BIN}/{line}' for line in lines) + '\n',
                          capture_output=True, text=True, env=dict(os.environ, **(environment or {})), cwd='/')
    assert done.stderr == '', done.stderr
    return [line.split() for line in done.stdout.splitlines()]


def complete(line, environment=None):
    return complete_each([line], environment)[0]


class ManTest(unittest.TestCase):
    def test_every_option_and_command_is_on_its_page(self):
        self.assertGreaterEqual(len(PROGRAMS), 7)
        for program in PROGRAMS:
            with open(os.path.join(MAN, program + '.1')) as text:
                # Bold between < and >.
                page = text.read().replace(r'\fB', '<').replace(r'\fR', '>').replace('\\&', '').replace('\\', '')
            for name in ('NAME', 'SYNOPSIS', 'DESCRIPTION'):
                self.assertRegex(page, rf'(?m)^\.SH {name}$', program)
            for command in commands_of(program) + families_of(program):
                self.assertIn(' '.join(command), page)
                for option in options(help_of(*command)):
                    self.assertRegex(page, rf'(?m)^<([^>\n]*, )?{re.escape(option)}(, [^>\n]*)?>', command)
                for option, value in values(help_of(*command)):
                    self.assertRegex(page, rf'(?m)^<[^>\n]*{option}[^>\n]*> {re.escape(value)}( |$)', command)

    def test_pages_are_without_errors(self):
        for page in os.listdir(MAN):
            if not page.endswith('.scd'):
                # groff, where it is there, has nothing to say against it.
                done = subprocess.run(['sh', '-c', f'command -v groff >/dev/null || exit 0; '
                                       f'groff -man -Tutf8 -ww {os.path.join(MAN, page)} >/dev/null'],
                                      capture_output=True, text=True)
                self.assertEqual((done.returncode, done.stderr), (0, ''), page)

    def test_the_configuration_s_page_has_every_key(self):
        with open(os.path.join(MAN, 'styled.toml.5')) as text:
            page = text.read()
        for key in ('high_water_mark', 'stale_ms', 'delay_ms'):
            self.assertIn(key, page.replace('\\', ''))


class CommandLineTest(unittest.TestCase):
    def refused(self, *command):
        """The message of a program for an invalid command line."""
        done = subprocess.run([os.path.join(BIN, command[0]), *command[1:]], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout), (2, ''), command)
        return done.stderr

    def test_what_is_not_understood_ends_with_two(self):
        for program in PROGRAMS:
            self.assertNotEqual(self.refused(program, '--no-such-option'), '', program)

    def test_seeds_are_whole_numbers(self):
        for program in {'styletrain', 'styleeval'} & set(PROGRAMS):
            for seed in ('-1', '1e5', '18446744073709551616'):
                self.assertIn(f"'{seed}': expected a whole number from 0 to ", self.refused(program, '--seed', seed))

    def test_the_trainer_refuses_a_width_that_no_program_loads(self):
        if 'styletrain' in PROGRAMS:
            said = self.refused('styletrain', '--family', 'st-gcn', '--width', '8', '--data', '.', '--out', '/nonexistent',
                                '--iterations', '1', '--validate', '/nonexistent')
            self.assertIn('--width: found 8, expected a multiple of 16 up to 96', said)

    def test_the_trainer_asks_for_a_folder_of_data(self):
        if 'styletrain' in PROGRAMS:
            environment = {name: value for name, value in os.environ.items() if name != 'STYLED_DATA'}
            done = subprocess.run([os.path.join(BIN, 'styletrain'), '--out', '/nonexistent', '--iterations', '1'],
                                  capture_output=True, text=True, env=environment)
            self.assertEqual(done.returncode, 2)
            self.assertIn('--data is needed', done.stderr)


class CompletionTest(unittest.TestCase):
    def test_every_option_and_command_is_completed(self):
        commands = [command for program in PROGRAMS for command in commands_of(program)]
        offered = complete_each([' '.join(command) + ' --' for command in commands])
        self.assertEqual(len(offered), len(commands))
        for command, words in zip(commands, offered):
            expected = {o for o in options(help_of(*command)) if o.startswith('--')}
            self.assertFalse(expected - set(words), command)
        with_commands = [program for program in PROGRAMS if section(help_of(program), 'Subcommands')]
        for program, words in zip(with_commands, complete_each([p + ' ' for p in with_commands])):
            self.assertTrue(set(section(help_of(program), 'Subcommands')) <= set(words), program)

    def test_completes_words_that_an_option_names_and_files(self):
        self.assertEqual(complete('stylectl calibrate rig.a --pose t'), ['t'])
        self.assertEqual(complete('stylerec export x --what can'), ['canonical'])
        self.assertIn('elderly', complete('stylize --style eld'))
        self.assertIn('/etc', complete('stylerec info /et'))
        self.assertEqual(complete('stylesim --as m'), ['mocopi', 'mvn'])
        self.assertIn('left-arm', complete('stylectl set rig.a --parts '))
        self.assertIn('left-arm', complete('stylectl set rig.a --only '))
        # Nothing but commands where one is missing.
        commands = section(help_of('stylectl'), 'Subcommands')
        self.assertEqual(sorted(complete('stylectl ')), sorted(commands))
        self.assertEqual(sorted(complete('stylectl --timeout 3 ')), sorted(commands))
        self.assertIn('etc', complete('stylesim --bvh '))

    def test_completes_what_the_daemon_has(self):
        daemon = Daemon()
        self.addCleanup(daemon.close)
        environment = {'STYLED_CONTROL': daemon.control}
        daemon.simulate()
        wait_for(lambda: 'rig.sim' in complete('stylectl set rig', environment), 'rig.sim')
        self.assertIn('elderly', complete('stylectl set rig.sim --style ', environment))
        self.assertIn(r'\*', complete('stylectl set ', environment))
        self.assertIn('rig.sim', complete('stylectl preset mild ', environment))
        self.assertIn('rig.sim', complete('stylectl preset ', environment))
        self.assertNotIn('rig.sim', complete('stylectl preset rig.sim ', environment))


if __name__ == '__main__':
    unittest.main()
