"""A blocking subscriber; styled.aio has one for asyncio."""

import itertools
import time
from typing import Iterable, Iterator, List, Optional, Union

import zmq

from styled import checks
from styled.closing import Closer
from styled.curve import Curve
from styled.doubts import LOOK_S
from styled.inbox import Counters, Inbox, Kind, Newest, Stream, Update, Wanted
from styled.unseen import line_of_caller, warn_at

DEFAULT_PUBLISHER = 'tcp://127.0.0.1:7001'
MAX_MESSAGE_BYTES = 1 << 20  # a body of 1024 long names fits
MAX_DRAIN = 10_000           # limit of messages per receive_latest
STALE_S = 0.05               # later than usual by this: newer frames are still queued
RENEW_S = 2.0                # if no connection is live for this long, one connects again
LONGEST_CATCH_UP_S = 0.5     # a connection that was lost meanwhile is restored by then
_monitors = itertools.count()


def open_socket(socket: zmq.Socket, inbox: Inbox, endpoints: Union[str, Iterable[str]],
                queue_messages: int, curve: Optional[Curve], links: 'Links') -> None:
    """Sets up and connects a SUB socket of pyzmq, blocking or asyncio."""
    endpoints = checks.endpoints(endpoints, DEFAULT_PUBLISHER)
    curve = checks.curve(curve)
    inbox.several = len(endpoints) > 1
    links.endpoints = list(endpoints)
    socket.linger = 0
    socket.rcvhwm = checks.messages('queue_messages', queue_messages)
    socket.maxmsgsize = MAX_MESSAGE_BYTES
    socket.ipv6 = any('[' in endpoint for endpoint in endpoints)  # otherwise such an address is never reached
    socket.reconnect_ivl = 100
    socket.reconnect_ivl_max = 1000
    socket.handshake_ivl = 1000
    socket.heartbeat_ivl = 1000  # also detects an unplugged cable
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


def end_of(timeout: Optional[float]) -> Optional[float]:
    seconds = checks.seconds_or_none('timeout', timeout)
    return None if seconds is None else time.monotonic() + seconds


class Links:
    """The connections of one SUB socket to its endpoints: counts the live ones, and reconnects the
    dead ones. libzmq reconnects by itself to an address where no program listens, but gives up a peer
    that breaks the protocol, although a daemon may start there later."""

    def __init__(self, context: zmq.Context, socket: zmq.Socket):
        address = f'inproc://styled-monitor-{next(_monitors)}'
        socket.monitor(address, zmq.EVENT_HANDSHAKE_SUCCEEDED | zmq.EVENT_DISCONNECTED)
        self._monitor = zmq.Context.shadow(context.underlying).socket(zmq.PAIR)
        self._monitor.linger = 0
        self._monitor.connect(address)
        self._subscriber = socket
        self._live: List[str] = []  # addresses as libzmq writes them
        self._renewed_s = self._looked_s = time.monotonic()
        self.endpoints: List[str] = []

    @property
    def socket(self) -> zmq.Socket:
        return self._monitor

    def count(self) -> int:
        while self._monitor.poll(0):
            event, address = self._monitor.recv_multipart()[:2]
            place = address.decode(errors='replace')
            if int.from_bytes(event[:2], 'little') == zmq.EVENT_HANDSHAKE_SUCCEEDED:
                self._live.append(place)
            elif place in self._live:  # a failed handshake also ends in a disconnection
                self._live.remove(place)
        return len(self._live)

    def renew_dead(self) -> None:
        """Call while nothing arrives; it checks twice a second. With several endpoints the live ones stay as
        they are. Endpoints with host names, which libzmq's events do not identify, are only reconnected
        while none is live."""
        now_s = time.monotonic()
        if now_s - self._looked_s < LOOK_S:
            return
        self._looked_s = now_s
        if self.count() >= len(self.endpoints):
            self._renewed_s = now_s
        if now_s - self._renewed_s < RENEW_S:
            return
        self._renewed_s = now_s
        for endpoint in self.endpoints:
            if endpoint in self._live or (self._live and _has_host_name(endpoint)):
                continue
            try:
                self._subscriber.disconnect(endpoint)
            except zmq.ZMQError:
                pass  # libzmq has already dropped it
            self._subscriber.connect(endpoint)


def _has_host_name(endpoint: str) -> bool:
    host = endpoint.removeprefix('tcp://')
    return host != endpoint and not host.startswith('[') and bool(host.strip('0123456789.:'))


def slice_s(end: Optional[float]) -> float:
    """The time until the next check for missing frames."""
    return LOOK_S if end is None else min(LOOK_S, max(0.0, end - time.monotonic()))


def tell_doubts(inbox: Inbox, links: Links) -> None:
    for told in inbox.doubts.look(links.count() > 0):
        warn_at(told, line_of_caller())


class Subscriber:
    """Subscribes to one or several daemons. Connects in the background, and reconnects by itself while
    it is being read. Frames are delivered as published, in order per stream; gaps are counted. One
    thread at a time; a context manager.

    endpoints       of publishers, one or several (the ids of their performers must differ)
    performer       SOURCE.NAME; '' = all, including those that appear later
    streams         one or several of 'rig', 'canonical', 'source' (styled.RIG, CANONICAL, SOURCE),
                    or the name of an [[output]] of the daemon; None: bodies and statistics only
    statistics      also subscribe to the daemon's counters, once per second
    bundled         all performers' frames of a cycle of the daemon in one message: for clients that
                    show tens of performers or more; without `performer`
    queue_messages  queue of this process; when it is full, the newest are dropped
    curve           styled.Curve, for daemons that require keys

    Raises ValueError for an invalid argument, TypeError for one of another type. A missing daemon is
    not an error. A performer or an [[output]] that a daemon does not have is waited for; a warning
    (styled.AbsentPerformer, AbsentOutput) reports once that nothing arrives. """

    def __init__(self, endpoints: Union[str, Iterable[str]] = DEFAULT_PUBLISHER, *,
                 performer: str = '',
                 streams: Union[Wanted, Iterable[Wanted], None] = (Stream.RIG,),
                 statistics: bool = False, bundled: bool = False, queue_messages: int = 1000,
                 curve: Optional[Curve] = None):
        self._inbox = Inbox(performer, streams, statistics, bundled)
        context = zmq.Context()
        self._close = Closer(self, context)
        self._socket = context.socket(zmq.SUB)
        self._close.sockets.append(self._socket)
        self._links = Links(context, self._socket)
        self._close.sockets.append(self._links.socket)
        try:
            open_socket(self._socket, self._inbox, endpoints, queue_messages, curve, self._links)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        self._close()

    def __enter__(self) -> 'Subscriber':
        return self

    def __exit__(self, *_) -> None:
        self.close()

    @property
    def counters(self) -> Counters:
        return self._inbox.counters

    def connected(self) -> int:
        """Number of endpoints with a live connection. It does not show whether frames arrive: a daemon
        without a rig publishes none."""
        return self._links.count()

    def performers(self) -> List[str]:
        """Ids of the performers whose bodies were seen, sorted. With `performer`: only that one."""
        return self._inbox.performers()

    def receive(self, timeout: Optional[float] = None) -> Optional[Update]:
        """Every-frame mode: the next update, or None if none arrives within `timeout` seconds (None:
        wait forever; 0: only what has already arrived)."""
        end = end_of(timeout)
        while True:
            update = self._read()
            if update is not None:
                return update
            if not self._wait(end):
                return None

    def receive_latest(self, timeout: Optional[float] = None) -> List[Update]:
        """Latest-wins mode, for a renderer: waits up to `timeout` seconds for a first update, then reads
        all waiting messages. Returns the newest frame per performer and stream, every body, and the
        newest statistics. A reader that draws at less than 120 Hz therefore does not lag behind. After
        the process or its network was suspended, seconds of frames are queued: as long as messages
        arrive 50 ms later than usual, this keeps reading, for at most 0.5 s."""
        end = end_of(timeout)
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
                # The sockets on the way may hold more messages than this process. The time limit
                # starts now, since the process may have been suspended before.
                end = end if catching_up else time.monotonic() + LONGEST_CATCH_UP_S
                catching_up = True
            if not self._wait(end):
                break
        return newest.take()

    def frames(self, timeout: Optional[float] = None) -> Iterator[Update]:
        """Yields frames whose body has arrived; ends after `timeout` seconds without one (None: never)."""
        while True:
            update = self.receive(timeout)
            if update is None:
                return
            if update.kind is Kind.FRAME and update.body is not None:
                yield update

    # The next of the updates that have already arrived.
    def _read(self) -> Optional[Update]:
        while True:
            update = self._inbox.next()
            if update is not None:
                return update
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
        while True:
            if self._inbox.doubts.pending() and self._inbox.doubts.due():
                tell_doubts(self._inbox, self._links)
            self._links.renew_dead()
            if self._socket.poll(checks.milliseconds(slice_s(end))):
                return True
            if end is not None and time.monotonic() >= end:
                return False
