#!/usr/bin/env bash
# The project as shared libraries: it links, with what it shows and nothing more, and the tests of the
# package and of Debian packages made of it pass. Builds beside BUILD, in BUILD-shared, so that a second run is fast.
#   shared_test.sh SOURCE BUILD [CMAKE_OPTION...]
set -euo pipefail
source=$1 build=$2-shared
shift 2
cmake -S "$source" -B "$build" -G Ninja -DBUILD_SHARED_LIBS=ON -DBULLET_CCD_TESTS=OFF \
    -DBULLET_CCD_BENCHMARKS=OFF "$@" >/dev/null
packs=$(grep -c '^BULLET_CCD_PYTHON:BOOL=ON' "$build/CMakeCache.txt" || true)
targets=(libraries programs)
[ "$packs" -eq 0 ] || targets+=(python manuals)
cmake --build "$build" --target "${targets[@]}"
# A private function is hidden, a public one is not, and the name of the library has its version.
core=$build/bullet_ccd/libbullet_ccd_core.so
nm -DC --defined-only "$core" >"$build/symbols"
grep -q ' T bullet_ccd::rigidToi(' "$build/symbols"
if grep ' T bullet_ccd::segmentToSegment(' "$build/symbols"; then
    echo "a private function is visible"
    exit 1
fi
readelf -d "$core" | grep -qE 'SONAME.*libbullet_ccd_core\.so\.[0-9]+\.[0-9]+\]'
"$source/tests/package/consumer_test.sh" "$source" "$build"
"$source/tests/package/consumer_bullet_test.sh" "$source" "$build"
[ "$packs" -eq 0 ] || "$source/tests/package/packages_test.sh" "$source" "$build"
