#!/usr/bin/env bash
# What was built is installed: of a project of which only the core was built, the core is found and
# any other component is said to be missing. Who builds the programs brings all libraries up to date
# that are installed with them. Configures the project anew, and compiles nothing.
#   partial_install_test.sh SOURCE CORE_LIBRARY
set -euo pipefail
source=$1 core=$2
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cmake -S "$source" -B "$scratch/build" -G Ninja -DBULLET_CCD_TESTS=OFF -DBULLET_CCD_BENCHMARKS=OFF \
    -DCMAKE_BUILD_TYPE=Release >/dev/null
ninja -C "$scratch/build" -t commands programs >"$scratch/log"
for library in core io bullet bullet_float64; do
    grep -q " qc bullet_ccd/.*libbullet_ccd_$library\.a" "$scratch/log" ||
        { echo "the target programs leaves out the library $library, which is installed"; exit 1; }
done
cp "$core" "$scratch/build/bullet_ccd/"
cmake --install "$scratch/build" --prefix "$scratch/prefix" >"$scratch/log"
for component in io bullet bullet_float64 grasp grasp_sim; do
    grep -q "Not built, so not installed: component $component\$" "$scratch/log" ||
        { echo "component $component is not said to be missing"; exit 1; }
done
mkdir "$scratch/consumer"
cat >"$scratch/consumer/CMakeLists.txt" <<'EOF'
cmake_minimum_required(VERSION 3.25)
project(consumer LANGUAGES CXX)
find_package(bullet_ccd REQUIRED COMPONENTS ${WANTED})
if(NOT TARGET bullet_ccd::core)
    message(FATAL_ERROR "no core")
endif()
EOF
find_wanted() {
    cmake -S "$scratch/consumer" -B "$scratch/$1" -DCMAKE_PREFIX_PATH="$scratch/prefix" -DWANTED="$1" 2>&1
}
find_wanted core >/dev/null
for component in io bullet; do
    if find_wanted $component >"$scratch/log"; then
        echo "component $component is found, though it was not built"
        exit 1
    fi
    tr -s '\n ' ' ' <"$scratch/log" | grep -q "component $component was not installed: build" ||
        { echo "that $component is missing is not said:"; cat "$scratch/log"; exit 1; }
done
