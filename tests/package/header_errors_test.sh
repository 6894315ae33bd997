#!/usr/bin/env bash
# A public header refuses C++17, and Eigen types aligned by the instruction set, with a sentence that
# says what to do; and it accepts what the sentence says.
#   header_errors_test.sh COMPILER SOURCE EIGEN
set -euo pipefail
compiler=$1 source=$2 eigen=$3
header=bullet_ccd/toi/toi.h
compile() { # options
    "$compiler" -fsyntax-only -x c++ -I "$source" -isystem "$eigen" "$@" -include "$header" /dev/null 2>&1
}
refuses() { # sentence, options
    local sentence=$1 output
    shift
    if output=$(compile -E -o /dev/null "$@"); then
        echo "$header accepts $*"
        exit 1
    fi
    # The sentence is the first thing that is said.
    [[ $(grep -m1 'error:' <<<"$output") == *"$sentence"* ]] || {
        echo "$header refuses $* without saying why: $output"
        exit 1
    }
}
# Errors of the preprocessor are what is looked for; once the header is compiled, too.
accepts() {
    compile -E -o /dev/null "$@"
}
fixed=-DEIGEN_MAX_STATIC_ALIGN_BYTES=16
refuses 'bullet_ccd needs C++20: compile with -std=c++20' -std=c++17 $fixed
compile -std=c++20 $fixed
if [ "$(uname -m)" = x86_64 ]; then
    accepts -std=c++20
    for options in '-mavx' '-mavx512f -mfma'; do
        # shellcheck disable=SC2086
        {
            refuses 'compile with -DEIGEN_MAX_STATIC_ALIGN_BYTES=16' -std=c++20 $options
            accepts -std=c++20 $options $fixed
        }
    done
fi
