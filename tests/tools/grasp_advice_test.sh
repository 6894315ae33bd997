#!/usr/bin/env bash
# A plan of which few candidates hold says what to look at, by its rejections; one that holds sorts
# its force closures into classes.
#
#   grasp_advice_test.sh GRASP
set -uo pipefail
grasp=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export BULLET_CCD_CACHE=
plan() {
    "$grasp" plan --hand parallel_gripper -n 8 --pictures 0 --models 0 -o "$folder/out" "$@" 2>/dev/null
}
expect() {
    grep -q "$1" <<<"$said" || {
        echo "missing: $1; said: $said" >&2
        exit 1
    }
}
refuse() {
    grep -q "$1" <<<"$said" && {
        echo "unexpected: $1; said: $said" >&2
        exit 1
    }
}

said=$(plan --object mug --object-scale 10)
expect "look at: the object is [0-9]* mm thick .* the hand opens to 100 mm"  # between the pads
refuse "marginal"
said=$(plan --object mug --reach 0.001)
expect "look at: the hand stops before the object: increase --reach"
said=$(plan --object ball)
expect "[0-9]* firm (epsilon >= 0.2), [0-9]* fair (>= 0.05), [0-9]* marginal"
refuse "look at"
counts=$(sed -n 's/^\([0-9]*\) firm .*), \([0-9]*\) fair .*), \([0-9]*\) marginal$/\1+\2+\3/p' <<<"$said")
closures=$(sed -n 's/.*: \([0-9]*\) of 8 candidates are force closures.*/\1/p' <<<"$said")
[ "$((counts))" -eq "$closures" ] && [ "$closures" -gt 0 ] || {
    echo "the classes do not add up: $said" >&2
    exit 1
}
