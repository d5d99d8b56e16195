"""Errors that a person can act on: one message each, naming the place, the value and the way out."""


class InputError(ValueError):
    """Something that was given (a scene, an image, a name) cannot be used as it is."""


class SceneError(InputError):
    """A scene, or one of its records, is not valid."""


class CapacityError(RuntimeError):
    """A ray tree outgrew the room that its plan gave it."""
