# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Building blocks of the scene generators in `scenes/`."""
