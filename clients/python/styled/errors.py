"""The errors that a call may raise, and its warnings. Invalid arguments raise ValueError, or TypeError
if they are of another type, with what was expected."""


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
    """The base class of the warnings below: the request was accepted, but has no visible effect."""


class AbsentPerformer(Unseen):
    """No performer of the name in a change or a subscription is present: it waits for that performer."""


class AbsentOutput(Unseen):
    """No performer has the [[output]] that is subscribed to."""


class NoStrength(Unseen):
    """A style was set, but the performer's strength is 0."""


class NotVaried(Unseen):
    """The look asks for a variation, but the performer's style has none and is shown as it is."""


class NotChanged(Unseen):
    """Of a change for everybody: the performer's other settings do not allow it, and stayed as they were."""
