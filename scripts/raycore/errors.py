# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""What can be wrong with a user's input. Each message is one line: what, where, what to do."""


class RayCoreError(Exception):
    """Base of all errors that the command line shows as one line and a non-zero exit."""


class SceneError(RayCoreError):
    """A scene that cannot be loaded or does not fit the hardware."""


class OptionError(RayCoreError):
    """An option or argument that makes no sense."""


class OutputError(RayCoreError):
    """A result that cannot be written."""


class SimError(RayCoreError):
    """A simulation that did not end well."""
