"""Prometheus's own promtool accepts what styleweb serves at /metrics, with a performer and without a
daemon."""
import re
import shutil
import subprocess
import sys
import unittest

from daemon import Daemon, wait_for
from gateway import Gateway

SKIPPED = 77


def check(metrics):
    """promtool's exit code and messages."""
    done = subprocess.run(['promtool', 'check', 'metrics'], input=metrics, text=True, capture_output=True)
    return done.returncode, done.stdout + done.stderr


class MetricsTest(unittest.TestCase):
    def setUp(self):
        self.daemon = Daemon()
        self.addCleanup(self.daemon.close)
        self.gateway = Gateway(self.daemon)
        self.addCleanup(self.gateway.close)

    def test_promtool_takes_them(self):
        self.daemon.simulate()
        wait_for(lambda: 'performer="rig.sim"' in self.gateway.metrics(), 'the performer')
        metrics = self.gateway.metrics()
        self.assertEqual(check(metrics), (0, ''))
        print(len(re.findall('(?m)^# TYPE', metrics)), 'metrics,',
              len(re.findall('(?m)^[a-z]', metrics)), 'values')
        self.daemon.stop()
        wait_for(lambda: 'performer="rig.sim"' not in self.gateway.metrics(), 'the end of the daemon')
        self.assertEqual(check(self.gateway.metrics()), (0, ''))

    def test_promtool_would_say_so(self):
        damaged = re.sub('(?m)^# HELP .*\n', '', self.gateway.metrics())
        self.assertNotEqual(check(damaged), (0, ''))


if __name__ == '__main__':
    if shutil.which('promtool') is None:
        print('skipped, no promtool (Debian: prometheus)')
        sys.exit(SKIPPED)
    unittest.main()
