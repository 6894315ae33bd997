#!/usr/bin/env bash
# The Debian packages of a build with shared libraries, unpacked into a root of their own: names and
# dependencies are as documented, and the programs, the Python package, a project that finds the
# library by CMake and one that does by pkg-config work from there.
#   packages_test.sh SOURCE BUILD
set -euo pipefail
source=$1 build=$2
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cpack --config "$build/CPackConfig.cmake" -B "$scratch/packages" >"$scratch/log" 2>&1 ||
    { cat "$scratch/log"; exit 1; }
root=$scratch/root
for name in libbullet-ccd0 libbullet-ccd-dev bullet-ccd-tools python3-bullet-ccd; do
    file=$(ls "$scratch/packages/${name}_"*.deb)
    [ "$(dpkg-deb -f "$file" Package)" = "$name" ]
    dpkg-deb -x "$file" "$root"
    if [ $name != libbullet-ccd0 ]; then
        dpkg-deb -f "$file" Depends | grep -q 'libbullet-ccd0 (= '
    else
        dpkg-deb -f "$file" Depends | grep -q 'libtbb'
    fi
done
# No file is in two packages: the sum of their files is what is in the root.
for file in "$scratch"/packages/*.deb; do
    dpkg-deb -c "$file" | awk '$1 !~ /^d/ { print $6 }'
done | sort | uniq -d | { ! grep .; }

lib=$(dirname "$(find "$root/usr/lib" -name 'libbullet_ccd_core.so')")
export LD_LIBRARY_PATH=$lib
"$root/usr/bin/grasp" plan --hand parallel_gripper --object can -n 2 --pictures 0 -q -o "$scratch/out"
"$root/usr/bin/bullet-ccd" toi "$root/usr/share/bullet_ccd/objects/can.obj" \
    "$root/usr/share/bullet_ccd/objects/can.obj" --a-velocity 1,0,0 | grep -qi overlap

/usr/bin/python3 - "$root" <<'EOF'
import sys
sys.path.insert(0, sys.argv[1] + "/usr/lib/python3/dist-packages")
import bullet_ccd
mesh = bullet_ccd.Mesh.load(sys.argv[1] + "/usr/share/bullet_ccd/objects/can.obj")
assert bullet_ccd.distance(mesh, mesh).distance == 0
assert bullet_ccd.__file__.startswith(sys.argv[1])
EOF

export PKG_CONFIG_PATH=$lib/pkgconfig
read -ra flags <<<"$(pkg-config --cflags --libs bullet_ccd-core)"
c++ "$source/bullet_ccd/examples/hello_toi.cpp" -O1 "${flags[@]}" -o "$scratch/hello"
"$scratch/hello"
for component in io bullet bullet_float64 grasp grasp_sim; do
    pkg-config --exists --print-errors bullet_ccd-$component
done

# The projects of the tutorial, as they stand on the page; what they are called stands in project().
listings() {
    awk -v kind="$1" -v number="$2" '$0 == "```" kind { on = ++count == number; next } /^```$/ { on = 0 } on' \
        "$source/docs/tutorial.md"
}
mkdir -p "$scratch"/tutorial/{hello,files,falling}
cp "$source/bullet_ccd/examples/hello_toi.cpp" "$scratch/tutorial/hello/hello.cpp"
listings cpp 1 >"$scratch/tutorial/files/files.cpp"
cp "$source/bullet_ccd/examples/bullet_hello_world.cpp" "$scratch/tutorial/falling"
number=0
for project in hello files falling; do
    listings cmake $((++number)) >"$scratch/tutorial/$project/CMakeLists.txt"
    cmake -S "$scratch/tutorial/$project" -B "$scratch/tutorial/$project/build" -G Ninja -DCMAKE_PREFIX_PATH="$root/usr" >/dev/null
    cmake --build "$scratch/tutorial/$project/build" >/dev/null
    (cd "$root/usr/share/bullet_ccd/objects" && "$scratch/tutorial/$project/build/$project" >"$scratch/tutorial/$project/out")
done
grep -q '^contact at t = ' "$scratch/tutorial/hello/out"
grep -q '^free until t = 0\.[0-9]*$' "$scratch/tutorial/files/out"
grep -q '^at (.*gap [0-9.e-]* m$' "$scratch/tutorial/files/out"
# The same world in double precision.
sed -i 's/COMPONENTS bullet)/COMPONENTS bullet_float64)/; s/bullet_ccd::bullet)/bullet_ccd::bullet_float64)/' \
    "$scratch/tutorial/falling/CMakeLists.txt"
cmake -S "$scratch/tutorial/falling" -B "$scratch/tutorial/falling/double" -G Ninja -DCMAKE_PREFIX_PATH="$root/usr" >/dev/null
cmake --build "$scratch/tutorial/falling/double" >/dev/null && "$scratch/tutorial/falling/double/falling" >/dev/null

cmake -S "$source/tests/package/consumer" -B "$scratch/consumer" -G Ninja \
    -DCMAKE_PREFIX_PATH="$root/usr" >/dev/null
cmake --build "$scratch/consumer" >/dev/null
"$scratch/consumer/consumer"

# Manual pages, one for each verb.
if command -v help2man >/dev/null; then
    grep -q '^bullet-ccd-toi ' "$root/usr/share/man/man1/bullet-ccd-toi.1"
    grep -q '^\.SH OPTIONS' "$root/usr/share/man/man1/grasp-hand-show.1"
fi

# Completion: verbs, and options of a verb.
PATH=$root/usr/bin:$PATH
. "$root/usr/share/bash-completion/completions/grasp"
complete_line() {
    COMP_WORDS=("$@")
    COMP_CWORD=$(($# - 1))
    COMPREPLY=()
    _bullet_ccd
    echo "${COMPREPLY[*]}"
}
[ "$(complete_line grasp pl)" = plan ]
complete_line grasp plan --cand | grep -qx -- --candidates
complete_line bullet-ccd toi --a-v | grep -q -- --a-velocity
