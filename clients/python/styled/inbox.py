"""Processes a subscriber's messages, independent of the sockets: topics, the bodies of frames, and gaps
(proto/styled/v1/WIRE.md)."""

import collections
import collections.abc
import dataclasses
import time
import enum
import re
from typing import Deque, Dict, Iterable, List, Optional, Tuple, Union

from google.protobuf.message import DecodeError

from styled import checks, kinematics
from styled.doubts import Doubts
from styled.v1 import body_pb2, frame_pb2, stats_pb2

_NAME = re.compile(r'[A-Za-z0-9_-]{1,32}')
_ID = re.compile(r'[A-Za-z0-9_-]{1,32}\.[A-Za-z0-9_-]{1,32}')
_MAX_PERFORMERS = 4096
_MAX_BODIES = 64  # per performer: for its outputs, and for their previous bodies


def is_performer_id(text: str) -> bool:
    """Whether `text` is SOURCE.NAME, each part [A-Za-z0-9_-]{1,32}."""
    return _ID.fullmatch(text) is not None


class Stream(enum.Enum):
    """The streams in which a performer is published."""
    RIG = 'rig'              # styled, on the rig's own skeleton
    CANONICAL = 'canonical'  # styled, on the canonical humanoid
    SOURCE = 'source'        # as received, on the rig's own skeleton
    AVATAR = 'avatar'        # styled, on an avatar of the daemon's configuration


# What to subscribe to: a stream, or the name of an [[output]] in the daemon's configuration.
Wanted = Union[Stream, str]

_OUTPUTS = {Stream.RIG: body_pb2.OUTPUT_RIG, Stream.CANONICAL: body_pb2.OUTPUT_CANONICAL,
            Stream.SOURCE: body_pb2.OUTPUT_RIG, Stream.AVATAR: body_pb2.OUTPUT_AVATAR}


_BUNDLES = ('rig', 'canonical', 'source')
_STREAMS = ("'rig', 'canonical' or 'source' (styled.RIG, CANONICAL, SOURCE), or the name of an [[output]] "
            '([A-Za-z0-9_-]{1,32})')


def _topic(wanted: Wanted, performer: str) -> str:
    if wanted is Stream.SOURCE:
        return f'source/{performer}/'
    return f'styled/{performer}/{getattr(wanted, "value", wanted)}/'


def _check_wanted(wanted: Wanted) -> Wanted:
    if isinstance(wanted, Stream) and wanted is not Stream.AVATAR:
        return wanted
    if not isinstance(wanted, str) or not _NAME.fullmatch(wanted):
        raise ValueError(f'streams has {wanted!r}, expected {_STREAMS}')
    if wanted.lower() not in _BUNDLES:
        return wanted
    if wanted not in _BUNDLES:
        raise ValueError(f"streams has '{wanted}', expected '{wanted.lower()}'")
    return Stream(wanted)


def _check_all_wanted(streams: Union[Wanted, Iterable[Wanted], None],
                      statistics: bool) -> Tuple[Wanted, ...]:
    if streams is None:
        return ()
    if isinstance(streams, (Stream, str)):
        streams = (streams,)
    if isinstance(streams, bytes) or not isinstance(streams, collections.abc.Iterable):
        raise TypeError(f'streams is {streams!r}, expected one or several of {_STREAMS}')
    wanted = tuple(_check_wanted(stream) for stream in streams)
    if not wanted and not statistics:
        raise ValueError(f'streams has none, so no frame would arrive; expected one or several of {_STREAMS}, '
                         'or None: bodies only')
    return wanted


def _check_performer(performer: str) -> str:
    expected = "expected SOURCE.NAME ([A-Za-z0-9_-]{1,32} each), or '' for all"
    if not isinstance(performer, str):
        raise TypeError(f'performer is {performer!r}, {expected}')
    if performer and not is_performer_id(performer):
        raise ValueError(f"performer '{performer}', {expected}")
    return performer


def _stream_of(words: List[str]) -> Tuple[Optional[Stream], str]:
    """Performer and stream of a topic split at its slashes, and the name of an avatar's [[output]]."""
    if len(words) == 3 and words[0] == 'source' and is_performer_id(words[1]):
        return Stream.SOURCE, ''
    if len(words) != 4 or words[0] != 'styled' or not is_performer_id(words[1]):
        return None, ''
    if words[2] in ('rig', 'canonical'):
        return Stream(words[2]), ''
    return (Stream.AVATAR, words[2]) if _NAME.fullmatch(words[2]) else (None, '')


class Kind(enum.Enum):
    FRAME = 'frame'            # a pose
    BODY = 'body'              # a skeleton not seen before
    STATISTICS = 'statistics'  # the daemon's counters, once a second


@dataclasses.dataclass
class Update:
    """One received message. Fields that do not belong to its kind are None, 0 or False."""
    kind: Kind
    stream: Optional[Stream] = None
    output_name: str = ''  # for Stream.AVATAR: the name of the [[output]]
    frame: Optional[frame_pb2.Frame] = None
    body: Optional[body_pb2.Body] = None  # of the frame, checked; None until it has arrived
    missed: int = 0                       # frames of this stream lost in transit directly before this one
    skipped: int = 0                      # receive_latest only: older frames that this one superseded
    new_epoch: bool = False               # the daemon restarted since the previous frame of this stream
    statistics: Optional[stats_pb2.Stats] = None

    def world(self) -> kinematics.World:
        """The joints in the frame's world: world['head'].position, or the whole as
        world.positions."""
        if self.frame is None or self.body is None:
            raise ValueError('world() of an update without a frame, or whose body has not arrived yet')
        return kinematics.world_transforms(self.body, self.frame)


@dataclasses.dataclass
class Counters:
    """Totals since the subscriber was made; never reset."""
    frames: int = 0           # accepted
    missed: int = 0           # lost in transit, by gaps in `sequence`, summed over streams
    epochs: int = 0           # restarts of the daemon, counted once per stream
    bodies: int = 0           # new skeletons
    replayed_bodies: int = 0  # dropped: already known
    repeated_frames: int = 0  # dropped: sequence not greater than the last
    malformed: int = 0        # dropped: not as in WIRE.md, or a frame that does not fit its body


class _Lag:
    """How much longer than usual a frame was in transit, compared with the shortest transit of the last
    two to four seconds. Only differences are used, so the clocks of two machines need not agree."""

    def __init__(self) -> None:
        self._turned: Optional[float] = None
        self._previous = self._current = 0.0

    def take(self, published: float, now: float) -> float:
        way = now - published
        if self._turned is None or now - self._turned >= 2:
            self._previous = way if self._turned is None else self._current
            self._current = way
            self._turned = now
        self._current = min(self._current, way)
        return way - min(self._previous, self._current)


@dataclasses.dataclass
class _State:
    started: bool = False
    epoch: int = 0
    sequence: int = 0
    lag: _Lag = dataclasses.field(default_factory=_Lag)


class Inbox:
    """Converts messages to updates. Has no socket; `topics()` and `new_topics` list what its owner must
    subscribe to."""

    def __init__(self, performer: str = '',
                 streams: Union[Wanted, Iterable[Wanted], None] = (Stream.RIG,),
                 statistics: bool = False, bundled: bool = False):
        self._performer = _check_performer(performer)
        self._statistics = checks.yes_or_no('statistics', statistics)
        self._bundled = checks.yes_or_no('bundled', bundled)
        self._streams = _check_all_wanted(streams, statistics)
        if bundled and performer:
            raise ValueError(f"bundled with performer '{performer}', expected '' (all)")
        self.several = False  # daemons: for a pair with a standby the leader's statistics count
        self.counters = Counters()
        self.new_topics: List[str] = []  # the owner must subscribe to these and clear the list
        self.lag_s = 0.0                 # of the last frame, compared with its usual transit
        self._waiting: Deque[Tuple[Stream, frame_pb2.Frame]] = collections.deque()  # of a bundle
        self._bodies: Dict[str, List[body_pb2.Body]] = {}
        self.doubts = Doubts(performer, (name for name in self._streams if isinstance(name, str)))
        self._states: Dict[str, _State] = {}

    def topics(self) -> List[str]:
        topics = ['stats/'] if self._statistics else []
        if not self._performer:
            if self._bundled:
                topics += [f'frames/{stream.value}/' for stream in self._streams
                           if isinstance(stream, Stream)]
            return topics + ['body/']  # finds the performers; then each one's own topics
        return topics + [f'body/{self._performer}/'] + self._frame_topics(self._performer)

    def performers(self) -> List[str]:
        return sorted(self._bodies)

    def accept(self, parts: List[bytes]) -> Optional[Update]:
        """The update for a message, or None if the message is dropped. For a bundle the first;
        next() returns the others."""
        if len(parts) == 2:
            try:
                return self._accept(parts[0].decode('ascii'), parts[1])
            except (DecodeError, UnicodeDecodeError):
                pass
        self.counters.malformed += 1
        return None

    def next(self) -> Optional[Update]:
        """The next frame of the last bundle, or None."""
        while self._waiting:
            stream, frame = self._waiting.popleft()
            if not is_performer_id(frame.performer):
                self.counters.malformed += 1
                continue
            update = self._accept_frame(stream, '', _topic(stream, frame.performer), frame.performer, frame)
            if update is not None:
                return update
        return None

    def _frame_topics(self, performer: str) -> List[str]:
        return [_topic(stream, performer) for stream in self._streams
                if not (self._bundled and isinstance(stream, Stream))]

    def _accept(self, topic: str, payload: bytes) -> Optional[Update]:
        words = topic.split('/')
        if words == ['stats', '']:
            statistics = _parse(stats_pb2.Stats, payload)
            if self.several and statistics.standby.role == 'following':
                return None
            return Update(Kind.STATISTICS, statistics=statistics)
        if len(words) == 3 and words[0] == 'body':
            return self._accept_body(words[1], payload)
        if len(words) == 3 and words[0] == 'frames' and words[1] in _BUNDLES and words[2] == '':
            bundle = _parse(frame_pb2.Frames, payload)
            self._waiting.extend((Stream(words[1]), frame) for frame in bundle.frames)
            return self.next()
        stream, name = _stream_of(words)
        if stream is not None and words[-1] == '':
            return self._accept_frame(stream, name, topic, words[1], _parse(frame_pb2.Frame, payload))
        self.counters.malformed += 1
        return None

    def _accept_body(self, performer: str, payload: bytes) -> Optional[Update]:
        body = _parse(body_pb2.Body, payload)
        full = len(self._bodies) >= _MAX_PERFORMERS and performer not in self._bodies
        if body.performer != performer or not is_performer_id(performer) or full or \
                kinematics.check_body(body):
            self.counters.malformed += 1
            return None
        if performer not in self._bodies:
            self._bodies[performer] = []
            if not self._performer:
                self.new_topics += self._frame_topics(performer)
        known = self._bodies[performer]
        if any(_same(body, other) for other in known):
            self.counters.replayed_bodies += 1
            return None
        del known[:max(0, len(known) - _MAX_BODIES + 1)]
        known.append(body)
        self.doubts.saw(body)
        self.counters.bodies += 1
        return Update(Kind.BODY, body=body)

    def _accept_frame(self, stream: Stream, name: str, topic: str, performer: str,
                      frame: frame_pb2.Frame) -> Optional[Update]:
        if frame.performer != performer or frame.output != _OUTPUTS[stream]:
            self.counters.malformed += 1
            return None
        state = self._states.setdefault(topic, _State())
        same_epoch = state.started and frame.epoch == state.epoch
        if same_epoch and frame.sequence <= state.sequence:
            self.counters.repeated_frames += 1
            return None
        body = next((b for b in self._bodies.get(performer, ())
                     if b.hash == frame.body_hash and b.output == frame.output and
                     b.output_name == name), None)
        if body is not None and kinematics.check_frame(frame, body):
            self.counters.malformed += 1
            return None
        missed = frame.sequence - state.sequence - 1 if same_epoch else 0
        new_epoch = state.started and not same_epoch
        lag = state.lag if same_epoch else _Lag()
        self.lag_s = lag.take(frame.publish_time_ns * 1e-9, time.monotonic())
        self._states[topic] = _State(True, frame.epoch, frame.sequence, lag)
        self.counters.frames += 1
        self.counters.missed += missed
        self.counters.epochs += new_epoch
        return Update(Kind.FRAME, stream, name, frame, body, missed, 0, new_epoch)


def _parse(kind, payload: bytes):
    parsed = kind()
    # Some implementations of protobuf stop at an end-group tag and only warn.
    if parsed.ParseFromString(payload) != len(payload):
        raise DecodeError('not all of it was read')
    return parsed


def _same(a: body_pb2.Body, b: body_pb2.Body) -> bool:
    return (a.hash, a.output, a.output_name) == (b.hash, b.output, b.output_name)


class Newest:
    """Latest-wins: keeps the newest frame of each performer and stream, every body, and the newest
    statistics."""

    def __init__(self) -> None:
        self._updates: Dict[Tuple, Update] = {}
        self._lags_s: Dict[Tuple, float] = {}

    def add(self, update: Update, lag_s: float = 0.0) -> None:
        """`lag_s`: for a frame, how much later than usual it arrived."""
        key: Tuple = (update.kind,)
        if update.kind is Kind.FRAME:
            key = (update.kind, update.stream, update.output_name, update.frame.performer)
            older = self._updates.get(key)
            if older is not None:
                update.missed += older.missed
                update.skipped = older.skipped + 1
                update.new_epoch = update.new_epoch or older.new_epoch
        elif update.kind is Kind.BODY:
            body = update.body
            key = (update.kind, body.performer, body.output, body.output_name, body.hash)
        self._updates[key] = update
        self._lags_s[key] = lag_s if update.kind is Kind.FRAME else 0.0

    def lag_s(self) -> float:
        """The lag of the frame that is the latest, compared with its usual transit."""
        return max(self._lags_s.values(), default=0.0)

    def take(self) -> List[Update]:
        return list(self._updates.values())
