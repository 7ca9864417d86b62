"""The real daemon and the simulator, as children of a Python test."""
import json
import os
import shutil
import signal
import subprocess
import tempfile
import time

BIN = os.environ['STYLED_BIN']
PATIENCE_S = 60  # for a busy machine


def wait_for(condition, what):
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.01)
    raise AssertionError(f'{what} did not happen within {PATIENCE_S} s')


class Daemon:
    """`styled` with the shipped weights. Its publisher and control socket keep their paths when it is
    restarted. One source, `rig`, of type `source`; `extra` is TOML for the configuration."""

    def __init__(self, source='udp', extra=''):
        self.folder = tempfile.mkdtemp(prefix='styled-test-')
        self.publish = f'ipc://{self.folder}/publish'
        self.control = f'ipc://{self.folder}/control'
        config = os.path.join(self.folder, 'styled.toml')
        with open(config, 'w') as out:
            out.write(f'[[source]]\nname = "rig"\ntype = "{source}"\nlisten = "127.0.0.1:0"\n'
                      f'[publish]\naddress = "{self.publish}"\nhigh_water_mark = 5000\n'
                      f'[control]\naddress = "{self.control}"\n'
                      '[realtime]\nlock_memory = false\n'
                      '[performers]\nbacklog_ms = 10000\nstale_ms = 3000\n' + extra)
        self._command = [os.path.join(BIN, 'styled'), '--config', config]
        self._children = []
        self.start()

    def start(self, *options):
        ready = os.path.join(self.folder, 'ready.json')
        if os.path.exists(ready):
            os.remove(ready)
        with open(os.path.join(self.folder, 'stderr.txt'), 'a') as log:
            self._process = subprocess.Popen(self._command + ['--ready-file', ready, *options], stderr=log)
        wait_for(lambda: os.path.exists(ready) or self._process.poll() is not None, 'the start')
        if self._process.poll() is not None:
            with open(os.path.join(self.folder, 'stderr.txt')) as log:
                raise AssertionError(log.read())
        with open(ready) as text:
            self.udp = json.load(text)['sources'][0]['listen']

    def stop(self):
        self._process.send_signal(signal.SIGTERM)
        self._process.wait(PATIENCE_S)

    def simulate(self, *options, script='walk:5'):
        """A performer rig.sim that walks at 120 Hz; without a script, `options` decide."""
        motion = ['--script', script] if script else []
        child = subprocess.Popen([os.path.join(BIN, 'stylesim'), '--to', f'udp://{self.udp}',
                                  *motion, *options], stdout=subprocess.DEVNULL)
        self._children.append(child)
        return child

    def close(self):
        for child in self._children + [self._process]:
            if child.poll() is None:
                child.kill()
            child.wait()
        shutil.rmtree(self.folder)
