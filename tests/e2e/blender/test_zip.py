"""The add-on's zip without Blender: what Blender 3.4 reads of it (bl_info) and what 4.2 does (the
manifest, by the rules of its manual) say the same."""
import ast
import os
import re
import sys
import unittest
import zipfile

try:
    import tomllib
except ImportError:
    print('skipped, this python3 has no tomllib (3.11)')
    sys.exit(77)


class ZipTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with zipfile.ZipFile(os.environ['STYLED_ADDON']) as addon:
            cls.names = addon.namelist()
            cls.manifest = tomllib.loads(addon.read('styled_live/blender_manifest.toml').decode())
            tree = ast.parse(addon.read('styled_live/__init__.py').decode())
        cls.info = next(ast.literal_eval(node.value) for node in tree.body if isinstance(node, ast.Assign)
                        and node.targets[0].id == 'bl_info')

    def test_one_folder_has_all(self):
        self.assertEqual({name.split('/')[0] for name in self.names}, {'styled_live'})
        for wanted in ('__init__.py', 'modules/styled/__init__.py', 'modules/styled/v1/frame_pb2.py'):
            self.assertIn('styled_live/' + wanted, self.names)
        self.assertFalse([name for name in self.names if '__pycache__' in name])

    def test_the_manifest_is_as_blenders_manual_asks(self):
        m = self.manifest
        self.assertEqual((m['schema_version'], m['type'], m['id']), ('1.0.0', 'add-on', 'styled_live'))
        for text in (m['tagline'], *m['permissions'].values()):
            self.assertLessEqual(len(text), 64)
            self.assertTrue(text[-1].isalnum(), text)
        self.assertTrue(all(re.fullmatch(r'SPDX:[A-Za-z0-9.-]+', licence) for licence in m['license']))
        self.assertRegex(m['blender_version_min'], r'^4\.2\.\d+$')
        self.assertTrue(m['maintainer'])

    def test_both_say_the_same(self):
        self.assertEqual(self.manifest['version'], '.'.join(map(str, self.info['version'])))
        self.assertEqual((self.manifest['name'], self.manifest['tagline']),
                         (self.info['name'], self.info['description']))
        self.assertEqual(self.manifest['tags'], [self.info['category']])


if __name__ == '__main__':
    unittest.main()
