#!/usr/bin/env bash
# A Bullet program outside the tree finds the installed adapter in either precision, builds against
# it and runs; linking both precisions, or compiling for one and linking the other, is refused with
# a message that says so.
set -euo pipefail
source=$1 build=$2
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
fail() {
    echo "$1" >&2
    cat "$scratch/log" >&2
    exit 1
}
cmake --install "$build" --prefix "$scratch/prefix" >/dev/null
# Copied, so that nothing of the source tree is found beside them.
mkdir "$scratch/programs"
cp "$source"/bullet_ccd/examples/bullet_hello_{world,action}.cpp "$scratch/programs"

configure() { # name, options
    local name=$1
    shift
    cmake -S "$source/tests/package/consumer_bullet" -B "$scratch/$name" -G Ninja \
        -DCMAKE_PREFIX_PATH="$scratch/prefix" -DCMAKE_CXX_COMPILER_LAUNCHER= \
        -DPROGRAMS="$scratch/programs" "$@" >"$scratch/log" 2>&1
}
compile() { cmake --build "$scratch/$1" -- -k 0 >"$scratch/log" 2>&1; }

for component in bullet bullet_float64; do
    configure $component -DCOMPONENT=$component || fail "$component is not found"
    compile $component || fail "a program does not build against $component"
    for program in bullet_hello_world bullet_hello_action; do
        "$scratch/$component/$program" >"$scratch/log" || fail "$program fails with $component"
        grep -q 'rests on the ground' "$scratch/log" || fail "$program says something else"
    done
done

if configure both -DCOMPONENT=bullet -DMISTAKE=both_linked; then
    fail "one program may link both precisions"
fi
tr -s '\n ' ' ' <"$scratch/log" | grep -q 'PRECISION property of .* does not agree' ||
    fail "linking both precisions fails without saying why"

for mistake in bullet:btCcdBuiltForDouble bullet_float64:btCcdBuiltForSingle; do
    component=${mistake%:*} symbol=${mistake#*:}
    configure wrong_$component -DCOMPONENT=$component -DMISTAKE=wrong_macro ||
        fail "the consumer is not configured"
    if compile wrong_$component; then
        fail "a program for the other precision links to $component"
    fi
    grep -q "undefined reference to .*$symbol" "$scratch/log" ||
        fail "the wrong precision is refused without saying why"
done
