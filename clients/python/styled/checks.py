"""Checks the arguments of Subscriber and Control. Each refusal names the argument, the value that was
found and what was expected: ValueError, or TypeError for another type."""

import math
import re
from typing import Any, Iterable, List, Optional, Union

from styled.curve import Curve

_LONGEST_MS = 1 << 30  # of one wait: twelve days
_MOST_MESSAGES = (1 << 31) - 1
_TCP = re.compile(r'tcp://(\S+;)?(?P<host>\[[^]\s]+\]|[^\s/:*]+):(?P<port>[0-9]{1,5})')
_IPC = re.compile(r'ipc://.+')


def endpoint(found: Any, usual: str, name: str = 'endpoint') -> str:
    expected = f'expected e.g. {usual} or ipc://PATH'
    if not isinstance(found, str):
        raise TypeError(f'{name} is {found!r}, {expected}')
    tcp = _TCP.fullmatch(found)
    if not (tcp and 0 < int(tcp['port']) < 65536) and not _IPC.fullmatch(found):
        raise ValueError(f"cannot connect to {name} '{found}', {expected}")
    return found


def endpoints(found: Union[str, Iterable[str]], usual: str) -> List[str]:
    if isinstance(found, str):
        found = [found]
    if isinstance(found, bytes) or not isinstance(found, Iterable):
        raise TypeError(f'endpoints is {found!r}, expected one or several, e.g. {usual}')
    all_of_them = [endpoint(one, usual, 'endpoints') for one in found]
    if not all_of_them:
        raise ValueError(f'endpoints has none, expected one or several, e.g. {usual}')
    return all_of_them


def yes_or_no(name: str, found: Any) -> bool:
    if not isinstance(found, bool):
        raise TypeError(f'{name} is {found!r}, expected True or False')
    return found


def messages(name: str, found: Any) -> int:
    if not hasattr(found, '__index__') or isinstance(found, bool):
        raise TypeError(f'{name} is {found!r}, expected a whole number, 1 or more')
    if not 1 <= found <= _MOST_MESSAGES:
        raise ValueError(f'{name} is {found}, expected 1 to {_MOST_MESSAGES}')
    return int(found)


def curve(found: Any) -> Optional[Curve]:
    if found is not None and not isinstance(found, Curve):
        raise TypeError(f'curve is {found!r}, expected a styled.Curve, or None')
    return found


def seconds_above_0(name: str, found: Any) -> float:
    value = _seconds(name, found, 'expected seconds above 0')
    if not 0 < value < math.inf:
        raise ValueError(f'{name} is {found} s, expected above 0 and finite')
    return value


def seconds_or_none(name: str, found: Any) -> Optional[float]:
    """None means without end, and so does infinity. A value below 0 counts as 0: the deadline has
    passed."""
    if found is None:
        return None
    value = _seconds(name, found, 'expected seconds, or None: without end')
    if math.isnan(value):
        raise ValueError(f'{name} is {found}, expected seconds, or None: without end')
    return None if value == math.inf else max(0.0, value)


def _seconds(name: str, found: Any, expected: str) -> float:
    if isinstance(found, (bool, str, bytes)) or not hasattr(found, '__float__'):
        raise TypeError(f'{name} is {found!r}, {expected}')
    return float(found)


def milliseconds(seconds: float) -> int:
    """For a poll of ZeroMQ, which accepts only an int of the machine's size."""
    return math.ceil(min(_LONGEST_MS, max(0.0, 1000 * seconds)))
