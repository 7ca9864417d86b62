"""The requests to a daemon, independent of the socket: arguments are converted to requests of
control.proto, and replies to results."""

import math
import os
import random
import re
from typing import Any, Callable, Mapping, Optional, Sequence

from google.protobuf.message import DecodeError

from styled.errors import Garbled, Refused
from styled.inbox import is_performer_id
from styled.unseen import Applied, line_of_caller, warn
from styled.v1 import control_pb2, frame_pb2, look_pb2

EVERYONE = '*'

MAX_CLIP_BYTES = 8 * 1024 * 1024 - 4096  # a request with it has at most 8 MiB

PARTS = {name[len('BODY_PART_'):].lower().replace('_', '-'): number
         for name, number in frame_pb2.BodyPart.items()}

ROOTS = {name[len('ROOT_'):].lower(): number for name, number in look_pb2.Root.items()}

# The named arguments of `set` besides style and mix; `clear` is a separate call.
LOOK_FIELDS = [field.name for field in look_pb2.Look.DESCRIPTOR.fields
               if field.name not in ('mix', 'clear')]


def _change(performer: str) -> control_pb2.Request:
    expected = f"expected SOURCE.NAME ([A-Za-z0-9_-]{{1,32}} each), or '{EVERYONE}' for all"
    if not isinstance(performer, str):
        raise TypeError(f'performer is {performer!r}, {expected}')
    if performer != EVERYONE and not is_performer_id(performer):
        raise ValueError(f"performer '{performer}', {expected}")
    return control_pb2.Request(performer=performer)


def _put(message: Any, field: str, value: Any, command: str) -> None:
    """Sets a field; protobuf's own refusals name neither it nor what was found."""
    try:
        setattr(message, field, value)
    except (TypeError, ValueError):
        kind = message.DESCRIPTOR.fields_by_name[field]
        expected = {kind.CPPTYPE_STRING: 'a name', kind.CPPTYPE_BOOL: 'True or False'}.get(
            kind.cpp_type, 'a number')
        raise TypeError(f'{command}: {field} is {value!r}, expected {expected}') from None


# Spellings of version 0.1.
_FORMER = {'only': 'parts', 'own_style': 'input_style'}


def _set_request(performer: str, style: Optional[str], mix: Optional[Mapping[str, float]],
                 fields: Mapping[str, Any]) -> control_pb2.Request:
    if style is not None and mix is not None:
        raise ValueError('set: both style and mix, expected one of them')
    request = _change(performer)
    look = request.set
    look.SetInParent()
    if style is not None:
        if not isinstance(style, str):
            raise TypeError(f'set: style is {style!r}, expected the name of one')
        mix = {style: 1.0}
    if mix is not None and not isinstance(mix, Mapping):
        raise TypeError(f"set: mix is {mix!r}, expected weights by style, e.g. "
                        "{'elderly': 0.5, 'active': 0.5}")
    for name, weight in (mix or {}).items():
        try:
            look.mix.add(style=name, weight=weight)
        except (TypeError, ValueError):
            raise TypeError(f'set: mix has {name!r}: {weight!r}, expected the name of a style and a '
                            'number') from None
    for given, value in fields.items():
        name = _FORMER.get(given, given)
        if name not in LOOK_FIELDS:
            raise TypeError(f"set: no '{given}', expected style, mix, {', '.join(LOOK_FIELDS)}")
        if value is None:
            continue
        if name == 'root':
            if value not in ROOTS:
                raise ValueError(f"root: '{value}', expected {' or '.join(ROOTS)}")
            look.root = ROOTS[value]
            continue
        if name != 'parts':
            _put(look, name, value, 'set')
            continue
        for part in [value] if isinstance(value, str) else value:
            if part not in PARTS:
                raise ValueError(f"parts: '{part}', expected some of {', '.join(PARTS)}")
            look.parts.append(PARTS[part])
    return request


def _calibrate_request(performer: str, pose: str, sensors: str, clear: bool,
                      neutral: bool, seconds: float) -> control_pb2.Request:
    request = _change(performer)
    try:
        kinds = control_pb2.Calibrate
        request.calibrate.pose = kinds.Pose.Value('POSE_' + pose.upper())
        request.calibrate.sensors = kinds.Sensors.Value('SENSORS_' + sensors.upper())
    except ValueError:
        raise ValueError(f"calibrate: pose '{pose}', sensors '{sensors}', expected t or n, and "
                         'full, yaw or mounting') from None
    request.calibrate.clear = clear
    request.calibrate.neutral = neutral
    if neutral:
        _put(request.calibrate, 'seconds', seconds, 'calibrate')
    return request


def _read_file(command: str, file: str) -> bytes:
    with open(file, 'rb') as opened:
        content = opened.read(MAX_CLIP_BYTES + 1)
    if len(content) > MAX_CLIP_BYTES:
        raise ValueError(f'{command}: {file} has more than {MAX_CLIP_BYTES} bytes')
    return content


def _like_request(performer: Optional[str], name: str, transition_ms: Optional[float] = None,
                  neutral_code: Sequence[float] = (), network: str = '', add: bool = False,
                  command: str = 'like') -> control_pb2.Request:
    request = control_pb2.Request() if performer is None else _change(performer)
    _put(request.like, 'name', name, command)
    request.like.neutral_code.extend(neutral_code)
    _put(request.like, 'network', network, command)
    _put(request.like, 'add', add, command)
    if transition_ms is not None:
        _put(request.like, 'transition_ms', transition_ms, command)
    return request


def _design_request(performer: Optional[str], sliders: Optional[Mapping[str, float]], name: str,
                    from_: str, preset: str,
                    transition_ms: Optional[float]) -> control_pb2.Request:
    request = _like_request(performer, name, transition_ms, command='design')
    design = request.like.design
    design.SetInParent()
    if not isinstance(from_, str):
        raise TypeError(f'design: from_ is {from_!r}, expected the name of a style')
    setattr(design, 'from', from_)
    _put(design, 'preset', preset, 'design')
    if sliders is not None and not isinstance(sliders, Mapping):
        raise TypeError(f"design: sliders is {sliders!r}, expected numbers by slider, e.g. "
                        "{'stoop': 28, 'energy': 0.6}")
    for slider, value in (sliders or {}).items():
        try:
            design.sliders[slider] = value
        except (TypeError, ValueError):
            raise TypeError(f'design: sliders has {slider!r}: {value!r}, expected the name of a '
                            'slider and a number') from None
    return request


def _fill_clip(like: control_pb2.Like, clip: str, rig: str) -> None:
    like.file = os.path.basename(clip)
    like.rig = rig
    like.clip = _read_file('like', clip)


def _take_seconds(seconds: float) -> float:
    # The client waits for the reply as long; the daemon refuses 0 and values beyond its range.
    if isinstance(seconds, str) or not hasattr(seconds, '__float__'):
        raise TypeError(f'seconds is {seconds!r}, expected 1 to 60')
    if not math.isfinite(seconds) or seconds < 0:
        raise ValueError(f'seconds is {seconds}, expected 1 to 60')
    return seconds


def _like_reply(reply: control_pb2.Reply) -> control_pb2.LikeReply:
    return reply.like


class Commands:
    """The calls that styled.Control and styled.aio.Control share. Each class defines `_do(request,
    result)`: in the first, a call returns its result; in the second, a coroutine of it."""

    def _do(self, request: control_pb2.Request, result: Callable[[control_pb2.Reply], Any]) -> Any:
        raise NotImplementedError

    def _ask(self, request: control_pb2.Request, result: Callable[[control_pb2.Reply], Any]) -> Any:
        line = line_of_caller()

        def take(reply: control_pb2.Reply) -> Any:
            warn(request, reply, line)
            return result(reply)
        return self._do(request, take)

    def list(self) -> control_pb2.ListReply:
        """Styles, presets and cues; sliders and designs for `design`, if the weights have them."""
        return self._ask(control_pb2.Request(list={}), lambda reply: reply.list)

    def status(self) -> control_pb2.StatusReply:
        """The daemon, its performers, its counters."""
        return self._ask(control_pb2.Request(status={}), lambda reply: reply.status)

    def set(self, performer: str, *, style: Optional[str] = None,
            mix: Optional[Mapping[str, float]] = None, **fields: Any) -> Applied:
        """Changes the given settings and keeps the rest. `style` sets a mix of that style only.
        `fields` are those of styled.v1.look_pb2.Look: strength, transition_ms, absolute, preset,
        `parts` (the styled parts of the body, e.g. 'head', ['head', 'left-arm'] or 'all'),
        `input_style` (the performer's own style, which is removed), `root` ('follow', or 'stride': the
        path over the floor at the style's speed), `vary` (the variation of the style, 1 to 99; 0: the
        style itself), vary_each (a different one per performer), vary_amount, drift_s (the variation
        changes slowly: seconds from one to the next; 0: constant), `mirror` (left and right are
        exchanged)."""
        return self._ask(_set_request(performer, style, mix, fields), _applied)

    def clear(self, performer: str = EVERYONE) -> Applied:
        """Fades to bypass: the performer as captured."""
        request = _change(performer)
        request.set.clear = True
        return self._ask(request, _applied)

    def preset(self, performer: str, name: str,
               transition_ms: Optional[float] = None) -> Applied:
        """Applies a named mix of the daemon's configuration."""
        request = _change(performer)
        _put(request.preset, 'name', name, 'preset')
        if transition_ms is not None:
            _put(request.preset, 'transition_ms', transition_ms, 'preset')
        return self._ask(request, _applied)

    def pin(self, performer: str, pinned: bool = True) -> Applied:
        """A pinned performer keeps its style until it is unpinned."""
        request = _change(performer)
        _put(request.pin, 'pinned', pinned, 'pin')
        return self._ask(request, _applied)

    def reset(self, performer: str) -> Applied:
        """Clears the network's recurrent state, keeps the settings."""
        request = _change(performer)
        request.reset.SetInParent()
        return self._ask(request, _applied)

    def calibrate(self, performer: str, pose: str = 't', sensors: str = 'full',
                  clear: bool = False, neutral: bool = False,
                  seconds: float = 5) -> control_pb2.CalibrateReply:
        """Calibrates: the performer stands in this pose (t or n) at this moment. With `neutral`
        they stand and then walk in their own way for `seconds` (1 to 60) after the reply, and
        status().stats.performers shows the progress."""
        return self._ask(_calibrate_request(performer, pose, sensors, clear, neutral, seconds),
                         lambda reply: reply.calibrate)

    def like(self, performer: Optional[str], clip: str, name: Optional[str] = None,
             rig: str = 'auto', transition_ms: Optional[float] = None,
             neutral_code: Sequence[float] = (), network: str = '',
             add: bool = False) -> control_pb2.LikeReply:
        """Makes a style from an example, the file `clip` (BVH, glTF binary, VRMA), for all clients,
        and sets the performer (None: no performer) to it. `name`: by default the file's. The result
        has `nearest` and `distance`: the example's distance from the styles that the weights know;
        above 1 it is unlike all of them. `neutral_code`: the code that `measure` or `measure_take`
        returned for a neutral example of the same performer; only the difference from it is used
        then. The result's `found` lists the parts of the example, `weak` what is weak about them.
        `network`: the one that gets the style, by its name in the list or its family; by default the
        example decides. `add`: adds the example to the made style of that name, which is then the
        mean of both."""
        stem = os.path.splitext(os.path.basename(clip))[0]
        plain = re.sub('[^A-Za-z0-9_-]', '-', stem).lstrip('-') or 'style'
        request = _like_request(performer, name or plain[:32], transition_ms, neutral_code,
                                network, add)
        _fill_clip(request.like, clip, rig)
        return self._ask(request, _like_reply)

    def measure(self, clip: str, rig: str = 'auto', network: str = '') -> control_pb2.LikeReply:
        """The result that `like` would have for a clip, including its `code`; makes no style."""
        request = _like_request(None, '', network=network)
        _fill_clip(request.like, clip, rig)
        request.like.measure = True
        return self._ask(request, _like_reply)

    def learn(self, performer: str, seconds: float, name: str,
              transition_ms: Optional[float] = None, neutral_code: Sequence[float] = (),
              network: str = '', add: bool = False) -> control_pb2.LikeReply:
        """As `like`, from the performer's motion from now on, for this many seconds (1 to 60)."""
        request = _like_request(performer, name, transition_ms, neutral_code, network, add)
        request.like.learn_s = _take_seconds(seconds)
        return self._ask(request, _like_reply)

    def measure_take(self, performer: str, seconds: float,
                     network: str = '') -> control_pb2.LikeReply:
        """As `measure`, from the performer's motion from now on."""
        request = _like_request(performer, '', network=network)
        request.like.learn_s = _take_seconds(seconds)
        request.like.measure = True
        return self._ask(request, _like_reply)

    def design(self, performer: Optional[str], sliders: Optional[Mapping[str, float]] = None, *,
               name: str = '', from_: str = '', preset: str = '',
               transition_ms: Optional[float] = None) -> control_pb2.LikeReply:
        """Makes a style by hand, or moves its sliders, and sets the performer to it (None: no
        performer). `sliders`: numbers by the names that list().sliders has, in their units; the
        others keep their value. `name`: by default by-hand- and the performer. A style of that name
        that was made by hand changes at once, without a fade. It begins with the style `from_`, by
        default the made style of that name or a neutral performer; `preset`: the sliders of
        one of list().designs, or of 'neutral', are set first."""
        return self._ask(_design_request(performer, sliders, name, from_, preset, transition_ms),
                         _like_reply)

    def export_style(self, name: str) -> bytes:
        """The file of a style that was made."""
        request = control_pb2.Request()
        request.export_style.name = name
        return self._ask(request, lambda reply: reply.style_file.file)

    def import_style(self, file: str, name: str = '',
                     replace: bool = False) -> control_pb2.LikeReply:
        """Adds the style of such a file, for all clients. `name`: by default the file's own.
        `replace`: replaces a made style of this name; performers that show it fade over."""
        request = control_pb2.Request()
        request.import_style.file = _read_file('import_style', file)
        request.import_style.name = name
        request.import_style.replace = replace
        return self._ask(request, _like_reply)

    def rename_style(self, name: str, to: str) -> Applied:
        """Renames a made style. Performers that show it continue; the result names them."""
        request = control_pb2.Request()
        request.rename_style.name = name
        request.rename_style.to = to
        return self._ask(request, _applied)

    def remove_style(self, name: str) -> Applied:
        """Removes a made style. Performers that show it, named in the result, fade to bypass."""
        request = control_pb2.Request()
        request.remove_style.name = name
        return self._ask(request, _applied)

    def take_checkpoint(self, performer: str) -> bytes:
        """The performer's whole state after the last frame, as a file of stylectl checkpoint."""
        request = _change(performer)
        request.take_checkpoint.SetInParent()
        return self._ask(request, lambda reply: reply.checkpoint.SerializeToString())

    def restore_checkpoint(self, checkpoint: bytes, performer: str = '') -> Applied:
        """Continues a performer from such a state, here or on another daemon of the same weights.
        `performer`: by default the one that the checkpoint names."""
        request = _change(performer) if performer else control_pb2.Request()
        try:
            request.restore_checkpoint.checkpoint.ParseFromString(checkpoint)
        except DecodeError as error:
            raise ValueError('restore_checkpoint: expected bytes of take_checkpoint') from error
        return self._ask(request, _applied)

    def explain(self, performer: str, sequence: int = 0, last: int = 1) -> control_pb2.ExplainReply:
        """The fates of a performer's frames, with their causes: of the frame with a number (Frame.sequence),
        or of the newest ones, up to 1,024. Each has a sentence in `text`."""
        request = control_pb2.Request(performer=performer)
        if sequence:
            _put(request.explain, 'sequence', sequence, 'explain')
        else:
            _put(request.explain, 'last', last, 'explain')
        return self._ask(request, lambda reply: reply.explain)

    def preview(self, style: str) -> control_pb2.PreviewReply:
        """A small moving figure of any style: two strides that loop."""
        request = control_pb2.Request()
        request.preview.style = style
        return self._ask(request, lambda reply: reply.preview)

    def cue(self, name: str) -> Applied:
        """Fires the cues with that name in the daemon's configuration."""
        request = _change(EVERYONE)
        _put(request.cue, 'name', name, 'cue')
        return self._ask(request, _applied)

    def panic(self) -> Applied:
        """Sets all performers to bypass, pinned or not."""
        request = control_pb2.Request(performer=EVERYONE)
        request.panic.SetInParent()
        return self._ask(request, _applied)


class Conversation:
    """Numbers requests, and distinguishes the reply to the last one from replies to earlier ones."""

    def __init__(self) -> None:
        # So that replies to an earlier program do not match.
        self._id = random.getrandbits(48)

    def encode(self, request: control_pb2.Request) -> bytes:
        self._id += 1
        request.id = self._id
        return request.SerializeToString()

    def decode(self, payload: bytes, endpoint: str) -> Optional[control_pb2.Reply]:
        """The reply, or None if it belongs to an earlier request."""
        try:
            reply = control_pb2.Reply.FromString(payload)
        except DecodeError:
            raise Garbled(f'the program at {endpoint} is not a styled daemon') from None
        # A daemon that could not parse the request replies with id 0.
        unread = reply.id == 0 and reply.code != control_pb2.CODE_OK
        if reply.id != self._id and not unread:
            return None
        if reply.code != control_pb2.CODE_OK:
            raise Refused(_code_name(reply.code), reply.reason)
        return reply


def _applied(reply: control_pb2.Reply) -> Applied:
    return Applied(reply.applied)


def _code_name(code: int) -> str:
    known = control_pb2.Code.values()
    return control_pb2.Code.Name(code)[len('CODE_'):] if code in known else f'CODE_{code}'
