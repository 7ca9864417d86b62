"""A mistyped performer or output causes silence: a subscriber warns once if frames it asked for do not
arrive."""

import time
from typing import Iterable, List, Optional, Set, Union

from styled.errors import AbsentOutput, AbsentPerformer
from styled.v1 import body_pb2

Told = Union[AbsentOutput, AbsentPerformer]

LOOK_S = 0.5      # interval of the checks of a waiting subscriber, as long as something is missing
PATIENCE_S = 2.0  # a daemon sends all bodies at once


class Doubts:
    """The subscriptions by name. `performer`: '' for all; `outputs`: names of [[output]]s."""

    def __init__(self, performer: str, outputs: Iterable[str]):
        self._performer = performer  # '' once they have arrived, or were reported as absent
        self._outputs = sorted(set(outputs))
        self._here: Set[str] = {'rig', 'canonical', 'source'}
        self._connected_s: Optional[float] = None
        self._body_s: Optional[float] = None
        self._next_s = 0.0

    def pending(self) -> bool:
        return bool(self._performer or self._outputs)

    def due(self) -> bool:
        """Whether to check now: not with every arriving frame."""
        now = time.monotonic()
        if now < self._next_s:
            return False
        self._next_s = now + LOOK_S
        return True

    def saw(self, body: body_pb2.Body) -> None:
        self._performer = ''
        self._here.add(body.output_name)
        self._outputs = [name for name in self._outputs if name != body.output_name]
        if self._body_s is None:
            self._body_s = time.monotonic()

    def look(self, connected: bool) -> List[Told]:
        """The subscriptions whose frames have not arrived in time; each once."""
        now, told = time.monotonic(), []  # type: float, List[Told]
        self._connected_s = (self._connected_s or now) if connected else None
        if self._performer and self._connected_s is not None and now - self._connected_s > PATIENCE_S:
            told.append(AbsentPerformer(f"no performer of the name '{self._performer}' is present yet: frames arrive "
                                        'once it is'))
            self._performer = ''
        if self._outputs and self._body_s is not None and now - self._body_s > PATIENCE_S:
            here = ', '.join(sorted(self._here - {''}))
            told += [AbsentOutput(f"no performer has an output '{name}' yet, they have {here}: frames arrive when "
                                  'one has') for name in self._outputs]
            self._outputs = []
        return told
