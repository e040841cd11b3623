"""Errors of a running track."""


class TrackError(RuntimeError):
    """The track cannot go on: the message says where, why and what to do."""
