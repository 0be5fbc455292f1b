# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""RayCore: scene loading, trees, memory image, reference tracer and command line."""

__version__ = "0.1.0"
