#!/usr/bin/env bash
# The libraries and programs pass the checks of .clang-tidy. Configures the project anew, with the
# sources of a folder joined, and compiles nothing.
#   clang_tidy_test.sh SOURCE
set -euo pipefail
source=$1
if ! command -v run-clang-tidy-16 >/dev/null; then
    echo "skipped: run-clang-tidy-16 is missing; tools/install_dependencies --all installs it"
    exit 77
fi
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cmake -S "$source" --preset check -B "$scratch/build" -DBULLET_CCD_PRECOMPILED_HEADERS=OFF \
    -DBULLET_CCD_TESTS=OFF -DBULLET_CCD_BENCHMARKS=OFF >/dev/null
# Left out are files that only include a header, to verify that it needs no other, and the kernels,
# which use functions of GCC that Clang does not have.
if ! run-clang-tidy-16 -quiet -p "$scratch/build" -j "$(nproc)" \
    -extra-arg=-Wno-unknown-warning-option \
    '^(?!.*(verify_interface_header_sets|/kernels/)).*\.cpp$' >"$scratch/log" 2>&1; then
    grep -E 'warning:|error:' "$scratch/log" | sort -u
    exit 1
fi
[ "$(grep -c '^clang-tidy' "$scratch/log")" -gt 30 ] || { echo "too few files were looked at"; exit 1; }
