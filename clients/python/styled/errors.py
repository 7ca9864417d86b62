"""The errors that a call may raise, and its warnings. Invalid arguments raise ValueError, or TypeError
where they are of another type, with what was expected."""


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


class Unseen(UserWarning):
    """The base class of the warnings below: what was asked for is accepted, and there is nothing to be
    seen of it."""


class AbsentPerformer(Unseen):
    """Nobody performs under the name that a change or a subscription is for: it waits until they come."""


class AbsentOutput(Unseen):
    """No performer has the [[output]] that is subscribed to."""


class NoStrength(Unseen):
    """A style was set, but the performer's strength is 0."""
