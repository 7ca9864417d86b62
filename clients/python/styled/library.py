"""Motion restyled in this process by libstyled, without a daemon: whole clips, or frame by frame.

    clip = styled.restyle('walk.bvh', 'elderly')          # a file, or a styled.Clip of numpy arrays
    clip.write('elderly.bvh')

Needs numpy, and libstyled.so: the wheel for Linux has it beside this file. All calls that take time
release the GIL. Rotations are quaternions x, y, z, w, relative to the joint's parent.
"""

import ctypes
import os
import weakref
from functools import lru_cache
from typing import List, Mapping, Optional, Sequence, Tuple, Union

from styled.errors import Error

_NAME = 'libstyled.so.0'
_ERROR_TIME = -2
_Style = Union[str, Mapping[str, float]]
_Motion = Union[str, 'os.PathLike[str]', 'Clip']


class LibraryError(Error):
    """A refusal in the words of libstyled, or its absence."""


class _Body(ctypes.Structure):
    _fields_ = [('size', ctypes.c_size_t), ('joint_count', ctypes.c_int), ('names', ctypes.POINTER(ctypes.c_char_p)),
                ('parents', ctypes.POINTER(ctypes.c_int32)), ('offsets', ctypes.POINTER(ctypes.c_float)),
                ('rest', ctypes.POINTER(ctypes.c_float)), ('dialect', ctypes.c_char_p),
                ('joints', ctypes.POINTER(ctypes.c_char_p))]


_HANDLE, _TEXT, _SIZE, _INT = ctypes.c_void_p, ctypes.c_char_p, ctypes.c_size_t, ctypes.c_int
_FLOATS = ctypes.POINTER(ctypes.c_float)
_BODY, _STRINGS = ctypes.POINTER(_Body), ctypes.POINTER(ctypes.c_char_p)
_MIX = [ctypes.POINTER(ctypes.c_int32), _FLOATS, _INT]
_FUNCTIONS = {  # of styled.h: the result, then the arguments
    'version': [_TEXT], 'load': [_HANDLE, _TEXT, _TEXT, _TEXT, _SIZE], 'release': [None, _HANDLE],
    'style_count': [_INT, _HANDLE], 'style_name': [_TEXT, _HANDLE, _INT], 'style_licence': [_TEXT, _HANDLE, _INT],
    'style_credit': [_TEXT, _HANDLE, _INT], 'find_style': [_INT, _HANDLE, _TEXT],
    'create': [_HANDLE, _HANDLE, _BODY, _TEXT, _SIZE], 'destroy': [None, _HANDLE],
    'set': [_INT, _HANDLE, *_MIX, ctypes.c_float],
    'frame': [_INT, _HANDLE, ctypes.c_int64, _FLOATS, _FLOATS, _FLOATS, _FLOATS, ctypes.POINTER(ctypes.c_uint32)],
    'reset': [_INT, _HANDLE], 'calibrate': [_INT, _HANDLE, ctypes.c_float], 'learn': [_INT, _HANDLE, _HANDLE],
    'like': [_HANDLE, _HANDLE, _TEXT, _HANDLE, _HANDLE, _TEXT, _SIZE], 'adopt': [_INT, _HANDLE, _HANDLE],
    'read_clip': [_HANDLE, _TEXT, _STRINGS, _TEXT, _SIZE],
    'make_clip': [_HANDLE, _BODY, ctypes.c_double, _SIZE, _FLOATS, _FLOATS, _TEXT, _SIZE],
    'copy_clip': [_HANDLE, _HANDLE], 'free_clip': [None, _HANDLE], 'clip_body': [_BODY, _HANDLE],
    'clip_length': [_SIZE, _HANDLE, ctypes.POINTER(ctypes.c_double)], 'clip_frames': [_INT, _HANDLE, _FLOATS, _FLOATS],
    'restyle': [_INT, _HANDLE, _HANDLE, *_MIX, _TEXT, _SIZE], 'write_clip': [_INT, _HANDLE, _TEXT, _TEXT, _SIZE],
}


@lru_cache(maxsize=None)
def _library():
    beside = os.path.join(os.path.dirname(os.path.abspath(__file__)), _NAME)
    wanted = os.environ.get('STYLED_LIBRARY') or (beside if os.path.exists(beside) else _NAME)
    try:
        library = ctypes.CDLL(wanted)
    except OSError as error:
        raise LibraryError(f'found no {_NAME} ({error}); expected it from the wheel for Linux, from an installed '
                           'libstyled, or its path in STYLED_LIBRARY') from error
    for name, (result, *arguments) in _FUNCTIONS.items():
        function = getattr(library, 'styled_' + name)
        function.restype, function.argtypes = result, arguments
    return library


@lru_cache(maxsize=None)
def _numpy():
    try:
        import numpy  # pylint: disable=import-outside-toplevel
    except ImportError as error:
        raise LibraryError('restyling in this process needs numpy: pip install numpy, or on Debian '
                           'apt install python3-numpy') from error
    return numpy


def _call(name: str, *arguments):
    """A function whose last arguments are a text for the error and its size."""
    text = ctypes.create_string_buffer(4096)
    result = getattr(_library(), 'styled_' + name)(*arguments, text, len(text))
    if result is None or result < 0:
        raise LibraryError(text.value.decode(errors='replace'))
    return result


def _floats(array):
    return array.ctypes.data_as(_FLOATS)


def _array(values, shape: Tuple[int, ...], what: str):
    array = _numpy().ascontiguousarray(values, dtype=_numpy().float32)
    if array.shape != shape:
        raise ValueError(f'{what}: found shape {array.shape}, expected {shape}')
    return array


def _strings(texts: Sequence[str]):
    return (ctypes.c_char_p * (len(texts) + 1))(*[text.encode() for text in texts], None)


class Network:
    """Loaded weights: a path, the name of shipped ones ('v2', 'open'), None: $STYLED_WEIGHTS, else v2. Any thread."""

    def __init__(self, weights: Optional[str] = None, precision: str = 'float32') -> None:
        path = None if weights is None else os.fsencode(weights)
        self._adopt(_call('load', path, precision.encode()))

    def _adopt(self, handle: int) -> None:
        self._handle = handle
        self._finalizer = weakref.finalize(self, _library().styled_release, handle)
        count = _library().styled_style_count(self._handle)
        self.styles: List[str] = [_library().styled_style_name(self._handle, i).decode() for i in range(count)]

    def like(self, name: str, example: _Motion, neutral: Optional[_Motion] = None) -> 'Network':
        """Another network, with the same styles and the style `name` as a BVH file or a Clip shows it.

        neutral: the same person moves in their own way; then only what differs is the style. Needs weights that
        know more than a list of styles: 'open', not 'v2'."""
        clips = [clip if clip is None or isinstance(clip, Clip) else Clip.read(clip) for clip in (example, neutral)]
        made = Network.__new__(Network)
        made._adopt(_call('like', self._handle, name.encode(), *[clip and clip._handle for clip in clips]))
        return made

    def licence(self, style: str) -> str:
        """The terms under which a style may be used."""
        return _library().styled_style_licence(self._handle, self._find(style)).decode()

    def credit(self, style: str) -> str:
        """The names that a style must be credited to; '' if the weights do not say."""
        return _library().styled_style_credit(self._handle, self._find(style)).decode()

    def _find(self, style: str) -> int:
        number = _library().styled_find_style(self._handle, style.encode())
        if number < 0:
            raise ValueError(f"unknown style '{style}', expected one of {', '.join(self.styles)}")
        return number

    def _mix(self, style: _Style):
        weights = {style: 1.0} if isinstance(style, str) else dict(style)
        numbers = [(self._find(name), weight) for name, weight in weights.items()]
        numbers = [(number, weight) for number, weight in numbers if number != 0]  # neutral adds nothing
        count = len(numbers)
        return ((ctypes.c_int32 * count)(*[number for number, _ in numbers]),
                (ctypes.c_float * count)(*[weight for _, weight in numbers]), count)


@lru_cache(maxsize=4)
def _network(weights: Optional[str], precision: str, _environment: Optional[str]) -> Network:
    return Network(weights, precision)


def network(weights: Optional[str] = None, precision: str = 'float32') -> Network:
    """A Network that is loaded once for all calls."""
    return _network(weights, precision, os.environ.get('STYLED_WEIGHTS'))


class Clip:
    """Recorded motion of one skeleton at a constant rate, F frames of J joints; it does not change.

    root[F, 3] are positions of joint 0, rotations[F, J, 4] the joints' (a single frame may lack the F);
    parents come before their children; rest[J, 4] are world rotations in the T-pose, which is found from
    names and frames without them. joints: those that names do not tell, 'leftUpperArm=LArm'."""

    def __init__(self, names: Sequence[str], parents: Sequence[int], offsets, rate_hz: float, root, rotations,
                 rest=None, joints: Sequence[str] = ()) -> None:
        np, count = _numpy(), len(names)
        root = np.asarray(root, np.float32)
        if root.ndim == 1:
            root, rotations = root[None], np.asarray(rotations, np.float32)[None]
        root = _array(root, (len(root), 3), 'root')
        rotations = _array(rotations, (len(root), count, 4), 'rotations')
        body, _kept = _body(names, parents, offsets, rest, joints)
        self._adopt(_call('make_clip', ctypes.byref(body), rate_hz, len(root), _floats(root), _floats(rotations)))

    @classmethod
    def read(cls, path: Union[str, 'os.PathLike[str]'], joints: Sequence[str] = ()) -> 'Clip':
        """Of a BVH file."""
        return cls._of(_call('read_clip', os.fsencode(path), _strings(joints)))

    @classmethod
    def _of(cls, handle: int) -> 'Clip':
        clip = cls.__new__(cls)
        clip._adopt(handle)
        return clip

    def _adopt(self, handle: int) -> None:
        np, library = _numpy(), _library()
        self._handle = handle
        self._finalizer = weakref.finalize(self, library.styled_free_clip, handle)
        body, rate = library.styled_clip_body(handle).contents, ctypes.c_double()
        frames, joints = library.styled_clip_length(handle, ctypes.byref(rate)), body.joint_count
        self.names: List[str] = [body.names[j].decode() for j in range(joints)]
        self.parents: List[int] = [body.parents[j] for j in range(joints)]
        self.offsets = np.ctypeslib.as_array(body.offsets, (joints, 3)).copy()
        self.rest = np.ctypeslib.as_array(body.rest, (joints, 4)).copy()
        self.rate_hz: float = rate.value
        self.root = np.empty((frames, 3), np.float32)
        self.rotations = np.empty((frames, joints, 4), np.float32)
        library.styled_clip_frames(handle, _floats(self.root), _floats(self.rotations))
        for array in (self.offsets, self.rest, self.root, self.rotations):
            array.flags.writeable = False

    def __len__(self) -> int:
        return len(self.root)

    def restyled(self, style: _Style, by: Optional[Network] = None) -> 'Clip':
        """Another clip, in a style or a mix of up to four, {'elderly': 0.7, 'angry': 0.3}."""
        by = by or network()
        mix = by._mix(style)
        handle = _library().styled_copy_clip(self._handle)
        if handle is None:
            raise MemoryError
        try:
            own_frames = _call('restyle', by._handle, handle, *mix)
        except LibraryError:
            _library().styled_free_clip(handle)
            raise
        made = Clip._of(handle)
        made.own_frames = own_frames
        return made

    #: Of a restyled clip: how many frames are the performer's own, because no sound pose was found.
    own_frames: int = 0

    def positions(self):
        """Where the joints are, [F, J, 3], in the clip's axes."""
        np = _numpy()
        places = np.empty((len(self), len(self.names), 3), np.float32)
        turns = np.empty_like(self.rotations)
        places[:, 0], turns[:, 0] = self.root, self.rotations[:, 0]
        for joint, parent in enumerate(self.parents[1:], 1):
            places[:, joint] = places[:, parent] + _turned(np, turns[:, parent], self.offsets[joint])
            turns[:, joint] = _product(np, turns[:, parent], self.rotations[:, joint])
        return places

    def write(self, path: Union[str, 'os.PathLike[str]']) -> None:
        """As a BVH file, with the channels of the one that it was read from."""
        _call('write_clip', self._handle, os.fsencode(path))


def _product(np, a, b):
    xyz = a[..., 3:] * b[..., :3] + b[..., 3:] * a[..., :3] + np.cross(a[..., :3], b[..., :3])
    return np.concatenate([xyz, a[..., 3:] * b[..., 3:] - (a[..., :3] * b[..., :3]).sum(-1, keepdims=True)], -1)


def _turned(np, q, v):
    across = 2 * np.cross(q[..., :3], v)
    return v + q[..., 3:] * across + np.cross(q[..., :3], across)


def _body(names, parents, offsets, rest, joints):
    """A styled_body, and what must live as long."""
    count = len(names)
    offsets = _array(offsets, (count, 3), 'offsets')
    rest = None if rest is None else _array(rest, (count, 4), 'rest')
    kept = (_strings(names), (ctypes.c_int32 * count)(*parents), offsets, rest, _strings(joints))
    return _Body(ctypes.sizeof(_Body), count, kept[0], kept[1], _floats(offsets),
                 None if rest is None else _floats(rest), None, kept[4]), kept


class Performer:
    """One stream of poses of one skeleton, restyled frame by frame as a daemon does. One thread at a time."""

    def __init__(self, skeleton: Clip, style: _Style = 'neutral', by: Optional[Network] = None) -> None:
        """skeleton: a clip of the same skeleton; its frames are not used (learn() uses them)."""
        self._network = by or network(precision='int8')
        self._handle = _call('create', self._network._handle, _library().styled_clip_body(skeleton._handle))
        self._finalizer = weakref.finalize(self, _library().styled_destroy, self._handle)
        self._joints = len(skeleton.names)
        self.set(style, 0)

    def set(self, style: _Style, transition_s: float = 0.1) -> None:
        """From the next frame on, faded in."""
        if _library().styled_set(self._handle, *self._network._mix(style), transition_s) != 0:
            raise ValueError('style: expected at most 4, with weights of 0 to 1.5 that sum to at most 1.5, '
                             f'and a transition of 0 to 60 s; found {style!r}, {transition_s!r}')

    def frame(self, time_s: float, root, rotations):
        """root[3], rotations[J, 4] at a time after the last frame's: the same, restyled, as new arrays."""
        root = _array(root, (3,), 'root').copy()
        rotations = _array(rotations, (self._joints, 4), 'rotations').copy()
        result = _library().styled_frame(self._handle, round(time_s * 1e9), _floats(root), _floats(rotations),
                                         _floats(root), _floats(rotations), None)
        if result != 0:
            raise ValueError(f'time_s: found {time_s}, expected ' + (
                "a time after the last frame's" if result == _ERROR_TIME else 'less than 73 years'))
        return root, rotations

    def adopt(self, by: Network) -> None:
        """The motion continues by a network that like() has made from the performer's; set() then takes its styles."""
        if _library().styled_adopt(self._handle, by._handle) != 0:
            raise ValueError("adopt: expected a network that like() has made from the performer's")
        self._network = by

    def reset(self) -> None:
        """Before another take: the next frame's time may be anything."""
        _library().styled_reset(self._handle)

    def calibrate(self, seconds: float) -> None:
        """For 1 to 60 s from now on the performer stands and walks in their own way; 0: that is forgotten."""
        if _library().styled_calibrate(self._handle, seconds) != 0:
            raise ValueError(f'seconds: found {seconds}, expected 0, or 1 to 60')

    def learn(self, clip: Clip) -> None:
        """The performer's own way to stand and walk, from a clip of the same person."""
        if _library().styled_learn(self._handle, clip._handle) != 0:
            raise LibraryError('learn: found no standing or walking in the clip, or weights that need none')


def restyle(clip: _Motion, style: _Style, *, weights: Optional[str] = None,
            precision: str = 'float32', joints: Sequence[str] = ()) -> Clip:
    """A BVH file or a Clip in a style, as the program `stylize` does it; the input does not change.

    style: a name, or a mix {'elderly': 0.7, 'angry': 0.3}. weights: as in Network; they are loaded once."""
    if not isinstance(clip, Clip):
        clip = Clip.read(clip, joints)
    return clip.restyled(style, network(weights, precision))


def library_version() -> str:
    """libstyled's."""
    return _library().styled_version().decode()


__all__ = ['Clip', 'LibraryError', 'Network', 'Performer', 'library_version', 'network', 'restyle']
