#!/usr/bin/env bash
# The layer rule holds, and the checker would notice if it did not.
set -euo pipefail
root=$1
"$root/tools/check_layers.py" "$root"

copy=$(mktemp -d)
trap 'rm -rf "$copy"' EXIT
mkdir -p "$copy"/bullet_ccd/{mesh,toi,examples} "$copy"/grasp/planner "$copy"/robots/shapes \
    "$copy"/tools/grasp_cli/plan "$copy"/benchmarks/{unknown,rigid,reference/scenes} "$copy"/tests/toi
echo '#include "bullet_ccd/toi/toi.h"' >"$copy/bullet_ccd/mesh/wrong.h"
echo '#include "bullet_ccd/bullet/btCcdMeshShape.h"' >"$copy/grasp/planner/wrong.cpp"
echo '#include <BulletCollision/btBulletCollisionCommon.h>' >"$copy/bullet_ccd/toi/foreign.cpp"
echo '#include "tests/support/test_data.h"' >"$copy/grasp/planner/test.cpp"
echo '#include "tests/support/test_data.h"' >"$copy/bullet_ccd/examples/test.cpp"
echo '#include "tests/support/test_data.h"' >"$copy/benchmarks/rigid/test.cpp"
echo '#include <gtest/gtest.h>' >"$copy/benchmarks/reference/scenes/test.cpp"
echo '#include "benchmarks/support/timing.h"' >"$copy/benchmarks/reference/scenes/wrong.cpp"
echo '#include "benchmarks/rigid/rigid_run.h"' >"$copy/tools/grasp_cli/wrong.cpp"
echo '#include "tools/support/text_file.h"' >"$copy/robots/shapes/wrong.cpp"
echo '#include "tools/ccd_cli/files/query_file.h"' >"$copy/tools/grasp_cli/other.cpp"
echo '#include <CLI/CLI.hpp>' >"$copy/tools/grasp_cli/plan/options.cpp"
echo '#include <BulletCollision/btBulletCollisionCommon.h>' >"$copy/benchmarks/rigid/foreign.cpp"
echo '#include "bullet_ccd/toi/toi.h"' >"$copy/benchmarks/unknown/room.cpp"
touch "$copy"/tests/toi/full_{01..26}.cpp
echo '#include "bullet_ccd/mesh/triangle_mesh.h"' >"$copy/bullet_ccd/toi/right.h"
echo '#include "bullet_ccd/bullet/btCcdAction.h"' >"$copy/bullet_ccd/examples/right.cpp"
echo '#include "benchmarks/reference/scenes/random.h"' >"$copy/tools/grasp_cli/right.cpp"
echo '#include "benchmarks/rigid/rigid_run.h"' >"$copy/tests/toi/right.cpp"
if output=$("$root/tools/check_layers.py" "$copy"); then
    echo "check_layers.py accepted includes that point the wrong way"
    exit 1
fi
[ "$(echo "$output" | wc -l)" -eq 15 ] || { echo "expected fifteen messages, got: $output"; exit 1; }
