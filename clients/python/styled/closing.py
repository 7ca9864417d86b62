"""Closes sockets in the order in which ZeroMQ can end, even without a call of close()."""

import weakref
from typing import List

import zmq


def _end(context: zmq.Context, sockets: List[zmq.Socket]) -> None:
    for socket in sockets:
        socket.close(0)
    context.term()


class Closer:
    """Owns a context and the sockets in `sockets`, which may be exchanged. Calling it closes them, once.
    When `owner` is dropped, they are closed, too. If the garbage collector ended the context before its
    sockets, it would wait forever. The end of the process closes nothing, since another thread may
    still read."""

    def __init__(self, owner: object, context: zmq.Context):
        self.sockets: List[zmq.Socket] = []
        self._end = weakref.finalize(owner, _end, context, self.sockets)
        self._end.atexit = False

    def __call__(self) -> None:
        self._end()
