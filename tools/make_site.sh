#!/usr/bin/env bash
# Builds the documentation's site into build/site, or into the directory given; a warning is an error.
set -eu
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
out=${1:-$root/build/site}
environment=$root/build/site-environment
[ -x "$environment/bin/mkdocs" ] || {
  python3 -m venv "$environment"
  "$environment/bin/python" -m pip install --disable-pip-version-check -q -r "$root/requirements-docs.txt"
}
exec "$environment/bin/mkdocs" build --quiet --strict -f "$root/mkdocs.yml" -d "$(realpath -m "$out")"
