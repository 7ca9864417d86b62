"""Warns of changes that the daemon has applied and that are not visible, on the line that requested
them."""

import sys
import warnings
from typing import Any, Dict, FrozenSet, Iterable, NamedTuple, Optional

from styled.errors import AbsentPerformer, NoStrength, NotChanged, NotVaried, Unseen
from styled.v1 import control_pb2

_STYLING = ('set', 'preset', 'like', 'import_style', 'cue')


class Applied(Dict[str, int]):
    """The result of a change: the first sequence under it by performer.

    absent       those of them of whose name no performer is present: the change waits for it
    no_strength  those that have styles set, but the strength 0: none is visible
    not_varied   {performer: style} where the look asks for a variation and the style has none
    refused      {performer: reason} of those that a change for everybody left as they were; they are not
                 among the changed ones """

    def __init__(self, entries: Iterable[control_pb2.Applied] = ()):
        entries = list(entries)
        super().__init__((entry.performer, entry.first_sequence) for entry in entries if not entry.refused)
        self.absent: FrozenSet[str] = frozenset(e.performer for e in entries if e.absent)
        self.no_strength: FrozenSet[str] = frozenset(e.performer for e in entries if e.no_strength)
        self.not_varied: Dict[str, str] = {e.performer: e.not_varied for e in entries if e.not_varied}
        self.refused: Dict[str, str] = {e.performer: e.refused for e in entries if e.refused}


class Line(NamedTuple):
    """A line of a program."""
    file: str
    number: int
    names: Dict[str, Any]  # the module's globals


def line_of_caller() -> Line:
    """The line outside of this package that called into it. For a coroutine it must be determined before
    the await, because a task's stack ends at the event loop."""
    frame: Any = sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get('__name__', '').split('.')[0] == 'styled':
        frame = frame.f_back
    return Line(frame.f_code.co_filename, frame.f_lineno, frame.f_globals)


def warn(request: control_pb2.Request, reply: control_pb2.Reply, line: Line) -> None:
    """Warns of absence only about named performers: '*' means none in particular, a checkpoint is restored
    before its performer arrives, and a strength of 0 in the request itself is intended."""
    command: Optional[str] = request.WhichOneof('command')
    applied = Applied(reply.applied)
    if request.performer in applied.absent and command != 'restore_checkpoint':
        warn_at(AbsentPerformer(f"no performer of the name '{request.performer}' is present: the change "
                                'waits for it'), line)
    if applied.no_strength and command in _STYLING and not request.set.HasField('strength'):
        warn_at(NoStrength(f'the strength of {", ".join(sorted(applied.no_strength))} is 0: no style is '
                           'visible'), line)
    for performer, style in applied.not_varied.items():
        if command in _STYLING:
            warn_at(NotVaried(f"{performer}: '{style}' has no variations and is shown as it is"), line)
    for reason in applied.refused.values():
        warn_at(NotChanged(f'not changed: {reason}'), line)


def warn_at(warning: Unseen, line: Line) -> None:
    warnings.warn_explicit(warning, type(warning), line.file, line.number,
                           line.names.get('__name__') or '<string>',
                           line.names.setdefault('__warningregistry__', {}))
