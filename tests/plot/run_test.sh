#!/usr/bin/env bash
# benchmarks/run and its old names say in a sentence what is wrong or missing, with an exit code
# that is not 0, and never a traceback.
set -uo pipefail
cd "$(dirname "$0")/../.."
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
failed=0
expect() { # WORDS COMMAND..
    local words=$1 said
    shift
    said=$("$@" 2>&1) && { echo "exit code 0: $*"; failed=1; }
    [[ $said == *"$words"* && $said != *Traceback* ]] || { echo "$*: $said"; failed=1; }
}
expect 'no such verb' benchmarks/run weigh
expect 'bench/bin/soak_queries is missing' benchmarks/run soak rigid --build "$folder/bench"
expect 'bin/soak_queries is missing' tools/soak_articulated --build "$folder" -n 1
expect 'bin/bullet_table_single is missing' tools/bullet_table --build "$folder"
expect 'rigid|accuracy|convex|articulated|trajectories|trials|bullet' benchmarks/run soak
expect 'accuracy|agreement' benchmarks/run grasps --build "$folder"
mkdir "$folder/bin" && touch "$folder/bin/bench_grasps"
BULLET_CCD_TEST_DATA=$folder expect 'is the data complete?' tools/table --build "$folder"
mkdir "$folder/none" && echo 'raise ImportError' >"$folder/none/matplotlib.py"
PYTHONPATH=$folder/none expect 'apt-get install python3-matplotlib' benchmarks/run chart --draw
if /usr/bin/python3 -c 'import matplotlib' 2>/dev/null; then
    expect 'no such family' tools/chart weigh
    expect 'no measurements' benchmarks/run chart --draw -o "$folder/charts"
    expect 'no measurements' benchmarks/run stability --draw -o "$folder/stability"
    echo '{}' >"$folder/charts/rigid.json"
    expect 'cannot be drawn' benchmarks/run chart --draw -o "$folder/charts"
    echo '{' >"$folder/charts/rigid.json"
    expect 'measure again without --draw' benchmarks/run chart --draw -o "$folder/charts"
fi

# Programs whose steps cost 1 % more with the action and 5 % more with the world, by a valgrind that
# knows it; of these one has no limit, and one has it only up to its first impact.
cat >"$folder/bin/bullet_program_single" <<'END'
#!/usr/bin/env bash
case $1 in
    --list) printf 'pendulum 100 limited\nfast 50 free\nhit 50 limited\n' ;;
    hit) echo 'step: 7' ;;
    *) echo 'step: -1' ;;
esac
END
cat >"$folder/none/valgrind" <<'END'
#!/usr/bin/env bash
declare -A cost=([Stock]=1000 [Action]=1010 [World]=1050)
[[ $5 == fast ]] && cost[World]=2000
[[ $5 == hit ]] && cost[World]=$((1000 + $7))
echo "Collected : ${cost[$6]}" >&2
echo 'time-of-impact events: 3'
END
chmod +x "$folder/bin/bullet_program_single" "$folder/none/valgrind"
PATH=$folder/none:$PATH
transparency=(benchmarks/run transparency --precision single --build "$folder")
expect 'FAILED: more than 1.03' "${transparency[@]}"
expect '1.0500   FAILED' "${transparency[@]}" --only pendulum
said=$("${transparency[@]}" --limit 1.06) || { echo "a limit that is kept: $said"; failed=1; }
said=$("${transparency[@]}" --only hit) || { echo "impacts do not count: $said"; failed=1; }
[[ $said == *'with 3 impacts'* && $said == *'   7 steps'*'1.0070'* ]] || { echo "$said"; failed=1; }
[[ $(benchmarks/run --help) == *bullet-table* ]] || failed=1
exit $failed
