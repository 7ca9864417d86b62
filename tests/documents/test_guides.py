"""README.md, clients/README.md and the guides in daemon/ name programs, options, counters and terms that exist.
A stranger reads README.md in two minutes: it has at most 110 lines."""
import glob
import os
import re
import unittest

from test_operating import ROOT, counters, read

PROGRAMS = ('styled', 'stylectl', 'stylemon', 'stylesim', 'stylerec', 'stylevmc', 'stylenats',
            'styleoscquery', 'styleweb', 'stylize')
GROUPS = ('source', 'usb', 'pipeline', 'stylist', 'publish', 'control', 'security', 'config', 'state', 'record')
README_LINES = 110
CODE = re.compile(r'`([^`\n]+)`')
BLOCK = re.compile(r'^```sh\n(.*?)^```', re.MULTILINE | re.DOTALL)
TERM = re.compile(r'^\| ([^|*]+) \| (.*) \|$', re.MULTILINE)


def source_of(program):
    """The text of all sources that may declare an option of the program."""
    folders = {'styled': 'daemon', 'stylesim': 'sim', 'stylize': 'model/tools'}.get(program, 'clients')
    text = ''
    for file in glob.glob(os.path.join(ROOT, folders, '**', '*.cpp'), recursive=True):
        with open(file, encoding='utf-8') as source:
            text += source.read()
    # Fields of a look are options of stylectl by their table.
    words = re.findall(r'^    \{"\w+", "(\w+)"', read('proto', 'styled', 'look.h'), re.MULTILINE)
    return text + ''.join(f'"--{word}"' for word in words if program == 'stylectl')


def commands(page):
    """The commands of a page: lines of its shell blocks, and pieces of code that begin with a program."""
    lines = [line.split('#')[0] for block in BLOCK.findall(page) for line in block.splitlines()]
    words = [line.replace('sudo ', '').split() for line in lines + CODE.findall(page)]
    return [line for line in words if line and line[0] in PROGRAMS and len(line) > 1]


def wrong_options(page, source):
    """Options of commands that `source`, a function of a program's name, does not declare."""
    return [f'{words[0]} {word}' for words in commands(page) for word in words[1:]
            if word.startswith('--') and not re.search(rf'[",]{word}[",{{]', source(words[0]))]


def wrong_counters(page, known):
    names = re.findall(rf'`((?:{"|".join(GROUPS)})\.[a-z_]+)`', page)
    return [name for name in names if name not in known]


def glossary(page):
    return [(term, meaning) for term, meaning in TERM.findall(page) if term not in ('term', '---')]


def terms_not_explained(entries):
    """Words in italics that have no row: *styles* is of the term style."""
    terms = {word for term, _ in entries for word in term.split(', ')}
    return [word for _, meaning in entries for word in re.findall(r'\*([^*]+)\*', meaning)
            if word.lower() not in terms and word.lower().rstrip('s') not in terms]


def beyond(page, lines):
    """The lines of a page that are too many."""
    return page.splitlines()[lines:]


def sections(toml):
    """{section: its keys} of styled.toml, those that are commented out included."""
    found, keys = {}, set()
    for line in toml.splitlines():
        head, key = re.match(r'(?:# )?\[\[?(\w+)\]', line), re.match(r'(?:# *)?(\w+) *=', line)
        if head:
            keys = found.setdefault(head.group(1), set())
        elif key:
            keys.add(key.group(1))
    return found


def wrong_keys(page, known):
    """Sections, and keys behind them, that a page names and styled.toml has not."""
    return [f'[{section}] {key}'.strip() for section, key in re.findall(r'`\[\[?([a-z]\w*)\]\]?(?: (\w+))?', page)
            if key not in {'', *known.get(section, ())} or section not in known]


class GuidesTest(unittest.TestCase):
    def setUp(self):
        self.page = read('daemon', 'TROUBLESHOOTING.md')
        self.entries = glossary(read('daemon', 'GLOSSARY.md'))

    def test_options_and_counters_of_the_troubleshooting_exist(self):
        self.assertGreater(len(commands(self.page)), 25)
        sources = {program: source_of(program) for program in PROGRAMS}
        self.assertEqual([], wrong_options(self.page, sources.get))
        self.assertEqual([], wrong_counters(self.page, counters(read('daemon', 'runtime', 'counters.cpp'))))

    def test_options_of_the_other_pages_exist(self):
        sources = {program: source_of(program) for program in PROGRAMS}
        guides = [('clients', 'guides', f'{who}.md') for who in ('ANIMATOR', 'PROGRAMMER', 'RESEARCHER', 'STAGE', 'VTUBER')]
        for page in (('README.md',), ('clients', 'README.md'), ('daemon', 'OPERATING.md'), *guides):
            with self.subTest(page=page):
                self.assertGreater(len(commands(read(*page))), 2)
                self.assertEqual([], wrong_options(read(*page), sources.get))

    def test_sections_and_keys_of_the_configuration_exist(self):
        known = sections(read('daemon', 'config', 'styled.toml'))
        self.assertGreater(sum(map(len, known.values())), 80)
        pages = glob.glob(os.path.join(ROOT, '*.md'))
        for folder in ('clients', 'daemon', 'model', 'proto', 'tests'):
            pages += glob.glob(os.path.join(ROOT, folder, '**', '*.md'), recursive=True)
        for page in pages:
            if '/node_modules/' not in page:
                with self.subTest(page=os.path.relpath(page, ROOT)):
                    self.assertEqual([], wrong_keys(read(page), known))

    def test_the_readme_is_short(self):
        self.assertEqual([], beyond(read('README.md'), README_LINES))
        self.assertEqual(['c', ''], beyond('a\nb\nc\n\n', 2))

    def test_the_terms_are_in_order_and_those_in_italics_have_a_row(self):
        terms = [term.lower() for term, _ in self.entries]
        self.assertGreater(len(terms), 40)
        self.assertEqual(sorted(terms), terms)
        self.assertEqual([], terms_not_explained(self.entries))

    def test_what_does_not_exist_is_found(self):
        page = '`styled --fast` `stylectl doctor --seconds 3`\n```sh\nsudo stylectl --quick  # --slow\n```\n`pipeline.lots`'
        self.assertEqual(['stylectl --quick', 'styled --fast'], wrong_options(page, lambda _: '("--seconds",'))
        self.assertEqual(['pipeline.lots'], wrong_counters(page, {'pipeline.late': True}))
        self.assertEqual(['[look] x', '[style] librarian', '[look]'], wrong_keys(
            '`[look] x` `[style] librarian` `[[look]]` `[style] library` `[style]`', {'style': {'library'}}))
        self.assertEqual(['weather'], terms_not_explained([('style', 'as *styles*, *weather*')]))


if __name__ == '__main__':
    unittest.main()
