"""The C# client and its example against a control socket with prepared answers."""
import glob
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

from fake_daemon import FakeDaemon
from test_unseen import answer

HERE = os.path.dirname(os.path.abspath(__file__))
CLIENT = os.path.join(HERE, '../../../clients/unity')
NOBODY = 'ipc:///tmp/styled-nobody'


def refusing(request):
    reply = answer(request)
    if request.performer == 'stage.refused':
        reply.code, reply.reason = 3, 'unknown style'
        del reply.applied[:]
    elif request.performer == '*':
        reply.applied.add(performer='stage.bob', refused='stage.bob: too strong')
    return reply


class CsharpTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix='styled-csharp-')
        cls.addClassCleanup(folder.cleanup)
        cls.programs = {}
        for name, source in (('heads', CLIENT + '/Console~/Heads.cs'), ('steer', HERE + '/Steer.cs')):
            cls.programs[name] = f'{folder.name}/{name}.exe'
            subprocess.run(['mcs', '-nologo', '-langversion:7.2', '-warnaserror', f'-out:{cls.programs[name]}',
                            source, *glob.glob(CLIENT + '/Runtime/*.cs')], check=True)

    def run_program(self, name, *arguments):
        done = subprocess.run(['mono', self.programs[name], *arguments], capture_output=True, text=True,
                              timeout=60)
        return done.returncode, done.stdout, done.stderr

    def test_whom_nobody_will_see_is_told(self):
        with FakeDaemon(refusing) as daemon:
            self.assertEqual(self.run_program('steer', daemon.endpoint, 'stage.ann', 'stage.anna', '*'), (
                0, 'stage.ann absent=stage.ann weak=\nstage.anna absent= weak=stage.anna\n'
                'stage.anna,stage.old absent=stage.old weak=stage.anna kept=stage.bob (stage.bob: too strong)\n'
                'unknown style absent=0\n', ''))

    def test_the_example_says_what_is_wrong_in_one_line_above_its_usage(self):
        usage = 'usage: heads [PUBLISHER [CONTROL [STYLE [FRAMES]]]]'
        for arguments, text in ((['nonsense', NOBODY], "cannot connect to 'nonsense', expected e.g. tcp://"),
                                ([NOBODY, 'tcp://a'], "cannot connect to 'tcp://a', expected e.g. tcp://"),
                                ([NOBODY, NOBODY, 'old', 'many'], "FRAMES is 'many', expected a whole number"),
                                ([NOBODY, NOBODY, 'old', '-1'], "FRAMES is '-1', expected a whole number"),
                                ([NOBODY, NOBODY, 'old', '1', 'x'], "'x' is one argument too many")):
            code, out, err = self.run_program('heads', *arguments)
            self.assertEqual((code, out, len(err.splitlines())), (2, '', 2), err)
            self.assertTrue(err.startswith('heads: ' + text) and err.endswith(usage + '\n'), err)
        for option in ('--help', '-h'):
            code, out, err = self.run_program('heads', option)
            self.assertEqual((code, err, out.splitlines()[0]), (0, '', usage))


if __name__ == '__main__':
    if not shutil.which('mcs') or not shutil.which('mono'):
        print('skipped, no mcs or mono: apt install mono-mcs mono-runtime')
        sys.exit(77)
    unittest.main()
