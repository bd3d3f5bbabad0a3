#!/bin/sh
# What tests of the program share. To be sourced; wants `program`, `json_get` and `out`, counts in `failures`.
# shellcheck shell=sh disable=SC2154
failures=0

fail() {
    echo "$(basename "$0"): $1"
    failures=$((failures + 1))
}

# expect STATUS TEXT ARGUMENT...: exits like this and prints this, on either stream.
expect() {
    want=$1 text=$2
    shift 2
    status=0
    "$program" "$@" >"$out/said" 2>&1 || status=$?
    if [ $status -ne "$want" ] || ! grep -q -e "$text" "$out/said"; then
        fail "\"$*\" should exit with $want and say \"$text\", but exits with $status and says:"
        cat "$out/said"
    fi
}

# expect_error TEXT ARGUMENT...: exit code 1 and one line, for bad input.
expect_error() {
    expect_line 1 "$@"
}

# expect_bad_value TEXT ARGUMENT...: exit code 2 and one line, for what an option does not take.
expect_bad_value() {
    expect_line 2 "$@"
}

expect_line() {
    expect "$@"
    shift 2
    [ "$(wc -l <"$out/said")" -eq 1 ] || fail "\"$*\" should say one line, but says: $(cat "$out/said")"
}

# expect_json PATH VALUE: in what was said last; an empty value stands for any.
expect_json() {
    value=$("$json_get" "$1" <"$out/said") || fail "no \"$1\" in: $(head -c 500 "$out/said")"
    [ -z "$2" ] || [ "$value" = "$2" ] || fail "\"$1\" should be $2, but is $value"
}
