#!/usr/bin/env bash
# The C++ listings of the READMEs are, to the letter, the examples that are compiled.
set -euo pipefail
root=$1
for pair in README.md=bullet_ccd/examples/hello_toi.cpp grasp/README.md=grasp/examples/hello_grasp.cpp; do
    listing=$(awk '/^```cpp$/ {on = 1; next} /^```$/ {on = 0} on' "$root/${pair%%=*}")
    diff <(echo "$listing") "$root/${pair#*=}"
done
