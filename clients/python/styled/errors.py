"""What a call may raise. Wrong arguments raise ValueError, with what was expected."""


class Error(Exception):
    """All of the errors below."""


class NoAnswer(Error):
    """Nobody answered in time; the change may or may not have been applied."""


class Garbled(Error):
    """Something answered that is no styled daemon."""


class Refused(Error):
    """The daemon said no, and changed nothing. `code` as of control.proto, by name
    ("UNKNOWN_STYLE"); str() is the daemon's reason."""

    def __init__(self, code, reason):
        super().__init__(reason or code)
        self.code = code
