"""Every file that names this version names the same one, and the changelog begins with it."""
import json
import os
import re
import unittest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..')
# Documents that name the version in passing, and the words before it.
NAMED = [('clients/js/README.md', 'styled-client-'), ('clients/python/README.md', 'styled_mocap-'),
         ('clients/web/WIRE.md', '"styleweb": "')]


def read(path):
    with open(os.path.join(ROOT, path), encoding='utf-8') as text:
        return text.read()


def releases(changelog):
    """[(version, day, [change])] of systemd/CHANGELOG.md, the newest first."""
    found = []
    for part in re.split(r'^## ', changelog, flags=re.MULTILINE)[1:]:
        version, day = re.match(r'(\d+\.\d+\.\d+) \((\d{4}-\d\d-\d\d)\)\n', part).groups()
        found.append((version, day, re.findall(r'^- .*(?:\n  .*)*', part, re.MULTILINE)))
    return found


class VersionsTest(unittest.TestCase):
    def setUp(self):
        self.version, = re.findall(r'^project\(styled VERSION (\S+)', read('CMakeLists.txt'), re.MULTILINE)

    def test_the_packages_of_npm_and_unity_have_it(self):
        lock = json.loads(read('clients/package-lock.json'))['packages']
        page = json.loads(read('clients/web/page/package.json'))
        for of in (lock['js'], lock['web/page'], page, json.loads(read('clients/js/package.json')),
                   json.loads(read('clients/unity/package.json'))):
            self.assertEqual(self.version, of['version'], of['name'])
        self.assertEqual(self.version, lock['web/page']['dependencies']['styled-client'])
        self.assertEqual(self.version, page['dependencies']['styled-client'])

    def test_documents_name_it(self):
        for path, before in NAMED:
            self.assertEqual({self.version}, set(re.findall(re.escape(before) + r'(\d+\.\d+\.\d+)', read(path))), path)

    def test_the_changelog_begins_with_it_and_goes_back_in_time(self):
        found = releases(read('systemd/CHANGELOG.md'))
        self.assertEqual(self.version, found[0][0])
        order = [(tuple(map(int, version.split('.'))), day) for version, day, _ in found]
        self.assertEqual(sorted(order, reverse=True), order)
        for version, _, changes in found:
            self.assertTrue(changes, f'{version} names no change')

    def test_a_changelog_is_read_with_lines_that_go_on(self):
        self.assertEqual([('1.2.3', '2026-01-02', ['- one\n  more', '- two'])],
                         releases('# Changes\n\n## 1.2.3 (2026-01-02)\n\n- one\n  more\n- two\n'))


if __name__ == '__main__':
    unittest.main()
