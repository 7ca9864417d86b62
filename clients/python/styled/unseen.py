"""Warns of changes that the daemon has applied and nobody will see, on the line that asked for them."""

import sys
import warnings
from typing import Any, Dict, FrozenSet, Iterable, NamedTuple, Optional

from styled.errors import AbsentPerformer, NoStrength, Unseen
from styled.v1 import control_pb2

_STYLING = ('set', 'preset', 'like', 'import_style', 'cue')


class Applied(Dict[str, int]):
    """What a change returns: the first sequence under it by performer.

    absent       those of them under whose name nobody performs: the change waits until they come
    no_strength  those that have styles set, but the strength 0: none is to be seen
    """

    def __init__(self, entries: Iterable[control_pb2.Applied] = ()):
        entries = list(entries)
        super().__init__((entry.performer, entry.first_sequence) for entry in entries)
        self.absent: FrozenSet[str] = frozenset(e.performer for e in entries if e.absent)
        self.no_strength: FrozenSet[str] = frozenset(e.performer for e in entries if e.no_strength)


class Line(NamedTuple):
    """A line of a program."""
    file: str
    number: int
    names: Dict[str, Any]  # the module's globals


def line_of_caller() -> Line:
    """The line outside of this package that called into it. Of a coroutine it has to be asked for before
    that is awaited: a task's stack ends at the event loop."""
    frame: Any = sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get('__name__', '').split('.')[0] == 'styled':
        frame = frame.f_back
    return Line(frame.f_code.co_filename, frame.f_lineno, frame.f_globals)


def warn(request: control_pb2.Request, reply: control_pb2.Reply, line: Line) -> None:
    """Warns of what was asked for by name: with '*' nobody in particular was meant, a checkpoint is
    restored before its performer comes, and a strength of 0 that the request itself sets is wanted."""
    command: Optional[str] = request.WhichOneof('command')
    applied = Applied(reply.applied)
    if request.performer in applied.absent and command != 'restore_checkpoint':
        warn_at(AbsentPerformer(f"nobody performs under the name '{request.performer}': the change "
                                'waits until they come'), line)
    if applied.no_strength and command in _STYLING and not request.set.HasField('strength'):
        warn_at(NoStrength(f'the strength of {", ".join(sorted(applied.no_strength))} is 0: no style is to '
                           'be seen'), line)


def warn_at(warning: Unseen, line: Line) -> None:
    warnings.warn_explicit(warning, type(warning), line.file, line.number,
                           line.names.get('__name__') or '<string>',
                           line.names.setdefault('__warningregistry__', {}))
