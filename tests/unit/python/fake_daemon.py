"""A control socket with prepared answers, for tests without a daemon."""
import threading

import zmq

from styled.v1 import control_pb2


class FakeDaemon:
    """Answers each request with what `answer(request)` returns, a Reply without its id; a context
    manager. `requests` are those that came."""

    def __init__(self, answer):
        self.requests = []
        self._answer = answer
        self._context = zmq.Context()
        self._socket = self._context.socket(zmq.ROUTER)
        self._socket.linger = 0
        self.endpoint = f'tcp://127.0.0.1:{self._socket.bind_to_random_port("tcp://127.0.0.1")}'
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._ended.set()
        self._thread.join()
        self._socket.close(0)
        self._context.term()

    def _run(self):
        while not self._ended.is_set():
            if not self._socket.poll(20):
                continue
            *envelope, payload = self._socket.recv_multipart()
            request = control_pb2.Request.FromString(payload)
            self.requests.append(request)
            reply = self._answer(request)
            reply.id = request.id
            self._socket.send_multipart([*envelope, reply.SerializeToString()])
