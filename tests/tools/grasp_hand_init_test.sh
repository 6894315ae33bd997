#!/usr/bin/env bash
# What `grasp hand init` writes is understood without any inference; a file that is there is kept. What is inferred is kept in
# the cache folder of the user, unless that is not wanted.
#
#   grasp_hand_init_test.sh GRASP
set -uo pipefail
grasp=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export BULLET_CCD_CACHE=
fail() {
    echo "$1" >&2
    exit 1
}

link() {
    echo "<link name=\"$1\"><collision><origin xyz=\"0 0 $3\"/><geometry><box size=\"$2\"/></geometry></collision></link>"
}
hinge() {
    echo "<joint name=\"$1_joint\" type=\"revolute\"><parent link=\"palm\"/><child link=\"$1\"/>" \
        "<origin xyz=\"$2 0 0.02\"/><axis xyz=\"0 $3 0\"/>" \
        "<limit lower=\"-0.2\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint>"
}
echo "<robot name=\"pincer\">$(link palm '0.14 0.06 0.02' 0)$(link left '0.01 0.02 0.1' 0.05)" \
    "$(link right '0.01 0.02 0.1' 0.05)$(hinge left -0.05 1)$(hinge right 0.05 -1)</robot>" \
    >"$folder/pincer.urdf"

"$grasp" hand show "$folder/pincer.urdf" | grep -q "closing directions inferred" ||
    fail "without an SRDF nothing was inferred"
"$grasp" hand init "$folder/pincer.urdf" -o "$folder/pincer.srdf" | grep -q "2 fingers" ||
    fail "init does not say what it wrote"
shown=$("$grasp" hand show "$folder/pincer.urdf")
grep -q "directions inferred\|frame inferred\|preshape.* inferred\|fingers inferred" <<<"$shown" &&
    fail "the written SRDF leaves something to be inferred"
[ "$("$grasp" hand init "$folder/pincer.urdf")" = "$(cat "$folder/pincer.srdf")" ] ||
    fail "printed and written are not the same"

"$grasp" hand init "$folder/pincer.urdf" -o "$folder/pincer.srdf" 2>"$folder/error" >/dev/null
[ $? -eq 3 ] || fail "a file that is there is overwritten"
grep -q "exists already" "$folder/error" || fail "the message does not say why"

# Kept: in a folder of its own, in the user's, in none.
rm "$folder/pincer.srdf"
unset BULLET_CCD_CACHE
count() { find "$1" -name '*.hand' 2>/dev/null | wc -l; }
show() { "$grasp" hand show "$folder/pincer.urdf" "$@"; }
none=$(XDG_CACHE_HOME="$folder/user" show --no-cache)
[ "$(count "$folder/user")" -eq 0 ] || fail "--no-cache keeps something"
[ "$(XDG_CACHE_HOME="$folder/user" show)" = "$none" ] || fail "what is kept makes a difference"
[ "$(count "$folder/user/bullet_ccd")" -eq 1 ] || fail "nothing is kept in XDG_CACHE_HOME"
[ "$(XDG_CACHE_HOME="$folder/user" show)" = "$none" ] || fail "what was kept makes a difference"
HOME="$folder/home" XDG_CACHE_HOME=relative show >/dev/null
[ ! -e "$folder/home" ] || fail "a home is made"
mkdir "$folder/home"
HOME="$folder/home" XDG_CACHE_HOME=relative show >/dev/null
[ "$(count "$folder/home/.cache/bullet_ccd")" -eq 1 ] || fail "nothing is kept in ~/.cache"
HOME="$folder/home" BULLET_CCD_CACHE="$folder/mine" show >/dev/null
[ "$(count "$folder/mine")" -eq 1 ] || fail "nothing is kept in BULLET_CCD_CACHE"
HOME="$folder/other" XDG_CACHE_HOME="$folder/other" BULLET_CCD_CACHE="" show >/dev/null
[ "$(count "$folder/other")" -eq 0 ] || fail "an empty BULLET_CCD_CACHE keeps something"

# Drawn: a picture for each preshape, and the page where it was built.
BULLET_CCD_CACHE="" show -o "$folder/pictures" >"$folder/said"
[ -s "$folder/pictures/open.png" ] || fail "the preshape is not drawn"
if [ -e "$(dirname "$grasp")/../share/bullet_ccd/viewer.html" ]; then
    grep -q '"preshape":"open".*"joints":' "$folder/pictures/report.html" || fail "the page does not show the preshape close"
    grep -q "report.html: every preshape closes" "$folder/said" || fail "the page is not named"
fi
