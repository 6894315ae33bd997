#!/usr/bin/env bash
# A soak in two parts gives the table of a soak in one, whatever the number of threads, and so does
# one that was killed; checkpoints of other seeds, of other programs and damaged ones are refused.
#
#   soak_program_test.sh PROGRAM KIND ROUND    ROUND: seeds after which the program keeps its state
set -uo pipefail
program=("$1" "$2")
round=$3
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail() {
    echo "$1" >&2
    exit 1
}
table() { grep '^|' "$1"; }
same_tables() { diff <(table "$folder/$1.txt") <(table "$folder/$2.txt") || fail "$3"; }

total=$((3 * round))
"${program[@]}" -n $total --jobs 1 --checkpoint "$folder/one" >"$folder/one.txt"
[ $? -le 1 ] || fail "the program does not run"
"${program[@]}" -n "$round" --jobs 2 --checkpoint "$folder/two" >/dev/null
cp "$folder/two" "$folder/kept"
"${program[@]}" -n $total --jobs 2 --checkpoint "$folder/two" --resume >"$folder/two.txt"
same_tables one two "a soak in two parts has another table"
grep -q "^| all | $total " "$folder/two.txt" || fail "the table does not count $total queries"

"${program[@]}" -n $((1000 * round)) --jobs 1 --checkpoint "$folder/killed" >/dev/null &
running=$!
until [ -s "$folder/killed" ]; do sleep 0.05; done
kill -KILL $running
wait $running 2>/dev/null
next=$(grep -oP '"next": \K\d+' "$folder/killed")
total=$((next - 1 + round))
"${program[@]}" -n $total --jobs 2 --checkpoint "$folder/killed" --resume >"$folder/killed.txt"
"${program[@]}" -n $total --jobs 2 --checkpoint "$folder/fresh" >"$folder/fresh.txt"
same_tables fresh killed "a soak that was killed has another table"

refuses() { # FILE MESSAGE WHAT [OPTION...]
    local file=$1 message=$2 what=$3
    shift 3
    "${program[@]}" "$@" -n $((2 * round)) --checkpoint "$folder/$file" --resume >/dev/null 2>"$folder/refused.txt"
    [ $? -eq 2 ] || fail "$what is not refused"
    grep -q "$message" "$folder/refused.txt" || fail "the refusal of $what does not say why"
}
refuses kept 'belongs to another run' "a checkpoint of other seeds" --seed 7
head -c -3 "$folder/kept" >"$folder/short"
refuses short 'or damaged' "a checkpoint that was cut off"
sed -E 's/("next": [0-9]*)/\17/' "$folder/kept" >"$folder/changed"
refuses changed 'or damaged' "a checkpoint with a changed count"
sed 's/run soak/run other/' "$folder/kept" >"$folder/foreign"
refuses foreign 'or damaged' "a checkpoint that names another program"
