"""Lists of the fields of a look (proto/styled/v1/look.proto) that no compiler compares with it have all of them, or
say here which are left out: the Unity package's. The page's list is made of the message; what it leaves out exists.
Python's options are made of proto/styled/look.h (tests/unit/python/test_arguments.py)."""

import os
import re
import unittest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..')

# Unity's Control sets a style, its strength and its fade, or clears them. A new field is added to Control.cs or here.
UNITY_LEAVES_OUT = {'absolute', 'parts', 'input_style', 'preset', 'root', 'vary', 'vary_each', 'vary_amount', 'drift_s',
                    'mirror', 'idle'}


def read(*path):
    with open(os.path.join(ROOT, *path), encoding='utf-8') as text:
        return text.read()


def fields(proto, message):
    """{field: number} of a message without nested ones."""
    body = re.search(rf'^message {message} \{{\n(.*?)^\}}', proto, re.MULTILINE | re.DOTALL).group(1)
    return {name: int(number)
            for name, number in re.findall(r'^  (?:optional |repeated )?[\w.]+ (\w+) = (\d+);', body, re.MULTILINE)}


def snake(name):
    return re.sub('[A-Z]', lambda letter: '_' + letter.group(0).lower(), name)


def apart_on_page(source):
    return {snake(name) for name in re.findall(r"'(\w+)'", re.search(r'const APART = \[(.*?)\]', source).group(1))}


def written_by_unity(source):
    """The field numbers of the Look that SetStyle and Clear write."""
    calls = re.search(r'Dictionary<string, ulong> SetStyle\(.*?(?=/// <summary>Sets all performers to bypass)', source, re.DOTALL).group(0)
    outer = re.sub(r'new WireWriter\(\)\.Text\(1, style\)\.Float\(2, 1\)\.Bytes', '', calls)  # a StyleWeight
    outer = re.sub(r'Request\(performer\)\.Message\(4,', '', outer)  # a Request
    return {int(number) for number in re.findall(r'\.(?:Message|Text|Float|Number)\((\d+),', outer)}


class Look(unittest.TestCase):

    def setUp(self):
        self.fields = fields(read('proto', 'styled', 'v1', 'look.proto'), 'Look')
        self.assertGreater(len(self.fields), 12)

    def test_what_the_page_handles_one_by_one_exists(self):
        apart = apart_on_page(read('clients', 'web', 'page', 'src', 'looks.ts'))
        self.assertTrue(apart)
        self.assertLessEqual(apart, set(self.fields))

    def test_unity_writes_every_field_by_its_number_or_it_is_left_out_here(self):
        written = written_by_unity(read('clients', 'unity', 'Runtime', 'Control.cs'))
        wanted = {self.fields[name] for name in set(self.fields) - UNITY_LEAVES_OUT}
        self.assertEqual(wanted, written)
        self.assertLessEqual(UNITY_LEAVES_OUT, set(self.fields))

    def test_the_usual_fade_is_one(self):
        said = re.search(r'initially (\d+); shortest fade', read('proto', 'styled', 'v1', 'look.proto')).group(1)
        page = re.search(r'^  transition_ms = (\d+);', read('clients', 'web', 'page', 'src', 'app.ts'), re.MULTILINE).group(1)
        constant = re.search(r'kUsualTransition_s = ([\d.]+)F;', read('model', 'net', 'styles.h')).group(1)
        manual = re.search(r'^# transition_ms = (\d+) ', read('daemon', 'config', 'styled.toml'), re.MULTILINE).group(1)
        self.assertEqual([said] * 3, [page, f'{1000 * float(constant):g}', manual])

    def test_a_new_field_is_missed_in_both(self):
        proto = 'message Look {\n  repeated StyleWeight mix = 1;  // x\n  optional float glow = 14;\n}\n'
        self.assertEqual({'mix': 1, 'glow': 14}, fields(proto, 'Look'))
        self.assertEqual({'drift_s'}, apart_on_page("const APART = ['driftS'] as const;"))
        self.assertNotIn(14, written_by_unity(read('clients', 'unity', 'Runtime', 'Control.cs')))


if __name__ == '__main__':
    unittest.main()
