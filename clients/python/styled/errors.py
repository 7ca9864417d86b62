"""The errors that a call may raise. Invalid arguments raise ValueError, with what was expected."""


class Error(Exception):
    """The base class of the errors below."""


class NoAnswer(Error):
    """No reply in time; the change may or may not have been applied."""


class Garbled(Error):
    """The reply did not come from a styled daemon."""


class Refused(Error):
    """The daemon refused, and changed nothing. `code` is the name of a code of control.proto
    ("UNKNOWN_STYLE"); str() is the daemon's reason."""

    def __init__(self, code, reason):
        super().__init__(reason or code)
        self.code = code
