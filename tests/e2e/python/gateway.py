"""styleweb in front of a daemon, as a child of a Python test."""
import json
import os
import subprocess
import urllib.request

from daemon import BIN, PATIENCE_S, wait_for


class Gateway:
    def __init__(self, daemon):
        ready = os.path.join(daemon.folder, 'web.json')
        self._process = subprocess.Popen(
            [os.path.join(BIN, 'styleweb'), '--listen', '127.0.0.1:0', '--publish', daemon.publish,
             '--control', daemon.control, '--ready-file', ready], stdout=subprocess.DEVNULL)
        try:
            wait_for(lambda: os.path.exists(ready), 'the gateway')
        except AssertionError:
            self.close()
            raise
        with open(ready) as text:
            self.url = 'http://' + json.load(text)['listen'].split('://')[-1]

    def metrics(self):
        """The metrics as Prometheus would read them."""
        with urllib.request.urlopen(self.url + '/metrics', timeout=PATIENCE_S) as reply:
            return reply.read().decode()

    def close(self):
        self._process.kill()
        self._process.wait()
