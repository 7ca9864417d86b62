"""The connection to a daemon, and the timer that applies its newest frames to the driven armatures.
One per Blender; which performer drives which armature is stored in the objects (properties.py)."""

import time
import traceback
import warnings
from typing import Dict, List, NamedTuple, Optional, Tuple

import bpy
import styled

from .bake import MAX_FRAMES
from .drive import Plan, Unfit

RATE_HZ = 60
_CONTROL_TIMEOUT_S = 0.5  # Blender is blocked meanwhile
_FIRST_RETRY_S, _LONGEST_RETRY_S = 2, 60  # limit for a control address without a reply
STREAMS = ('rig', 'canonical', 'source')

# The source of an armature's motion: performer, and one of STREAMS or the name of an [[output]].
Choice = Tuple[str, str]


class Latest(NamedTuple):
    """The data that an armature displays."""
    epoch: int
    sequence: int
    styles: str


class _Link:
    """One driven armature."""

    def __init__(self, choice: Choice, publisher: str, curve):
        self.choice = choice
        self.plan: Optional[Plan] = None
        self.unfit = ''
        self.latest: Optional[Latest] = None
        self.take: Optional[list] = None  # frames to bake, every one; None: not recording
        self._planned_for = None
        self._subscriber = styled.Subscriber(publisher, performer=choice[0], streams=[choice[1]],
                                             curve=curve)

    def close(self) -> None:
        self._subscriber.close()

    def step(self, armature_object) -> None:
        newest = self._read()
        if armature_object.mode == 'EDIT':
            self._planned_for = None  # its rest pose may have changed
            return
        if newest is None or newest.body is None:
            return  # the body arrives within a second
        bones = armature_object.data.bones
        key = (newest.body.hash, armature_object.data.name, len(bones))
        if key != self._planned_for:
            self._replan(newest.body, armature_object, key)
        if self.plan is None:
            return
        try:
            self.plan.apply(newest.frame, armature_object)
        except KeyError:  # a bone was renamed
            self._replan(newest.body, armature_object, key)
            return
        frame = newest.frame
        self.latest = Latest(frame.epoch, frame.sequence, ', '.join(
            f'{style.style} {style.weight:.2f}' for style in frame.styles))

    def give_up(self, why: str) -> None:
        """Until another body comes, or the armature is driven again."""
        self.plan, self.unfit = None, why

    # The newest frame. A take also keeps the frames before it, however seldom Blender calls this.
    def _read(self):
        newest = None
        if self.take is None:
            for update in self._subscriber.receive_latest(0):
                if update.kind is styled.Kind.FRAME:
                    newest = update
            return newest
        while True:
            update = self._subscriber.receive(0)
            if update is None:
                return newest
            if update.kind is styled.Kind.FRAME:
                newest = update
                if update.body is not None and len(self.take) < MAX_FRAMES:
                    self.take.append(update.frame)

    def _replan(self, body, armature_object, key) -> None:
        self._planned_for, self.plan, self.unfit = key, None, ''
        try:
            self.plan = Plan(body, armature_object.data)
        except Unfit as error:
            self.unfit = str(error)


class Live:
    def __init__(self):
        self.problem = ''              # of the connection, for the panel
        self.unseen = ''               # why the last change is not visible
        self.styles: List[str] = []
        self.bodies: Dict[Choice, object] = {}
        self._curve = None
        self._publisher = ''
        self._listener: Optional[styled.Subscriber] = None
        self._control: Optional[styled.Control] = None
        self._links: Dict[str, _Link] = {}
        self._strength: Optional[Tuple[str, float]] = None  # requested, not yet sent
        self._retry_s, self._retry_at_s = _FIRST_RETRY_S, 0.0  # until the styles have arrived

    @property
    def active(self) -> bool:
        return self._listener is not None

    @property
    def reached(self) -> bool:
        """Whether the publisher is connected."""
        return self.active and self._listener.connected() > 0

    def connect(self, publisher: str, control: str, curve=None) -> None:
        """Raises ValueError for an invalid address or key; a missing daemon is a `problem`, not an
        error."""
        self.disconnect()
        self._control = styled.Control(control, timeout=_CONTROL_TIMEOUT_S, curve=curve)
        try:
            self._listener = styled.Subscriber(publisher, streams=None, curve=curve)
        except ValueError:
            self._control.close()
            self._control = None
            raise
        self._publisher, self._curve = publisher, curve
        self.ask_for_styles()
        bpy.app.timers.register(tick, first_interval=0, persistent=True)

    def disconnect(self) -> None:
        if bpy.app.timers.is_registered(tick):
            bpy.app.timers.unregister(tick)
        for link in self._links.values():
            link.close()
        for socket in (self._listener, self._control):
            if socket is not None:
                socket.close()
        self.__init__()

    def ask_for_styles(self) -> None:
        listed = self._ask(lambda control: control.list())
        self._retry_at_s = time.monotonic() + self._retry_s
        self._retry_s = min(2 * self._retry_s, _LONGEST_RETRY_S)
        if listed is not None:
            self.styles = [style.name for style in listed.styles]

    def set_style(self, performer: str, style: str, strength: float) -> bool:
        return self._ask(lambda control: control.set(performer, style=style,
                                                     strength=strength)) is not None

    def clear(self, performer: str) -> bool:
        return self._ask(lambda control: control.clear(performer)) is not None

    def panic(self) -> bool:
        return self._ask(lambda control: control.panic()) is not None

    def set_strength_soon(self, performer: str, strength: float) -> None:
        """Applies the strength with the next tick, since a dragged slider calls this too often."""
        self._strength = (performer, strength)

    def performers(self) -> List[str]:
        return sorted({performer for performer, _ in self.bodies})

    def streams(self, performer: str) -> List[str]:
        """The streams that every performer has, then its avatars."""
        return list(STREAMS) + sorted(stream for owner, stream in self.bodies
                                      if owner == performer and stream not in STREAMS)

    def body(self, performer: str, stream: str):
        return self.bodies.get((performer, 'rig' if stream == 'source' else stream))

    def link(self, armature_object) -> Optional[_Link]:
        return self._links.get(armature_object.name)

    def step(self) -> None:
        """One tick: reads new bodies, applies the newest frames, sends pending requests."""
        for update in self._listener.receive_latest(0):
            if update.kind is styled.Kind.BODY:
                self._keep(update.body)
        if not self.styles and not self.reached:
            self._retry_s, self._retry_at_s = _FIRST_RETRY_S, 0.0  # at once when it is there
        elif not self.styles and time.monotonic() >= self._retry_at_s:
            self.ask_for_styles()
        if self._strength is not None:
            (performer, strength), self._strength = self._strength, None
            self._ask(lambda control: control.set(performer, strength=strength))
        self._follow()

    def _keep(self, body) -> None:
        stream = {1: 'rig', 2: 'canonical'}.get(body.output, body.output_name)
        self.bodies[body.performer, stream] = body

    # The objects state what is driven; undo, renaming and loading may change that at any time.
    def _follow(self) -> None:
        wanted = {}
        for thing in bpy.data.objects:
            if thing.type == 'ARMATURE' and thing.styled_live.driven:
                wanted[thing.name] = thing
        for name in list(self._links):
            thing = wanted.get(name)
            if thing is None or _choice(thing) != self._links[name].choice:
                self._links.pop(name).close()
        for name, thing in wanted.items():
            if name not in self._links:
                try:
                    self._links[name] = _Link(_choice(thing), self._publisher, self._curve)
                except ValueError as error:
                    self.problem = str(error)
                    thing.styled_live.driven = False
                    continue
            link = self._links[name]
            try:
                link.step(thing)
            except Exception as error:  # an error of one armature must not end the timer for all
                traceback.print_exc()
                link.give_up(f'{type(error).__name__}: {error}')

    # Returns None, with the reason in `problem`, if the daemon refuses or does not answer.
    def _ask(self, what):
        if self._control is None:
            self.problem = 'not connected'
            return None
        try:
            with warnings.catch_warnings(record=True) as told:
                warnings.simplefilter('always', styled.Unseen)
                answer = what(self._control)
            self.unseen = str(told[0].message) if told else ''
        except (styled.Error, ValueError) as error:
            self.problem = str(error)
            return None
        self.problem = ''
        return answer


def _choice(armature_object) -> Choice:
    return armature_object.styled_live.performer, armature_object.styled_live.stream


def tick() -> Optional[float]:
    """Blender's timer; returning None ends it."""
    if not live.active:
        return None
    live.step()
    return 1 / RATE_HZ


live = Live()
