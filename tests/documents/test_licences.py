"""Copyright file, FILE.license, metadata and manifest of each weights file agree.

A company reads it to learn which weights it may use."""
import json
import os
import re
import struct
import unittest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..')
# The terms of a folder's training data, as the copyright file must state them.
CREDITS = {
    'bandai': 'Bandai Namco Research Inc.',
    '100style': 'Ian Mason',
    'cmu': 'Carnegie Mellon University',
    'idle': 'RSAIT',
    'animated-drawings': 'Meta Platforms, Inc.',
    'mocopi': 'Sony Group Corporation',
    'accad': 'The Ohio State University',
}
MANIFESTS = {'v2': 'v2.toml', 'open': 'open.toml', 'graph': 'bandai-2.toml', 'st-gcn': 'bandai-2.toml'}


def read(*path):
    with open(os.path.join(ROOT, *path), encoding='utf-8') as text:
        return text.read()


def licence_of(weights):
    """The licence that a file of weights names, in the short form of Debian."""
    with open(os.path.join(ROOT, 'model', 'weights', weights + '.safetensors'), 'rb') as data:
        size, = struct.unpack('<Q', data.read(8))
        header = json.loads(data.read(size))
    licence = json.loads(header['__metadata__']['styled'])['licence']
    return licence.split(';')[0].strip().replace(' ', '-')


def stanza_of(copyright, weights):
    """The stanza of a file of weights: {field: text}."""
    for stanza in copyright.split('\n\n'):
        fields = dict(re.findall(r'^(\w+): ?(.*(?:\n .*)*)', stanza, re.MULTILINE))
        if f'usr/share/styled/weights/{weights}.safetensors' in fields.get('Files', '').split():
            return fields
    return {}


def beside(weights):
    """FILE.license beside it, in the form of the REUSE specification: (licence, names)."""
    text = read('model', 'weights', weights + '.safetensors.license')
    licence, = re.findall(r'(?m)^SPDX-License-Identifier: (\S+)$', text)
    return licence, '\n'.join(re.findall(r'(?m)^SPDX-FileCopyrightText: (.+)$', text))


def complaints(copyright, weights):
    """The errors of the copyright file about a weights file; []: none."""
    stanza = stanza_of(copyright, weights)
    if not stanza:
        return [f'{weights}: no stanza']
    return wrong_terms(weights, stanza['License'], stanza['Copyright'])


def wrong_terms(weights, licence, names):
    """The errors of a licence and credits of a weights file; []: none."""
    wrong = []
    if licence != licence_of(weights):
        wrong.append(f'{weights}: is {licence_of(weights)}, found {licence}')
    manifest = read('model', 'weights', 'manifests', MANIFESTS[weights]).lower()
    for source, credit in CREDITS.items():
        if source in manifest and credit not in names:
            wrong.append(f'{weights}: {credit} is not credited')
    return wrong


class LicencesTest(unittest.TestCase):
    def setUp(self):
        self.copyright = read('systemd', 'debian', 'copyright')
        self.installed = re.findall(r'model/weights/([\w-]+)\.safetensors', read('CMakeLists.txt'))

    def test_every_installed_file_of_weights_is_told_as_it_is(self):
        self.assertEqual(set(self.installed), set(MANIFESTS))
        for weights in self.installed:
            with self.subTest(weights=weights):
                self.assertEqual([], complaints(self.copyright, weights))

    def test_the_licence_file_beside_it_agrees(self):
        for weights in self.installed:
            with self.subTest(weights=weights):
                self.assertEqual([], wrong_terms(weights, *beside(weights)))

    def test_every_licence_that_is_named_has_its_text(self):
        named = {licence for line in re.findall(r'^License: (.+)$', self.copyright, re.MULTILINE)
                 for licence in line.split(' and ')}
        for licence in named:
            self.assertRegex(self.copyright, rf'(?m)^License: {re.escape(licence)}\n ')

    def test_a_wrong_licence_and_a_missing_credit_are_found(self):
        wrong = self.copyright.replace('License: CC-BY-4.0', 'License: CC-BY-NC-4.0', 1)
        self.assertEqual(1, len(complaints(wrong, 'open')))
        missing = self.copyright.replace(' Ian Mason (The 100STYLE Dataset)\n', '')
        self.assertEqual(1, len(complaints(missing, 'v2')))


if __name__ == '__main__':
    unittest.main()
