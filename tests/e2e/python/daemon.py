"""The real daemon and the simulator, as children of a Python test."""
import json
import os
import shutil
import signal
import subprocess
import tempfile
import threading
import time

import zmq

from styled.v1 import control_pb2

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

    def start(self):
        ready = os.path.join(self.folder, 'ready.json')
        if os.path.exists(ready):
            os.remove(ready)
        with open(os.path.join(self.folder, 'stderr.txt'), 'a') as log:
            self._process = subprocess.Popen(self._command + ['--ready-file', ready], stderr=log)
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


class FakeDaemon:
    """A control socket that keeps every request, and answers it with one of these fields of a Reply, by
    the request's command; with none of them: CODE_OK alone."""

    def __init__(self, **fields):
        self.requests = []
        self._fields = fields
        self._context = zmq.Context()
        self._router = self._context.socket(zmq.ROUTER)
        self._router.linger = 0
        self.control = f'tcp://127.0.0.1:{self._router.bind_to_random_port("tcp://127.0.0.1")}'
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._ended.set()
        self._thread.join()
        self._context.destroy()

    def _run(self):
        while not self._ended.is_set():
            if not self._router.poll(20):
                continue
            *envelope, payload = self._router.recv_multipart()
            request = control_pb2.Request.FromString(payload)
            self.requests.append(request)
            command = request.WhichOneof('command')
            fields = {command: self._fields[command]} if command in self._fields else {}
            reply = control_pb2.Reply(id=request.id, **fields)
            self._router.send_multipart([*envelope, reply.SerializeToString()])
