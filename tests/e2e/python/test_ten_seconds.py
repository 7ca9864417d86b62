"""The examples of all clients at once, as in the README, with one live daemon: ten seconds of a rig at
120 Hz, every frame in sequence."""
import glob
import os
import re
import shutil
import subprocess
import sys
import unittest

from daemon import BIN, PATIENCE_S, Daemon
from gateway import Gateway

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', '..')
JS = os.path.join(BIN, '..', 'npm', 'js')
FRAMES = 10 * 120


class TenSecondsTest(unittest.TestCase):
    def setUp(self):
        self.daemon = Daemon()
        self.addCleanup(self.daemon.close)
        self.examples = {}

    def start(self, name, *command):
        child = subprocess.Popen([*command, 'elderly', str(FRAMES)], stdout=subprocess.PIPE,
                                 stderr=subprocess.PIPE, text=True)
        self.examples[name] = child
        self.addCleanup(child.kill)

    def test_every_frame_comes(self):
        at = self.daemon.publish, self.daemon.control
        self.start('Python', sys.executable, os.path.join(ROOT, 'clients/python/examples/heads.py'), *at)
        self.start('C++', os.path.join(BIN, 'client_example'), *at)
        client = os.path.join(ROOT, 'clients', 'unity')
        if shutil.which('mcs') and shutil.which('mono'):
            program = os.path.join(self.daemon.folder, 'heads.exe')
            subprocess.run(['mcs', '-nologo', f'-out:{program}', os.path.join(client, 'Console~', 'Heads.cs'),
                            *glob.glob(os.path.join(client, 'Runtime', '*.cs'))], check=True)
            self.start('C#', 'mono', program, *at)
        else:
            print('C#: skipped, no mcs or no mono')
        gateway = None
        if shutil.which('node') and os.path.exists(os.path.join(JS, 'dist')):
            gateway = Gateway(self.daemon)
            self.addCleanup(gateway.close)
            self.start('JavaScript', 'node', os.path.join(JS, 'example.mjs'), gateway.url)
        else:
            print('JavaScript: skipped, no node, or its client was not built')
        self.daemon.simulate()
        for name, child in self.examples.items():
            out, err = child.communicate(timeout=PATIENCE_S)
            self.assertEqual(child.returncode, 0, err)
            # Before that line there may be one that a gateway that has just started knows no daemon
            # yet.
            self.assertRegex(err, r'(?m)^\d+ frames, \d+ missed\n\Z')
            frames, missed = map(int, re.findall(r'\d+', err.splitlines()[-1]))
            passed_over = 0
            if name == 'JavaScript':
                passed_over = int(re.search(r'(?m)^styleweb_superseded_messages_total (\d+)$',
                                            gateway.metrics()).group(1))
            print(f'{name}: {frames} frames, {missed} missed, {passed_over} passed over by the gateway')
            self.assertGreaterEqual(frames, FRAMES)
            # For a browser that does not keep up, the gateway sends the newest frame and counts the
            # others. Only those may be missing.
            self.assertLessEqual(missed, passed_over)
            self.assertRegex(out, r'^rig\.sim -?\d+\.\d\d 1\.\d\d -?\d+\.\d\d m\n')


if __name__ == '__main__':
    unittest.main()
