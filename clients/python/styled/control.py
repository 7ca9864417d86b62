"""Queries and controls a daemon; styled.aio has the same for asyncio."""

import time
from typing import Optional

import zmq

from styled import checks
from styled.closing import Closer
from styled.commands import Commands, Conversation
from styled.curve import Curve
from styled.errors import NoAnswer
from styled.v1 import control_pb2

DEFAULT_CONTROL = 'tcp://127.0.0.1:7002'
_MAX_REPLY_BYTES = 16 << 20


def open_socket(context: zmq.Context, endpoint: str, curve: Optional[Curve]) -> zmq.Socket:
    """Connects a DEALER socket of pyzmq, blocking or asyncio."""
    socket = context.socket(zmq.DEALER)
    socket.linger = 0
    socket.maxmsgsize = _MAX_REPLY_BYTES
    socket.reconnect_ivl = 50
    socket.handshake_ivl = 1000
    socket.ipv6 = '[' in endpoint  # otherwise such an address is never reached
    try:
        if curve is not None:
            curve.apply(socket)
        socket.connect(endpoint)
    except zmq.ZMQError as error:
        socket.close(0)
        raise ValueError(f"cannot connect to '{endpoint}': {error}; expected e.g. "
                         f'{DEFAULT_CONTROL} or ipc://PATH') from None
    except ValueError:
        socket.close(0)
        raise
    return socket


def no_answer(endpoint: str, timeout: float) -> NoAnswer:
    return NoAnswer(f'no daemon answers at {endpoint} within {timeout:g} s')


class Control(Commands):
    """The control socket of one daemon. Each call blocks until the reply or for `timeout` seconds, and
    raises styled.Refused, NoAnswer or Garbled. `performer` is SOURCE.NAME or '*'. A change returns
    {performer: first sequence at which it is in force}, a styled.Applied. If the change is not visible,
    because no performer of that name is present or the strength is 0, the call warns
    (styled.AbsentPerformer, NoStrength), and so it does about a style without variations and a
    performer that a change for '*' left as they were (NotVaried, NotChanged).
    proto/styled/v1/control.proto defines each field and what is refused. One thread at a time; a
    context manager. """

    def __init__(self, endpoint: str = DEFAULT_CONTROL, *, timeout: float = 2.0,
                 curve: Optional[Curve] = None):
        self._endpoint = checks.endpoint(endpoint, DEFAULT_CONTROL)
        self._timeout = checks.seconds_above_0('timeout', timeout)
        self._curve = checks.curve(curve)
        self._conversation = Conversation()
        self._context = zmq.Context()
        self._close = Closer(self, self._context)
        try:
            self._open()
        except ValueError:
            self.close()
            raise

    def close(self) -> None:
        self._close()

    def __enter__(self) -> 'Control':
        return self

    def __exit__(self, *_) -> None:
        self.close()

    def _do(self, request, result):
        return result(self.call(request))

    def call(self, request: control_pb2.Request) -> control_pb2.Reply:
        """Sends any request; its id is overwritten."""
        # The reply to a take comes after it.
        end = time.monotonic() + self._timeout + request.like.learn_s
        # The envelope of a REQ socket, which every ROUTER accepts.
        message = [b'', self._conversation.encode(request)]
        try:
            self._socket.send_multipart(message, zmq.NOBLOCK)
            while self._socket.poll(checks.milliseconds(end - time.monotonic())):
                payload = self._socket.recv_multipart()[-1]
                reply = self._conversation.decode(payload, self._endpoint)
                if reply is not None:
                    return reply
        except zmq.Again:
            pass
        # A new socket discards replies that were still on their way to the old one.
        self._socket.close(0)
        self._open()
        raise no_answer(self._endpoint, self._timeout)

    def _open(self) -> None:
        self._socket = open_socket(self._context, self._endpoint, self._curve)
        self._close.sockets[:] = [self._socket]
