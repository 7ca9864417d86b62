"""Styled performers in Python: subscribe to a styled daemon's frames, and steer it.

    import styled
    with styled.Subscriber() as subscriber, styled.Control() as control:
        control.set('*', style='old', strength=0.8)
        for update in subscriber.frames():
            head = update.world()[list(update.body.names).index('head')]

styled.aio has the same for asyncio. The messages themselves are in styled.v1 (frame_pb2, body_pb2,
control_pb2, look_pb2, stats_pb2), as proto/styled/v1 documents them.
"""

import sys

try:
    from styled.v1 import frame_pb2 as _messages  # made by protoc when Styled is built
except ImportError as error:
    if error.name is None or not error.name.startswith('styled.v1'):
        raise ImportError(f"styled needs protobuf for Python, and {sys.executable} has none ({error}); "
                          'for Debian 12\'s own /usr/bin/python3: '
                          'apt install python3-protobuf python3-zmq') from error
    raise ImportError(
        'styled.v1, the messages, are not here: this is the source folder. Build the CMake target '
        'styled_python, then set PYTHONPATH to build/release/python') from error

from styled.commands import EVERYONE
from styled.control import DEFAULT_CONTROL, Control
from styled.curve import Curve
from styled.errors import Error, Garbled, NoAnswer, Refused
from styled.inbox import Counters, Kind, Stream, Update, is_performer_id
from styled.kinematics import Transform, world_arrays, world_transforms
from styled.subscriber import DEFAULT_PUBLISHER, Subscriber

RIG, CANONICAL, SOURCE = Stream.RIG, Stream.CANONICAL, Stream.SOURCE

__all__ = ['CANONICAL', 'DEFAULT_CONTROL', 'DEFAULT_PUBLISHER', 'EVERYONE', 'RIG', 'SOURCE',
           'Control', 'Counters', 'Curve', 'Error', 'Garbled', 'Kind', 'NoAnswer', 'Refused',
           'Stream', 'Subscriber', 'Transform', 'Update', 'is_performer_id', 'world_arrays',
           'world_transforms']
