"""The targets that documents and comments refer to are in the tree: links, their headings, names of
files."""
import os
import re
import subprocess
import unittest

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..'))
LINK = re.compile(r'\]\(([^)\s]+)\)')
CODE = re.compile(r'`([^`\n]+)`')
NAME = re.compile(r'(?<![\w./~$%*<>{}-])((?:[\w.-]+/)*[\w-][\w.-]*\.(?:md|h|cpp|py|sh|proto|mjs|tsx?))(?![\w*/-])')
COMMENT = re.compile(r'(?:^|\s)(?://|#(?!include))(.*)')
SOURCES = ('.h', '.cpp', '.py', '.sh', '.proto', '.toml', '.cmake', '.mjs', '.ts', '.tsx', '.in',
           'CMakeLists.txt')
# Names of files that are not meant to be here: other projects', made by the build, or examples.
ELSEWHERE = re.compile(r'\.pb\.h$|_pb2?\.(py|ts|js)$|^build/|(^|/)NAME/|(^|/)[A-Z]+\.(?!md$)')
OF_OTHERS = {
    'proto/rigs/README.md': {'connection.cpp', 'packets.h', 'connection.c', 'hid.c'},
    'clients/cpp/README.md': {'renderer.cpp'},
    'model/net/kernels/kernel.cpp': {'highway.h'},
    'model/net/kernels/rows.cpp': {'highway.h'},
}


def tracked():
    """Every file of the tree, relative to its root; without git, all but what a build makes."""
    listed = subprocess.run(['git', '-C', ROOT, 'ls-files', '-z', '--cached', '--others', '--exclude-standard'],
                            capture_output=True, check=False)
    if listed.returncode == 0 and listed.stdout:
        files = listed.stdout.decode().rstrip('\0').split('\0')
    else:
        files = []
        for folder, folders, names in os.walk(ROOT):
            folders[:] = [name for name in folders if name not in ('.git', 'build', 'node_modules')]
            files += [os.path.relpath(os.path.join(folder, name), ROOT) for name in names]
    return {file for file in files if os.path.exists(os.path.join(ROOT, file))}


class Tree:
    def __init__(self, files):
        self.files = files
        self.folders = {os.path.dirname(file) for file in files}
        for folder in list(self.folders):
            while folder:
                folder = os.path.dirname(folder)
                self.folders.add(folder)
        self.ends = {file[at:] for file in files for at in self._starts(file)}

    @staticmethod
    def _starts(file):
        return [0] + [at + 1 for at, letter in enumerate(file) if letter == '/']

    def has(self, path):
        return path in self.files or path in self.folders

    def names(self, page, name):
        """Whether `name`, said on `page`, is a file: from there, from the root, or the end of a path."""
        return (self.has(os.path.normpath(os.path.join(os.path.dirname(page), name))) or
                os.path.normpath(name) in self.ends)


def headings(text):
    """The anchors of a page, as GitHub makes them of its headings."""
    found = set()
    for line in re.findall(r'^#+ +(.*)$', text, re.MULTILINE):
        found.add(re.sub(r'[^\w\- ]', '', line.strip().lower()).replace(' ', '-'))
    return found


def wrong_links(page, text, tree, read):
    """The targets of a page's links that do not exist."""
    wrong = []
    for target in LINK.findall(text):
        if re.match(r'[a-z]+:', target):
            continue
        path, _, anchor = target.partition('#')
        file = os.path.normpath(os.path.join(os.path.dirname(page), path)) if path else page
        if not tree.has(file):
            wrong.append(f'{page}: link to {target}: no such file')
        elif anchor and anchor not in headings(text if file == page else read(file)):
            wrong.append(f'{page}: link to {target}: no such heading')
    return wrong


def lost_pages(first, pages, read):
    """The pages to which no way leads along links from the first one; a folder stands for its README.md."""
    found, todo = set(), [first]
    while todo:
        page = todo.pop()
        if page not in found:
            found.add(page)
            for target in LINK.findall(read(page)):
                path = os.path.normpath(os.path.join(os.path.dirname(page), target.partition('#')[0]))
                todo += [file for file in (path, os.path.join(path, 'README.md')) if file in pages]
    return sorted(set(pages) - found)


def wrong_names(page, text, tree):
    """Names of files in a text that are not in the tree."""
    return [f'{page}: names {name}, which is not in the tree' for name in dict.fromkeys(NAME.findall(text))
            if not ELSEWHERE.search(name) and name not in OF_OTHERS.get(page, ()) and not tree.names(page, name)]


def comments(text):
    return '\n'.join(match.group(1) for match in map(COMMENT.search, text.splitlines()) if match)


def read(file):
    with open(os.path.join(ROOT, file), encoding='utf-8', errors='replace') as text:
        return text.read()


def is_markdown(page):
    """Whether it begins with a title, and its headings are headings."""
    text = re.sub(r'^```.*?^```', '', page, flags=re.MULTILINE | re.DOTALL)
    return text.startswith('# ') and not re.search(r'^ *#+[A-Za-z]|^ +##', text, re.MULTILINE)


class LinksTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.tree = Tree(tracked())
        cls.pages = sorted(file for file in cls.tree.files if file.endswith('.md'))
        cls.sources = sorted(file for file in cls.tree.files if file.endswith(SOURCES))

    def test_pages_are_markdown(self):
        self.assertEqual([], [page for page in self.pages if not is_markdown(read(page))])
        self.assertFalse(is_markdown('#A title\n'), 'a formatter of code has gone over it')
        self.assertFalse(is_markdown('# A title\n   ##Another\n'))

    def test_links_lead_to_files_and_headings(self):
        self.assertGreater(len(self.pages), 15)
        self.assertEqual([], [wrong for page in self.pages
                              for wrong in wrong_links(page, read(page), self.tree, read)])

    def test_every_page_is_found_from_the_readme(self):
        self.assertEqual([], lost_pages('README.md', self.pages, read))

    def test_a_page_that_no_other_links_to_is_lost(self):
        texts = {'README.md': '[a](a) [b](https://b.md)', 'a/README.md': '[c](../c.md#x)', 'c.md': '', 'd.md': ''}
        self.assertEqual(['d.md'], lost_pages('README.md', texts, texts.get))

    def test_files_that_a_document_names_exist(self):
        self.assertEqual([], [wrong for page in self.pages
                              for wrong in wrong_names(page, '\n'.join(CODE.findall(read(page))), self.tree)])

    def test_files_that_a_comment_names_exist(self):
        self.assertGreater(len(self.sources), 300)
        self.assertEqual([], [wrong for source in self.sources if source != 'tests/documents/test_links.py'
                              for wrong in wrong_names(source, comments(read(source)), self.tree)])

    def test_what_is_not_there_is_found(self):
        tree = Tree({'README.md', 'model/rig/binding.h'})
        page = '# A title\n[a](model/rig/binding.h) [b](#a-title) [c](https://example.org) [d](model)\n'
        self.assertEqual([], wrong_links('README.md', page, tree, None))
        page += '[e](plan.md) [f](#another)\n'
        self.assertEqual(['README.md: link to plan.md: no such file',
                          'README.md: link to #another: no such heading'],
                         wrong_links('README.md', page, tree, None))
        self.assertEqual([], wrong_names('model/a.h', 'see rig/binding.h, frame.pb.h and README.md', tree))
        self.assertEqual(['model/a.h: names plan.md, which is not in the tree'],
                         wrong_names('model/a.h', 'as plan.md section 13 says', tree))
        self.assertEqual(' as plan.md says', comments('int a;  // as plan.md says\nint b;'))


if __name__ == '__main__':
    unittest.main()
