#!/usr/bin/env bash
# The layer rule holds, and the checker would notice if it did not.
set -euo pipefail
root=$1
"$root/tools/check_layers.py" "$root"

copy=$(mktemp -d)
trap 'rm -rf "$copy"' EXIT
mkdir -p "$copy/bullet_ccd/mesh" "$copy/bullet_ccd/toi" "$copy/grasp/planner"
echo '#include "bullet_ccd/toi/toi.h"' >"$copy/bullet_ccd/mesh/wrong.h"
echo '#include "bullet_ccd/bullet/btCcdMeshShape.h"' >"$copy/grasp/planner/wrong.cpp"
echo '#include <BulletCollision/btBulletCollisionCommon.h>' >"$copy/bullet_ccd/toi/foreign.cpp"
echo '#include "tests/support/test_data.h"' >"$copy/grasp/planner/test.cpp"
echo '#include "bullet_ccd/mesh/triangle_mesh.h"' >"$copy/bullet_ccd/toi/right.h"
if output=$("$root/tools/check_layers.py" "$copy"); then
    echo "check_layers.py accepted includes that point the wrong way"
    exit 1
fi
[ "$(echo "$output" | wc -l)" -eq 4 ] || { echo "expected four messages, got: $output"; exit 1; }
