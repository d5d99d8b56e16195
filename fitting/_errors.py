"""Errors of a fit that a person can act on."""

from diffwhitted._errors import InputError


class FitError(InputError):
    """The targets, the free names or the options of a fit cannot be used as they are."""
