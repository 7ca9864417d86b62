"""Keys of ZeroMQ's CURVE, for daemons that are reached over a network instead of loopback."""

import dataclasses
from typing import Optional, Union

import zmq
import zmq.utils.z85

Key = Union[str, bytes]


def _check(name: str, key: Key) -> bytes:
    key = key.encode() if isinstance(key, str) else bytes(key)
    if len(key) == 32:
        return zmq.utils.z85.encode(key)
    if len(key) != 40:
        raise ValueError(f'{name}: {len(key)} bytes, expected 40 characters of Z85 or 32 bytes')
    try:
        zmq.utils.z85.decode(key)
    except (KeyError, ValueError):
        raise ValueError(f'{name}: not Z85 (rfc.zeromq.org/spec/32)') from None
    return key


@dataclasses.dataclass(frozen=True)
class Curve:
    """The daemon's public key and the client's key pair. A missing pair is generated. That suffices for
    a daemon that admits every client that knows its key, but not for one with a list of clients."""
    server_key: Key
    public_key: Optional[Key] = None
    secret_key: Optional[Key] = None

    def __post_init__(self) -> None:
        for name in ('server_key', 'public_key', 'secret_key'):
            key = getattr(self, name)
            if key is None and name != 'server_key':
                continue
            if not isinstance(key, (str, bytes, bytearray)):
                raise TypeError(f'curve: {name} is {key!r}, expected 40 characters of Z85 or 32 bytes')
            _check(f'curve: {name}', key)
        if (self.public_key is None) != (self.secret_key is None):
            raise ValueError('curve: one key of the own pair is missing, expected both or none')

    def apply(self, socket: zmq.Socket) -> None:
        public, secret = self.public_key, self.secret_key
        if public is None:
            public, secret = zmq.curve_keypair()
        socket.curve_serverkey = _check('curve: server_key', self.server_key)
        socket.curve_publickey = _check('curve: public_key', public)
        socket.curve_secretkey = _check('curve: secret_key', secret)
