"""The files of `cmake --install` suffice for builds outside this tree: one with CMake, one with
pkg-config; both run against the live daemon."""
import os
import shutil
import subprocess
import tempfile
import unittest

from daemon import PATIENCE_S, Daemon

CMAKE, CXX = os.environ['CMAKE'], os.environ['CXX']


class PackageTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix='styled-package-')
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.prefix = os.path.join(cls.folder, 'prefix')
        cls.run_in('.', CMAKE, '--install', os.environ['STYLED_BUILD'], '--component', 'cpp',
                   '--prefix', cls.prefix)
        cls.example = cls.find('example.cpp')

    @classmethod
    def run_in(cls, folder, *command, **environment):
        done = subprocess.run(command, cwd=os.path.join(cls.folder, folder), capture_output=True, text=True,
                              env=dict(os.environ, **environment))
        if done.returncode != 0:
            raise AssertionError(f'{" ".join(command)}\n{done.stdout}\n{done.stderr}')
        return done.stdout

    @classmethod
    def find(cls, name):
        """The installed file with this name; there must be exactly one."""
        found = [os.path.join(folder, name) for folder, _, files in os.walk(cls.prefix) if name in files]
        assert len(found) == 1, (name, found)
        return found[0]

    def package_flags(self, *what):
        path = os.path.dirname(self.find('styled.pc'))
        return self.run_in('.', 'pkg-config', *what, 'styled', PKG_CONFIG_PATH=path).split()

    def expect_to_see_heads(self, program):
        daemon = Daemon()
        self.addCleanup(daemon.close)
        daemon.simulate()
        child = subprocess.Popen([program, daemon.publish, daemon.control, 'old'],
                                 stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        lines = [child.stdout.readline() for _ in range(100)]
        child.kill()
        errors = child.communicate(timeout=PATIENCE_S)[1]
        self.assertEqual(errors, '')
        for line in lines:
            self.assertRegex(line, r'^rig\.sim -?\d+\.\d\d 1\.\d\d -?\d+\.\d\d m\n$')

    def test_a_cmake_project_finds_it(self):
        project = os.path.join(self.folder, 'project')
        shutil.copytree(os.path.dirname(self.example), project)
        self.assertEqual(sorted(os.listdir(project)), ['CMakeLists.txt', 'example.cpp'])
        self.run_in('project', CMAKE, '-G', 'Ninja', '-S', '.', '-B', 'build', f'-DCMAKE_PREFIX_PATH={self.prefix}',
                    f'-DCMAKE_CXX_COMPILER={CXX}')
        self.run_in('project', CMAKE, '--build', 'build')
        self.expect_to_see_heads(os.path.join(project, 'build', 'example'))

    def test_pkg_config_finds_it(self):
        self.run_in('.', CXX, '-std=c++20', self.example, '-o', 'by-pkg-config',
                    *self.package_flags('--cflags', '--libs'))
        self.expect_to_see_heads(os.path.join(self.folder, 'by-pkg-config'))

    def test_no_header_includes_from_this_tree_and_all_compile(self):
        include = os.path.join(self.prefix, 'include')
        headers = []
        for folder, _, files in os.walk(include):
            for name in files:
                header = os.path.join(folder, name)
                with open(header) as text:
                    includes = [line for line in text if line.startswith('#include "')]
                self.assertFalse([i for i in includes if 'google' not in i], header)
                headers.append(os.path.relpath(header, include))
        self.assertEqual(len(headers), 15)
        all_of_them = os.path.join(self.folder, 'all.cpp')
        with open(all_of_them, 'w') as out:
            out.writelines(f'#include <{header}>\n' for header in headers)
        self.run_in('.', CXX, '-std=c++20', '-fsyntax-only', all_of_them,
                    *self.package_flags('--cflags'))


if __name__ == '__main__':
    unittest.main()
