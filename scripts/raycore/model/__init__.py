# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Golden model of the RTL: the specification that every unit is compared with, bit for bit."""
