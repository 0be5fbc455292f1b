# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Settings of the whole test suite: one seed, chosen once, printed, the same in every worker."""
import os
import random

import pytest


def pytest_configure(config):
    # Workers inherit the variable from the controller, so that all of them draw from one seed.
    if not os.environ.get("RAYCORE_SEED"):
        os.environ["RAYCORE_SEED"] = str(random.SystemRandom().randrange(1 << 32))


def pytest_report_header(config):
    return f"RAYCORE_SEED={os.environ['RAYCORE_SEED']} (set it to repeat this run)"


@pytest.fixture
def seed(request) -> int:
    """A seed for this test: from the session's seed and the test's name, so that order and workers do not matter."""
    return random.Random(f"{os.environ['RAYCORE_SEED']}/{request.node.nodeid}").randrange(1 << 32)
