#!/usr/bin/env bash
# Installs the build into a scratch prefix; a project outside the tree finds, builds against and runs
# it, and the installed program finds its robots and objects by name.
set -euo pipefail
source=$1 build=$2
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cmake --install "$build" --prefix "$scratch/prefix" >/dev/null
cmake -S "$source/tests/package/consumer" -B "$scratch/consumer" -G Ninja \
    -DCMAKE_PREFIX_PATH="$scratch/prefix" -DCMAKE_CXX_COMPILER_LAUNCHER= >/dev/null
cmake --build "$scratch/consumer"
"$scratch/consumer/consumer"
share=$scratch/prefix/share/bullet_ccd
"$scratch/consumer/hello_grasp" "$share/robots/parallel_gripper/parallel_gripper.urdf" \
    "$share/objects/can.obj"
"$scratch/prefix/bin/grasp" plan --hand parallel_gripper --object can -n 2 --pictures 0 -q \
    -o "$scratch/out"
