#!/bin/sh
# Compare in an environment of its own, made on first use: run.sh [DATA] [--seeds N] [--sets NAME...] [--json FILE]
set -eu
here=$(cd "$(dirname "$0")" && pwd)
venv=${TWO_STAGE_VENV:-$here/.venv}
[ -x "$venv/bin/python" ] || python3 -m venv "$venv"
"$venv/bin/pip" install -q -e "$here/../.." -r "$here/requirements.txt"
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
exec "$venv/bin/python" "$here/compare.py" "$@"
