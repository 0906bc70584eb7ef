#!/bin/sh
# Runs a command with the variables that name the tools: with-tools.sh COMMAND ...
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
: "${MIDSHELL_GMSH:=$root/.venv/bin/gmsh}"
: "${MIDSHELL_PYTHON:=$root/.venv/bin/python3}"
export MIDSHELL_GMSH MIDSHELL_PYTHON
if ! command -v ccx >/dev/null 2>&1; then
    echo "ccx (CalculiX) is not installed: tests that solve with it are skipped" >&2
    export MIDSHELL_SKIP_CCX=1
fi
exec "$@"
