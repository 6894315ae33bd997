#!/usr/bin/env bash
# A soak in two parts gives the table of a soak in one, whatever the number of threads; a checkpoint
# of other seeds is refused.
set -uo pipefail
program=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail() {
    echo "$1" >&2
    exit 1
}
table() { grep '^|' "$1"; }

"$program" -n 1440 --jobs 1 --checkpoint "$folder/one" >"$folder/one.txt"
[ $? -le 2 ] || fail "the program does not run"
"$program" -n 480 --jobs 2 --checkpoint "$folder/two" >/dev/null
"$program" -n 1440 --jobs 2 --checkpoint "$folder/two" --resume >"$folder/two.txt"
diff <(table "$folder/one.txt") <(table "$folder/two.txt") || fail "the tables differ"
grep -q '^| all | 1440 ' "$folder/two.txt" || fail "the table does not count 1440 queries"
"$program" --seed 7 -n 480 --checkpoint "$folder/two" --resume 2>"$folder/refused.txt"
[ $? -eq 3 ] || fail "a checkpoint of other seeds is not refused"
grep -q 'another range of seeds' "$folder/refused.txt" || fail "the refusal does not say why"
