# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""Exceptions of Octant: one class for each exit code of the command line."""


class Error(Exception):
    """Base of all failures. `exit` is the command line's exit code, `result` the object that `--json` would print."""

    exit = 1

    def __init__(self, message, result=None):
        super().__init__(message)
        self.result = result or {}
        error = self.result.get("error") or {}
        self.code = error.get("code")
        self.file = error.get("file")
        self.line = error.get("line")
        self.column = error.get("column")
        self.found = error.get("found")
        self.expected = error.get("expected")
        self.advice = error.get("advice")


class UsageError(Error):
    """Wrong usage (2)."""

    exit = 2


class InputError(Error):
    """Bad input: `file`, `line`, `column`, what was `found` and `expected` (3)."""

    exit = 3


class NotConverged(Error):
    """The solver did not converge (4)."""

    exit = 4


class Undetermined(Error):
    """The data do not determine the result; `advice` names the measurement that would determine it (5)."""

    exit = 5


class Contradicted(Error):
    """The data contradict the site file, or a gate failed (6)."""

    exit = 6


class Interrupted(Error):
    """Interrupted; nothing was written (130)."""

    exit = 130


_BY_EXIT = {c.exit: c for c in (Error, UsageError, InputError, NotConverged, Undetermined, Contradicted, Interrupted)}


def raise_failure(result):
    """Raises the exception of a result whose status is no success."""
    error = result.get("error") or {}
    message = error.get("message") or result.get("status") or "a fault of octant"
    if error.get("advice") and error["advice"] not in message:
        message += "; " + error["advice"]
    raise _BY_EXIT.get(error.get("exit"), Error)(message, result) from None
