#!/usr/bin/env bash
# tests/python/run.sh MODULES PROGRAM: the tests of `import limberg`, whose package lies in the folder MODULES. Skipped (77) where
# it was not built, or from other sources than the program.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
skip() { printf 'limberg_in_python: Skipped\n%s\n' "$*"; exit 77; }
[ -f "$1/limberg/__init__.py" ] || skip "needs Python's module, which ./do python builds"
export PYTHONPATH=$1 LIMBERG_PROGRAM=$2
python=/usr/bin/python3
"$python" -c 'import numpy' 2>/dev/null || skip "needs NumPy (Debian: python3-numpy)"
module=$("$python" -c 'import limberg; print(limberg.program_name())')
[ "$module" = "$("$LIMBERG_PROGRAM" --version)" ] ||
  skip "the module is $module and the program $("$LIMBERG_PROGRAM" --version): ./do python builds it anew"
exec "$python" "$here/test_limberg.py"
