"""The log of a start where nothing is wrong has no warning, says whether settings are kept, and says as a warning what
lasts."""
import re
import shutil
import socket
import tempfile
import threading
import time
import unittest

from daemon import Daemon, wait_for

# Native datagrams (proto/styled/v1/WIRE.md): where the kind is, and a frame's.
KIND, FRAME = 5, 2
# A busy machine adds these to any log.
BUSY = re.compile(r'pipeline\.(over_budget_frames|backlog_dropped|lost|overload_bypassed_frames)|source\.kernel_dropped|'
                  r'keep up|leads from now on')


def log(daemon):
    with open(f'{daemon.folder}/stderr.txt', encoding='utf-8') as text:
        return text.read()


def warnings(daemon):
    return [line for line in log(daemon).splitlines() if re.search(r'^\S+ (warning|error) ', line) and not BUSY.search(line)]


class Pass:
    """Sends a daemon what arrives at a port, without skeletons."""

    def __init__(self, daemon):
        self._in = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._in.bind(('127.0.0.1', 0))
        self.address = '127.0.0.1:%d' % self._in.getsockname()[1]
        host, port = daemon.udp.rsplit(':', 1)
        self._to = (host, int(port))
        self._ended = False
        self._in.settimeout(0.2)
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self):
        while not self._ended:
            try:
                datagram = self._in.recv(65536)
            except socket.timeout:
                continue
            if datagram[KIND] == FRAME:
                self._in.sendto(datagram, self._to)

    def close(self):
        self._ended = True
        self._thread.join()
        self._in.close()


class StartTest(unittest.TestCase):
    def start(self, extra=''):
        daemon = Daemon(extra=extra)
        self.addCleanup(daemon.close)
        return daemon

    def test_a_daemon_that_starts_while_a_rig_sends_has_nothing_to_warn_of(self):
        daemon = self.start()
        daemon.simulate()
        wait_for(lambda: 'rig.sim: body bound' in log(daemon), 'the performer')
        # Again at the same port, in the midst of frames.
        daemon.stop()
        daemon.start('--set', f'source.0.listen={daemon.udp}')
        wait_for(lambda: log(daemon).count('rig.sim: body bound') == 2, 'the performer')
        time.sleep(1.5)
        self.assertIn('info pipeline.before_body: ', log(daemon))
        self.assertEqual([], warnings(daemon))

    def test_frames_that_stay_without_a_skeleton_are_warned_of(self):
        daemon = self.start()
        between = Pass(daemon)
        self.addCleanup(between.close)
        daemon.udp = between.address
        daemon.simulate()
        wait_for(lambda: any('pipeline.before_body: ' in line for line in warnings(daemon)), 'the warning')
        self.assertIn('info pipeline.before_body: ', log(daemon))

    def test_it_says_that_settings_are_not_kept(self):
        sentence = 'no state.dir: '
        self.assertIn(sentence, log(self.start()))
        folder = tempfile.mkdtemp(prefix='styled-test-')
        self.addCleanup(shutil.rmtree, folder)
        self.assertNotIn(sentence, log(self.start(f'[state]\ndir = "{folder}"\n')))

    def test_a_pair_starts_without_a_warning(self):
        folder = tempfile.mkdtemp(prefix='styled-test-')
        self.addCleanup(shutil.rmtree, folder)
        one, other = f'ipc://{folder}/one', f'ipc://{folder}/other'
        pair = [self.start(f'[standby]\naddress = "{own}"\npeer = "{peer}"\nhold_ms = 1000\nfirst = {first}\n')
                for own, peer, first in ((one, other, 'true'), (other, one, 'false'))]
        wait_for(lambda: 'info standby: leads' in log(pair[0]), 'the leader')
        wait_for(lambda: re.search(r'info standby: standby of .*, which leads', log(pair[1])), 'the standby')
        for daemon in pair:
            self.assertEqual([], warnings(daemon))


if __name__ == '__main__':
    unittest.main()
