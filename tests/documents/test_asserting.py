"""Every GoogleTest case asserts something, by itself or by a function that it calls."""
import glob
import os
import re
import unittest

TESTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..')
# The macros, and functions that say by their name that they use them.
ASSERTS = re.compile(r'\b(?:(?:EXPECT|ASSERT|FAIL|ADD_FAILURE|REQUIRE)(?:_\w+)?|Expect[A-Z]\w*|RunDaemon)\(')
CASE = re.compile(r'^TEST(?:_F|_P)?\(([^)]*)\) \{', re.MULTILINE)
# A definition of a function, a method or a lambda with a name.
FUNCTION = re.compile(r'(?:\b(\w+)\([^;{}]*\)(?: const| noexcept| override)*'
                      r'|\b(\w+) = \[[^\]]*\](?:\([^;{}]*\))?(?: mutable)?(?: -> [\w:]+)?) \{')
CALL = re.compile(r'\b(\w+)(?:<[^<>;()]*>)?\(')


def block(text, begin):
    """The text of the braces that open at `begin`."""
    depth = 0
    for at in range(begin, len(text)):
        depth += {'{': 1, '}': -1}.get(text[at], 0)
        if depth == 0:
            return text[begin:at + 1]
    return text[begin:]


def functions(text):
    """(name, body) of the functions that a source defines."""
    for found in FUNCTION.finditer(text):
        name = found.group(1) or found.group(2)
        if name not in ('if', 'for', 'while', 'switch', 'TEST', 'TEST_F', 'TEST_P'):
            yield name, block(text, found.end() - 1)


def asserting(sources):
    """Names of functions that assert, or call one that does."""
    bodies = [pair for text in sources for pair in functions(text)]
    known = {name for name, body in bodies if ASSERTS.search(body)}
    while True:
        more = {name for name, body in bodies if known.intersection(CALL.findall(body))} - known
        if not more:
            return known
        known |= more


def silent(text, known):
    """The cases of a source that assert nothing."""
    for case in CASE.finditer(text):
        body = block(text, case.end() - 1)
        if not ASSERTS.search(body) and not known.intersection(CALL.findall(body)):
            yield ' '.join(case.group(1).split())


def seen_from(file, sources):
    """The sources whose functions a test may call: its own folder's, and those that it includes."""
    folder = os.path.dirname(file)
    included = set(re.findall(r'#include "tests/([^"]*)"', sources[file]))
    bodies = {re.sub(r'\.h$', '.cpp', name) for name in included}
    return [text for name, text in sources.items()
            if name == file or name in included or name in bodies or
            (os.path.dirname(name) == folder and not CASE.search(text))]


class AssertingTest(unittest.TestCase):
    def test_every_case_asserts_something(self):
        sources = {}
        for pattern in ('**/*.cpp', '**/*.h'):
            for file in glob.glob(os.path.join(TESTS, pattern), recursive=True):
                with open(file, encoding='utf-8') as text:
                    sources[os.path.relpath(file, TESTS)] = text.read()
        cases = sum(len(CASE.findall(text)) for text in sources.values())
        self.assertGreater(cases, 2000)
        self.assertEqual([], [f'{file}: {case}' for file, text in sorted(sources.items()) if CASE.search(text)
                              for case in silent(text, asserting(seen_from(file, sources)))])

    def test_a_case_without_an_assertion_is_found(self):
        source = ('void Check(int x) {\n  EXPECT_EQ(x, 1);\n}\nvoid Twice(int x) {\n  Check(x);\n}\n'
                  'TEST(A, Asserts) {\n  Twice(1);\n}\nTEST(A, DoesNot) {\n  (void)Run(1);\n}\n')
        self.assertEqual(['A, DoesNot'], list(silent(source, asserting([source]))))


if __name__ == '__main__':
    unittest.main()
