"""The subscriber and the control client for asyncio: calls that block there are awaited here.

    async with styled.aio.Subscriber() as subscriber, styled.aio.Control() as control:
        await control.set('*', style='old')
        async for update in subscriber.frames():
            ...
"""

import asyncio
import time
from typing import TYPE_CHECKING, Any, AsyncIterator, Iterable, List, Optional, Union

import zmq
import zmq.asyncio

from styled import checks
from styled import control as blocking
from styled import subscriber as listening
from styled.closing import Closer
from styled.commands import Commands, Conversation
from styled.curve import Curve
from styled.inbox import Counters, Inbox, Kind, Newest, Stream, Update, Wanted
from styled.v1 import control_pb2


class Subscriber:
    """Like styled.Subscriber, with the same arguments; for one event loop."""

    def __init__(self, endpoints: Union[str, Iterable[str]] = listening.DEFAULT_PUBLISHER, *,
                 performer: str = '',
                 streams: Union[Wanted, Iterable[Wanted], None] = (Stream.RIG,),
                 statistics: bool = False, bundled: bool = False, queue_messages: int = 1000,
                 curve: Optional[Curve] = None):
        self._inbox = Inbox(performer, streams, statistics, bundled)
        context = zmq.asyncio.Context()
        self._close = Closer(self, context)
        self._socket = context.socket(zmq.SUB)
        self._close.sockets.append(self._socket)
        self._links = listening.Links(context, self._socket)
        self._close.sockets.append(self._links.socket)
        try:
            listening.open_socket(self._socket, self._inbox, endpoints, queue_messages, curve,
                                  self._links)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        self._close()

    async def __aenter__(self) -> 'Subscriber':
        return self

    async def __aexit__(self, *_) -> None:
        self.close()

    @property
    def counters(self) -> Counters:
        return self._inbox.counters

    def connected(self) -> int:
        return self._links.count()

    def performers(self) -> List[str]:
        return self._inbox.performers()

    async def receive(self, timeout: Optional[float] = None) -> Optional[Update]:
        """Every-frame mode: the next update, or None if none arrives within `timeout` seconds."""
        end = listening.end_of(timeout)
        while True:
            update = await self._read()
            if update is not None:
                return update
            if not await self._wait(end):
                return None

    async def receive_latest(self, timeout: Optional[float] = None) -> List[Update]:
        """Latest-wins mode, as styled.Subscriber.receive_latest."""
        end = listening.end_of(timeout)
        newest = Newest()
        catching_up = False
        for _ in range(listening.MAX_DRAIN):
            update = await self._read()
            if update is not None:
                newest.add(update, self._inbox.lag_s)
                continue
            if newest.take():
                if newest.lag_s() <= listening.STALE_S:
                    break
                end = end if catching_up else time.monotonic() + listening.LONGEST_CATCH_UP_S
                catching_up = True
            if not await self._wait(end):
                break
        return newest.take()

    async def frames(self, timeout: Optional[float] = None) -> AsyncIterator[Update]:
        """Yields frames whose body has arrived; ends after `timeout` seconds without one (None: never)."""
        while True:
            update = await self.receive(timeout)
            if update is None:
                return
            if update.kind is Kind.FRAME and update.body is not None:
                yield update

    async def _read(self) -> Optional[Update]:
        while True:
            update = self._inbox.next()
            if update is not None:
                return update
            try:
                parts = await self._socket.recv_multipart(zmq.NOBLOCK)
            except zmq.Again:
                return None
            update = self._inbox.accept(parts)
            if self._inbox.new_topics:
                listening.subscribe(self._socket, self._inbox.new_topics)
                self._inbox.new_topics = []
            if update is not None:
                return update

    async def _wait(self, end: Optional[float]) -> bool:
        while True:
            if self._inbox.doubts.pending() and self._inbox.doubts.due():
                listening.tell_doubts(self._inbox, self._links)
            self._links.renew_dead()
            if await _is_readable(self._socket, listening.slice_s(end)):
                return True
            if end is not None and time.monotonic() >= end:
                return False


if TYPE_CHECKING:
    # A type checker cannot express "the same, awaited", and would use the wrong result type.
    Commands = Any


class Control(Commands):
    """Like styled.Control; await every call. Overlapping calls wait for each other."""

    def __init__(self, endpoint: str = blocking.DEFAULT_CONTROL, *, timeout: float = 2.0,
                 curve: Optional[Curve] = None):
        self._endpoint = checks.endpoint(endpoint, blocking.DEFAULT_CONTROL)
        self._timeout = checks.seconds_above_0('timeout', timeout)
        self._curve = checks.curve(curve)
        self._conversation = Conversation()
        self._turn = asyncio.Lock()
        self._context = zmq.asyncio.Context()
        self._close = Closer(self, self._context)
        try:
            self._open()
        except ValueError:
            self.close()
            raise

    def close(self) -> None:
        self._close()

    async def __aenter__(self) -> 'Control':
        return self

    async def __aexit__(self, *_) -> None:
        self.close()

    async def _do(self, request, result):
        return result(await self.call(request))

    async def call(self, request: control_pb2.Request) -> control_pb2.Reply:
        """Sends any request; its id is overwritten."""
        async with self._turn:
            # The reply to a take is sent after it.
            end = time.monotonic() + self._timeout + request.like.learn_s
            message = [b'', self._conversation.encode(request)]
            try:
                await self._socket.send_multipart(message, zmq.NOBLOCK)
                while await _is_readable(self._socket, max(0.0, end - time.monotonic())):
                    payload = (await self._socket.recv_multipart())[-1]
                    reply = self._conversation.decode(payload, self._endpoint)
                    if reply is not None:
                        return reply
            except zmq.Again:
                pass
            self._socket.close(0)
            self._open()
            raise blocking.no_answer(self._endpoint, self._timeout)

    def _open(self) -> None:
        self._socket = blocking.open_socket(self._context, self._endpoint, self._curve)
        self._close.sockets[:] = [self._socket]


async def _is_readable(socket: zmq.asyncio.Socket, seconds: Optional[float]) -> bool:
    return bool(await socket.poll(None if seconds is None else checks.milliseconds(seconds)))
