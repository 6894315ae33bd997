#!/usr/bin/env bash
# The C++ listing of the README is, to the letter, the example that the build compiles.
set -euo pipefail
root=$1
listing=$(awk '/^```cpp$/ {on = 1; next} /^```$/ {on = 0} on' "$root/README.md")
diff <(echo "$listing") "$root/bullet_ccd/examples/hello_toi.cpp"
