"""systemd/repository.sh: apt accepts what it makes by its signature alone, and refuses what was changed.

apt runs with folders of its own, so that no root is needed and this machine's apt is left alone."""
import glob
import gzip
import os
import re
import shutil
import subprocess
import tempfile
import unittest

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..'))
SCRIPT = os.path.join(ROOT, 'systemd', 'repository.sh')
CONTROL = """Package: {name}
Version: {version}
Architecture: {architecture}
Maintainer: Test <test@styled.invalid>
Description: a package of this test
{more}"""


def suite():
    """The codename of this Debian, of which a repository's packages are."""
    with open('/etc/os-release', encoding='utf-8') as about:
        return re.search(r'^VERSION_CODENAME=(\S*)$', about.read() + '\nVERSION_CODENAME=bookworm\n', re.MULTILINE).group(1)


def run(*command, **environment):
    return subprocess.run(command, capture_output=True, text=True, check=False,
                          env=dict(os.environ, LC_ALL='C.UTF-8', **environment))


def make_package(folder, name, version, more='', architecture='amd64'):
    unpacked = os.path.join(folder, 'unpacked', name)
    os.makedirs(os.path.join(unpacked, 'DEBIAN'), exist_ok=True)
    with open(os.path.join(unpacked, 'DEBIAN', 'control'), 'w', encoding='utf-8') as control:
        control.write(CONTROL.format(name=name, version=version, more=more, architecture=architecture))
    debs = os.path.join(folder, 'debs')
    os.makedirs(debs, exist_ok=True)
    done = run('dpkg-deb', '--root-owner-group', '-b', unpacked, debs)
    assert done.returncode == 0, done.stderr


class Apt:
    """apt with nothing but one .sources file: no other source, no other key, no installed package."""

    def __init__(self, folder, sources, architecture='amd64'):
        self.folder = folder
        self.architecture = architecture
        for name in ('etc', 'state/lists/partial', 'cache/archives/partial'):
            os.makedirs(os.path.join(folder, name))
        shutil.copy(sources, os.path.join(folder, 'etc', 'styled.sources'))
        with open(os.path.join(folder, 'status'), 'w', encoding='utf-8'):
            pass

    def __call__(self, program, *arguments):
        at = lambda name: os.path.join(self.folder, name)
        options = {'Dir::Etc::sourcelist': at('etc/styled.sources'), 'Dir::Etc::sourceparts': '-',
                   'Dir::Etc::trusted': '-', 'Dir::Etc::trustedparts': '-', 'Dir::Etc::preferencesparts': '-',
                   'Dir::State': at('state'), 'Dir::State::status': at('status'), 'Dir::Cache': at('cache'),
                   'APT::Architecture': self.architecture, 'APT::Architectures': self.architecture, 'APT::Sandbox::User': '',
                   'APT::Update::Error-Mode': 'any', 'APT::Install-Recommends': 'true', 'Debug::NoLocking': 'true'}
        return run(program, *(word for key, value in options.items() for word in ('-o', f'{key}={value}')), *arguments)

    def update(self):
        return self('apt-get', 'update')


@unittest.skipUnless(all(map(shutil.which, ('apt-get', 'apt-ftparchive', 'gpg', 'dpkg-deb'))),
                     'needs apt, apt-utils, gnupg and dpkg')
class RepositoryTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix='styled-apt-')
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        os.chmod(self.folder, 0o755)
        self.repository = os.path.join(self.folder, 'apt')
        make_package(self.folder, 'styled', '1.0', 'Recommends: styled-tools (= 1.0)\n')
        make_package(self.folder, 'styled-tools', '1.0')
        self.apts = 0

    def make(self, *options, **environment):
        return run(SCRIPT, *options, os.path.join(self.folder, 'debs'), self.repository, **environment)

    def made(self, *options, **environment):
        done = self.make(*options, **environment)
        self.assertEqual((0, ''), (done.returncode, done.stderr))
        return done.stdout

    def apt(self, sources='styled.sources', architecture='amd64'):
        self.apts += 1
        return Apt(os.path.join(self.folder, f'system-{self.apts}'), os.path.join(self.repository, sources), architecture)

    def file(self, *path):
        return os.path.join(self.repository, 'dists', suite(), *path)

    def refused(self, reason):
        done = self.apt().update()
        self.assertEqual(100, done.returncode, done.stdout + done.stderr)
        self.assertRegex(done.stderr, reason)

    def change(self, path, old, new):
        with open(path, encoding='utf-8') as file:
            text = file.read()
        self.assertIn(old, text)
        with open(path, 'w', encoding='utf-8') as file:
            file.write(text.replace(old, new))

    def test_apt_installs_from_it(self):
        said = self.made()
        self.assertRegex(said, r'/apt: 2 packages, signed by [0-9A-F]{40}\n')
        apt = self.apt()
        done = apt.update()
        self.assertEqual((0, ''), (done.returncode, done.stderr))
        done = apt('apt-get', 'install', '--simulate', 'styled')
        self.assertEqual(0, done.returncode, done.stderr)
        self.assertIn('Inst styled (1.0 Styled:%s [amd64])' % suite(), done.stdout)
        self.assertIn('Inst styled-tools (1.0 Styled:%s [amd64])' % suite(), done.stdout)
        self.assertNotIn('cannot be authenticated', done.stdout + done.stderr)

    def test_what_is_not_free_can_be_left_out(self):
        make_package(self.folder, 'styled-weights-nc', '1.0', 'Section: non-free/video\n')
        self.made()
        apt = self.apt()
        self.assertEqual(0, apt.update().returncode)
        self.assertEqual(0, apt('apt-get', 'install', '--simulate', 'styled-weights-nc').returncode)
        self.change(os.path.join(self.repository, 'styled.sources'), 'Components: main non-free', 'Components: main')
        apt = self.apt()
        done = apt.update()
        self.assertEqual((0, ''), (done.returncode, done.stderr))
        self.assertEqual(0, apt('apt-get', 'install', '--simulate', 'styled').returncode)
        self.assertEqual(100, apt('apt-get', 'install', '--simulate', 'styled-weights-nc').returncode)

    def test_two_debians_and_two_architectures_in_one(self):
        shutil.rmtree(os.path.join(self.folder, 'debs'))
        for system in ('deb12', 'deb13'):
            for architecture in ('amd64', 'arm64'):
                make_package(self.folder, 'styled', f'2.0+{system}', architecture=architecture)
            make_package(self.folder, 'styled-weights-nc', f'2.0+{system}', 'Section: non-free/video\n', 'all')
        said = self.made()
        self.assertIn('/apt: 6 packages, signed by', said)
        self.assertIn('a client copies styled-bookworm.sources styled-trixie.sources of', said)
        for codename, version in (('bookworm', '2.0+deb12'), ('trixie', '2.0+deb13')):
            for architecture in ('amd64', 'arm64'):
                apt = self.apt(f'styled-{codename}.sources', architecture)
                done = apt.update()
                self.assertEqual((0, ''), (done.returncode, done.stderr))
                done = apt('apt-get', 'install', '--simulate', 'styled', 'styled-weights-nc')
                self.assertIn(f'Inst styled ({version} Styled:{codename} [{architecture}])', done.stdout)
                self.assertIn(f'Inst styled-weights-nc ({version} Styled:{codename} [all])', done.stdout)
        # A system that was upgraded takes the packages of its new Debian.
        with open(os.path.join(apt.folder, 'status'), 'w', encoding='utf-8') as status:
            status.write('Package: styled\nStatus: install ok installed\nVersion: 2.0+deb12\nArchitecture: arm64\n'
                         'Maintainer: Test <test@styled.invalid>\nDescription: a package of this test\n')
        self.assertIn('Inst styled [2.0+deb12] (2.0+deb13 ', apt('apt-get', 'upgrade', '--simulate').stdout)

    def test_by_the_detached_signature_too(self):
        self.made()
        os.remove(self.file('InRelease'))
        self.assertEqual(0, self.apt().update().returncode)
        os.remove(self.file('Release.gpg'))
        self.refused('is not signed')

    def test_a_client_without_the_key_refuses_it(self):
        self.made()
        self.change(os.path.join(self.repository, 'styled.sources'), 'Signed-By:', 'X-Nothing:')
        self.refused('NO_PUBKEY|is not signed')

    def test_changed_lists_are_refused(self):
        self.made()
        packages = self.file('main', 'binary-amd64', 'Packages')
        self.change(packages, 'Version: 1.0', 'Version: 6.6')
        with open(packages, 'rb') as plain, gzip.open(packages + '.gz', 'wb') as packed:
            packed.write(plain.read())
        self.refused('unexpected size|Hash Sum mismatch')

    def test_a_changed_release_is_refused(self):
        self.made()
        self.change(self.file('InRelease'), 'Label: Styled', 'Label: Others')
        self.refused('BADSIG|manipulated')  # gpgv, and sqv of Debian 13

    def test_another_signer_is_refused_by_a_client_of_the_first(self):
        first = re.search('[0-9A-F]{40}', self.made()).group()
        shutil.copy(os.path.join(self.repository, 'styled.sources'), os.path.join(self.folder, 'first'))
        shutil.rmtree(self.repository + '-key')
        self.assertNotIn(first, self.made())
        shutil.copy(os.path.join(self.folder, 'first'), os.path.join(self.repository, 'styled.sources'))
        self.refused('NO_PUBKEY|Missing key')

    def test_a_changed_package_is_refused(self):
        self.made()
        apt = self.apt()
        self.assertEqual(0, apt.update().returncode)
        deb, = glob.glob(os.path.join(self.repository, 'pool', suite(), 'main', 'styled_*.deb'))
        with open(deb, 'r+b') as file:
            file.seek(-1, os.SEEK_END)
            last = file.read(1)
            file.seek(-1, os.SEEK_END)
            file.write(bytes([last[0] ^ 1]))
        done = apt('apt-get', 'install', '--yes', '--download-only', 'styled')
        self.assertEqual(100, done.returncode, done.stdout + done.stderr)
        self.assertIn('Hash Sum mismatch', done.stderr)

    def test_an_upgrade_has_the_same_key(self):
        first = re.search('[0-9A-F]{40}', self.made()).group()
        apt = self.apt()
        self.assertEqual(0, apt.update().returncode)
        shutil.rmtree(os.path.join(self.folder, 'debs'))
        make_package(self.folder, 'styled', '2.0')
        self.assertIn(first, self.made())
        done = apt.update()
        self.assertEqual((0, ''), (done.returncode, done.stderr))
        self.assertIn('styled (2.0 ', apt('apt-get', 'install', '--simulate', 'styled').stdout)

    def test_a_package_of_any_name_is_listed_and_one_that_is_none_is_refused(self):
        debs = os.path.join(self.folder, 'debs')
        os.rename(glob.glob(os.path.join(debs, 'styled_*.deb'))[0], os.path.join(debs, 'n\u00e4 me.deb'))
        self.assertRegex(self.made(), r'/apt: 2 packages, signed by')
        apt = self.apt()
        self.assertEqual(0, apt.update().returncode)
        self.assertIn('Inst styled (1.0 ', apt('apt-get', 'install', '--simulate', 'styled').stdout)
        before = os.stat(self.file('InRelease')).st_mtime_ns
        with open(os.path.join(debs, 'broken.deb'), 'w', encoding='utf-8') as broken:
            broken.write('no package')
        done = self.make()
        self.assertEqual((1, ''), (done.returncode, done.stdout))
        self.assertIn('broken.deb: is not a package', done.stderr)
        self.assertEqual(before, os.stat(self.file('InRelease')).st_mtime_ns)

    def test_a_key_of_ones_own_and_a_url(self):
        ring = os.path.join(self.folder, 'ring')
        os.mkdir(ring, 0o700)
        self.addCleanup(run, 'gpgconf', '--kill', 'all', GNUPGHOME=ring)
        done = run('gpg', '--batch', '--passphrase', '', '--quick-generate-key', 'show@styled.invalid', 'rsa3072',
                   'sign', 'never', GNUPGHOME=ring)
        self.assertEqual(0, done.returncode, done.stderr)
        self.made('--key', 'show@styled.invalid', GNUPGHOME=ring)
        self.assertEqual(0, self.apt().update().returncode)
        self.assertFalse(os.path.exists(self.repository + '-key'))
        self.made('--key', 'show@styled.invalid', '--url', 'https://stage.invalid/apt', GNUPGHOME=ring)
        with open(os.path.join(self.repository, 'styled.sources'), encoding='utf-8') as sources:
            self.assertIn('\nURIs: https://stage.invalid/apt\n', sources.read())

    def test_what_cannot_be_is_refused_and_leaves_the_old_one(self):
        self.made()
        before = os.stat(self.file('InRelease')).st_mtime_ns
        for options, code, reason in ((('--key', 'nobody@styled.invalid'), 1, 'expected a secret key'),
                                      (('--key', ''), 2, 'systemd/repository.sh'),
                                      (('--url', 'http://x y'), 1, 'without spaces'), (('--quick',), 2, 'systemd/repository.sh')):
            done = self.make(*options)
            self.assertEqual((code, ''), (done.returncode, done.stdout))
            self.assertIn(reason, done.stderr)
        done = run(SCRIPT, self.repository, self.repository)
        self.assertEqual(1, done.returncode)
        self.assertIn('expected .deb files, found none', done.stderr)
        self.assertEqual(before, os.stat(self.file('InRelease')).st_mtime_ns)
        self.assertEqual([], glob.glob(self.repository + '.new-*'))
        done = run(SCRIPT, os.path.join(self.folder, 'debs'), self.folder)
        self.assertEqual(1, done.returncode)
        self.assertIn('is not an apt repository', done.stderr)


if __name__ == '__main__':
    unittest.main()
