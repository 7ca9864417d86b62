"""Every file that a package ships is matched by a stanza of its copyright file, and every part of the page has its notice.

The packages' files are those of `cmake --install`, per component, finished as while packing."""
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', '..'))
sys.path.insert(0, os.path.join(ROOT, 'systemd'))
import finish_packages  # noqa: E402

BUILD, CMAKE = os.environ['STYLED_BUILD'], os.environ['CMAKE']
COMPONENTS = ('daemon', 'weights_nc', 'tools', 'web', 'cpp', 'python')
PAGE = 'usr/share/styled/web/notices.txt'


class ShippedTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix='styled-shipped-')
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        for component in COMPONENTS:
            tree = os.path.join(cls.folder, component)
            done = subprocess.run([CMAKE, '--install', BUILD, '--component', component, '--prefix', '/usr'],
                                  capture_output=True, text=True, check=False, env=dict(os.environ, DESTDIR=tree))
            assert done.returncode == 0, done.stderr
            if os.path.isdir(tree + '/usr/etc'):  # of a prefix that is not /usr
                os.rename(tree + '/usr/etc', tree + '/etc')
        cls.programs = finish_packages.third_party(BUILD)
        cls.wrong = {component: finish_packages.finish(os.path.join(cls.folder, component), BUILD, 'Test <t@styled.invalid>',
                                                       cls.programs) for component in COMPONENTS}

    def paths(self, component):
        return finish_packages.files_of(os.path.join(self.folder, component))

    def copyright(self, component):
        path, = (path for path in self.paths(component) if path.endswith('/copyright'))
        return finish_packages.read(self.folder, component, path)

    def test_no_package_leaves_a_file_open(self):
        for component in COMPONENTS:
            self.assertEqual([], self.wrong[component], component)
            self.assertGreater(len(self.paths(component)), 3, component)

    def test_without_any_one_of_its_stanzas_a_package_is_refused(self):
        for component in COMPONENTS:
            paragraphs = self.copyright(component).rstrip('\n').split('\n\n')
            self.assertGreaterEqual(len(paragraphs), 3)
            for removed in range(1, len(paragraphs)):  # the first is the header
                left = '\n\n'.join(paragraphs[:removed] + paragraphs[removed + 1:])
                self.assertTrue(finish_packages.complaints(left, self.paths(component)), (component, paragraphs[removed]))

    def test_the_packages_divide_the_weights_by_what_they_allow(self):
        names = {component: {os.path.basename(path) for path in self.paths(component) if path.endswith('.safetensors')}
                 for component in COMPONENTS}
        self.assertEqual({'open.safetensors'}, names['daemon'])
        self.assertEqual({'v2.safetensors', 'graph.safetensors', 'st-gcn.safetensors'}, names['weights_nc'])
        self.assertNotIn('CC-BY-NC', self.copyright('daemon'))
        self.assertNotIn('License: CC-BY-4.0', self.copyright('weights_nc'))
        for component in ('daemon', 'weights_nc'):
            self.assertTrue([path for path in self.paths(component) if path.endswith('/MODEL-CARD.md')], component)

    def test_packages_have_the_documents_and_their_links_lead_there(self):
        expected = {'daemon': {'OPERATING', 'TROUBLESHOOTING', 'GLOSSARY', 'STANDBY', 'SECURITY', 'WIRE', 'MODEL-CARD'},
                    'weights_nc': {'MODEL-CARD'}, 'tools': set(), 'web': {'README', 'WEBSOCKET'}, 'cpp': set(),
                    'python': {'WIRE'}}
        for component, names in expected.items():
            pages = [path for path in self.paths(component) if '/share/doc/' in path and path.endswith('.md')]
            self.assertEqual({f'{name}.md' for name in names}, {os.path.basename(path) for path in pages})
            for page in pages:
                text = finish_packages.read(self.folder, component, page)
                self.assertGreater(len(text), 1000, page)
                for target, anchor in re.findall(r'\]\((?!\w+://)([^)#\s]*)(#[^)\s]*)?\)', text):
                    self.assertTrue(os.path.exists(os.path.join(self.folder, component, os.path.dirname(page), target)),
                                    f'{page}: {target}{anchor}')
        self.assertIn('usr/share/styled/proto/styled/v1/WIRE.md', self.paths('cpp'))
        operating = finish_packages.read(self.folder, 'daemon', 'usr/share/doc/styled/OPERATING.md')
        self.assertIn('](MODEL-CARD.md#', operating)
        self.assertIn('(`model/library/README.md` of the sources)', operating)

    def test_what_is_compiled_in_is_named(self):
        for library in ('libeigen3-dev', 'nlohmann-json3-dev', 'libcli11-dev', 'cppzmq-dev'):
            self.assertRegex(self.programs, rf'(?m)^={{80}}\n{library} \S+\n={{80}}\n\n(?=\S)')

    def test_the_page_without_a_notice_or_a_licence_is_refused(self):
        if PAGE not in self.paths('web'):
            self.skipTest('no page: npm is missing, or could not fetch')
        notices = finish_packages.read(self.folder, 'web', PAGE)
        built = {of['name']: (of['version'], of['licence'])
                 for of in json.loads(finish_packages.read(BUILD, 'npm/web/page/packages.json'))}
        locked = finish_packages.locked_packages(finish_packages.read(ROOT, 'clients/package-lock.json'))
        self.assertEqual(locked, built)
        licences = {'Apache-2.0', 'BSD-3-Clause', 'MIT', 'MPL-2.0'}
        self.assertEqual([], finish_packages.page_complaints(notices, built, licences))
        for name in built:
            parts = re.split(r'(?m)(?=^={80}\n\S+ \S+, )', notices)
            left = ''.join(part for part in parts if not re.match(rf'={{80}}\n{re.escape(name)} ', part))
            self.assertEqual(1, len(finish_packages.page_complaints(left, built, licences)), name)
        self.assertEqual(['MPL-2.0: is of the page, and not in the copyright file'],
                         finish_packages.page_complaints(notices, built, licences - {'MPL-2.0'}))


if __name__ == '__main__':
    unittest.main()
