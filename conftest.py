# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Settings of the whole test suite: one seed, chosen once, printed, the same in every worker."""
import os
import random
import re

import pytest


def pytest_configure(config):
    # Workers inherit the variable from the controller, so that all of them draw from one seed.
    if not os.environ.get("RAYCORE_SEED"):
        os.environ["RAYCORE_SEED"] = str(random.SystemRandom().randrange(1 << 32))


# Builds of the same tests with other latencies, beside those that always run: only with RAYCORE_ALL_BUILDS=1, as `make sim` has it.
MORE_BUILDS = re.compile(
    r"test_rc_(through|hitpoint|accum|light|raygen)\[(odd|one)\]|test_rc_shade\[long\]"
    r"|test_rc_secondary\[(odd-5|one-32|paper-2)\]|test_rc_texture\[(one|long)\]"
)


def pytest_collection_modifyitems(config, items):
    if os.environ.get("RAYCORE_ALL_BUILDS", "0") in ("", "0"):
        more = [i for i in items if MORE_BUILDS.search(i.nodeid)]
        items[:] = [i for i in items if not MORE_BUILDS.search(i.nodeid)]
        config.hook.pytest_deselected(items=more)


def pytest_report_header(config):
    return f"RAYCORE_SEED={os.environ['RAYCORE_SEED']} (set it to repeat this run)"


@pytest.fixture
def seed(request) -> int:
    """A seed for this test: from the session's seed and the test's name, so that order and workers do not matter."""
    return random.Random(f"{os.environ['RAYCORE_SEED']}/{request.node.nodeid}").randrange(1 << 32)
