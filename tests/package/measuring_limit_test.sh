#!/usr/bin/env bash
# What measures keeps the limit of lines that benchmarks/README.md states, by the command that it names.
set -euo pipefail
cd "$1"
git rev-parse --is-inside-work-tree >/dev/null 2>&1 || exit 77  # an archive of the sources
page=benchmarks/README.md
limit=$(sed -nE 's/.*must print no more than ([0-9]+),([0-9]+).*/\1\2/p' $page)
command=$(grep -m1 '^git ls-files' $page)
lines=$(bash -o pipefail -c "$command")
echo "$lines lines measure; the limit is $limit"
[ "$lines" -le "$limit" ]
