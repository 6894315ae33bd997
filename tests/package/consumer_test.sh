#!/usr/bin/env bash
# Installs the build into a scratch prefix; the installed headers include no private ones; a project
# outside the tree finds, builds against and runs it, also compiled with -march=native; the installed
# program finds its robots and objects by name.
set -euo pipefail
source=$1 build=$2
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cmake --install "$build" --prefix "$scratch/prefix" >/dev/null
include=$scratch/prefix/include/bullet-ccd
grep -rhoE '#include ["<](bullet_ccd|grasp)/[^">]+' "$include" | sed -E 's/.*["<]//' | sort -u |
    while read -r header; do
        [ -f "$include/$header" ] || { echo "a public header includes $header, a private one"; exit 1; }
    done
cmake -S "$source/tests/package/consumer" -B "$scratch/consumer" -G Ninja \
    -DCMAKE_PREFIX_PATH="$scratch/prefix" -DCMAKE_CXX_COMPILER_LAUNCHER= >/dev/null
cmake --build "$scratch/consumer"
"$scratch/consumer/consumer"
"$scratch/consumer/consumer_native"
share=$scratch/prefix/share/bullet_ccd
"$scratch/consumer/hello_grasp" "$share/robots/parallel_gripper/parallel_gripper.urdf" \
    "$share/objects/can.obj"
# STL is read by a program of the package. What is installed finds it; a program elsewhere that links
# the library statically says what to do, and finds it at its side.
{
    echo solid
    awk '/^v / { corner[++n] = "vertex " $2 " " $3 " " $4 }
         /^f / { print "facet normal 0 0 0\nouter loop"
                 print corner[$2 + 0] "\n" corner[$3 + 0] "\n" corner[$4 + 0]
                 print "endloop\nendfacet" }' "$share/objects/can.obj"
    echo endsolid
} >"$scratch/can.stl"
hello() {
    "$scratch/consumer/hello_grasp" "$share/robots/parallel_gripper/parallel_gripper.urdf" \
        "$scratch/can.stl" 2>&1
}
if message=$(BULLET_CCD_MESH_READER=/none hello) || [[ $message != *"convert the mesh to OBJ"* ]]; then
    echo "without its mesh reader a program does not say what to do: $message"
    exit 1
fi
cp "$scratch/prefix/libexec/bullet_ccd/bullet_ccd_mesh_reader" "$scratch/consumer"
hello
"$scratch/prefix/bin/grasp" plan --hand parallel_gripper --object "$scratch/can.stl" -n 1 \
    --pictures 0 -q -o "$scratch/stl"
"$scratch/prefix/bin/grasp" plan --hand parallel_gripper --object can -n 2 --pictures 0 -q \
    -o "$scratch/out"
