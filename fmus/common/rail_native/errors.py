"""Errors of compiling and loading a core."""


class NativeError(Exception):
    """A compiled core cannot be made or loaded."""


class CompileError(NativeError):
    """Functions cannot be compiled to a library that needs no Python."""
