"""A subscriber whose calls block; styled.aio has one for asyncio."""

import itertools
import time
from typing import Iterable, Iterator, List, Optional, Union

import zmq

from styled.curve import Curve
from styled.inbox import Counters, Inbox, Kind, Newest, Stream, Update, Wanted

DEFAULT_PUBLISHER = 'tcp://127.0.0.1:7001'
MAX_MESSAGE_BYTES = 1 << 20  # a body of 1024 long names fits
MAX_DRAIN = 10_000           # messages that one receive_latest reads at most
STALE_S = 0.05               # later than usual by this: not the newest yet
LONGEST_CATCH_UP_S = 0.5     # a connection that was lost meanwhile is back by then
_monitors = itertools.count()


def open_socket(socket: zmq.Socket, inbox: Inbox, endpoints: Union[str, Iterable[str]],
                queue_messages: int, curve: Optional[Curve]) -> None:
    """Sets up a SUB socket of either kind and connects it."""
    endpoints = [endpoints] if isinstance(endpoints, str) else list(endpoints)
    if not endpoints:
        raise ValueError('no endpoint given')
    if queue_messages < 1:
        raise ValueError(f'queue_messages is {queue_messages}, expected 1 or more')
    socket.linger = 0
    socket.rcvhwm = queue_messages
    socket.maxmsgsize = MAX_MESSAGE_BYTES
    socket.reconnect_ivl = 100
    socket.reconnect_ivl_max = 1000
    socket.handshake_ivl = 1000
    socket.heartbeat_ivl = 1000  # a pulled cable is noticed, too
    socket.heartbeat_timeout = 3000
    if curve is not None:
        curve.apply(socket)
    subscribe(socket, inbox.topics())
    for endpoint in endpoints:
        try:
            socket.connect(endpoint)
        except zmq.ZMQError as error:
            raise ValueError(f"cannot connect to '{endpoint}': {error}; expected e.g. "
                             f'{DEFAULT_PUBLISHER} or ipc://PATH') from None


def subscribe(socket: zmq.Socket, topics: List[str]) -> None:
    for topic in topics:
        socket.setsockopt_string(zmq.SUBSCRIBE, topic)


class Links:
    """How many of a socket's endpoints have a live connection."""

    def __init__(self, context: zmq.Context, socket: zmq.Socket):
        address = f'inproc://styled-monitor-{next(_monitors)}'
        socket.monitor(address, zmq.EVENT_HANDSHAKE_SUCCEEDED | zmq.EVENT_DISCONNECTED)
        self._monitor = zmq.Context.shadow(context.underlying).socket(zmq.PAIR)
        self._monitor.linger = 0
        self._monitor.connect(address)
        self._links = 0

    def count(self) -> int:
        while self._monitor.poll(0):
            event = int.from_bytes(self._monitor.recv_multipart()[0][:2], 'little')
            # A handshake that failed ends in a disconnection, too, and was never counted.
            step = 1 if event == zmq.EVENT_HANDSHAKE_SUCCEEDED else -1
            self._links = max(0, self._links + step)
        return self._links

    def close(self) -> None:
        self._monitor.close(0)


class Subscriber:
    """Listens to one or several daemons. Connects in the background and reconnects by itself, for
    as long as it is read from. Frames come as they were published, in order per stream, gaps
    counted. One thread at a time; a context manager.

    endpoints       of publishers, one or several (their performers' ids must differ)
    performer       SOURCE.NAME; '' = all, those that come later too
    streams         what to subscribe to: styled.RIG, CANONICAL, SOURCE, or the name of an
                    [[output]] of the daemon; empty: bodies and statistics only
    statistics      the daemon's counters too, once a second
    queue_messages  waiting in this process before the newest are dropped
    curve           styled.Curve, for daemons that ask for keys

    ValueError where one of them cannot be. That nobody listens there is no error.
    """

    def __init__(self, endpoints: Union[str, Iterable[str]] = DEFAULT_PUBLISHER, *,
                 performer: str = '', streams: Iterable[Wanted] = (Stream.RIG,),
                 statistics: bool = False, queue_messages: int = 1000,
                 curve: Optional[Curve] = None):
        self._inbox = Inbox(performer, streams, statistics)
        self._context = zmq.Context()
        self._socket = self._context.socket(zmq.SUB)
        self._links = Links(self._context, self._socket)
        try:
            open_socket(self._socket, self._inbox, endpoints, queue_messages, curve)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        self._links.close()
        self._socket.close(0)
        self._context.term()

    def __enter__(self) -> 'Subscriber':
        return self

    def __exit__(self, *_) -> None:
        self.close()

    @property
    def counters(self) -> Counters:
        return self._inbox.counters

    def connected(self) -> int:
        """Endpoints with a live connection. It says nothing about frames: a daemon without a rig
        is silent."""
        return self._links.count()

    def performers(self) -> List[str]:
        """Ids whose bodies have been seen, sorted. With a `performer`: only that."""
        return self._inbox.performers()

    def receive(self, timeout: Optional[float] = None) -> Optional[Update]:
        """Every-frame mode: the next update, None where none comes within `timeout` seconds
        (None: wait for ever; 0: only what is here already)."""
        end = None if timeout is None else time.monotonic() + timeout
        while True:
            update = self._read()
            if update is not None:
                return update
            if not self._wait(end):
                return None

    def receive_latest(self, timeout: Optional[float] = None) -> List[Update]:
        """Latest-wins mode, for a renderer: waits up to `timeout` seconds for a first update, then
        reads all that is waiting; the newest frame of each performer and stream, every body, the
        newest statistics. Who draws slower than 120 Hz so never lags behind. Who was stopped, or
        whose network was, finds seconds of frames on the way: while what comes is 50 ms later than
        usual, it reads on, for half a second at most."""
        end = None if timeout is None else time.monotonic() + timeout
        newest = Newest()
        catching_up = False
        for _ in range(MAX_DRAIN):
            update = self._read()
            if update is not None:
                newest.add(update, self._inbox.lag_s)
                continue
            if newest.take():
                if newest.lag_s() <= STALE_S:
                    break
                # Behind what waits here there may be more in the sockets on the way. From now on:
                # the process may have been stopped since it came here.
                end = end if catching_up else time.monotonic() + LONGEST_CATCH_UP_S
                catching_up = True
            if not self._wait(end):
                break
        return newest.take()

    def frames(self, timeout: Optional[float] = None) -> Iterator[Update]:
        """Frames whose body is here, for ever, or until none came for `timeout` seconds."""
        while True:
            update = self.receive(timeout)
            if update is None:
                return
            if update.kind is Kind.FRAME and update.body is not None:
                yield update

    # The next update of those that are here.
    def _read(self) -> Optional[Update]:
        while True:
            try:
                parts = self._socket.recv_multipart(zmq.NOBLOCK)
            except zmq.Again:
                return None
            update = self._inbox.accept(parts)
            if self._inbox.new_topics:
                subscribe(self._socket, self._inbox.new_topics)
                self._inbox.new_topics = []
            if update is not None:
                return update

    def _wait(self, end: Optional[float]) -> bool:
        if end is None:
            return bool(self._socket.poll())
        left_ms = max(0.0, 1000 * (end - time.monotonic()))
        return bool(self._socket.poll(left_ms))
