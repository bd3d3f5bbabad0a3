#!/bin/sh
# What tests of `lightformer view` share. To be sourced in the folder of the screenshots; wants `program` and `scene`.
# shellcheck shell=sh disable=SC2154
# start OPTION...: opens the scene in a window, in which pictures at rest are the mean of $averaged.
averaged=1
start() {
    "$program" view "$scene" --aa "$averaged" "$@" >log 2>&1 &
    mark=0
    viewer=$!
}
trap 'kill $viewer 2>/dev/null || true' EXIT

fail() {
    echo "test_view: $1"
    echo "--- the program said:"
    cat log
    exit 1
}

# wait_for WHAT COMMAND...: tries until the command succeeds.
patience=300 # seconds
wait_for() {
    what=$1
    shift
    end=$(($(date +%s) + patience))
    try "$@" && return
    kill -0 "$viewer" 2>/dev/null || fail "the program ended while waiting for $what"
    fail "waited in vain for $what"
}
# The same, within the time of the wait_for that it is a part of. False: in vain.
try() {
    until "$@" >/dev/null 2>&1; do
        [ "$(date +%s)" -lt "$end" ] && kill -0 "$viewer" 2>/dev/null || return 1
        sleep 0.05
    done
}

find_window() {
    window=$(xdotool search --onlyvisible --name ' ms') && [ -n "$window" ]
}
title_has() {
    case $(xdotool getwindowname "$window") in
    *"$1"*) return 0 ;;
    *) return 1 ;;
    esac
}
shot() {
    import -silent -window "$window" "$1.png"
}
# How different two screenshots are: root mean square, 0 to 1.
difference() {
    compare -metric RMSE "$1.png" "$2.png" null: 2>&1 | sed 's/.*(\(.*\)).*/\1/'
}
differ() {
    [ "$(difference "$1" "$2" | awk '{ print ($1 > 0.01) }')" = 1 ]
}
# The window shows something else than in screenshot $1; the new picture is $2.
changed() {
    shot "$2" && differ "$1" "$2"
}
# Until all keys and drags before have been taken in: a key that does nothing else puts a mark into the title.
take_in() {
    mark=$((${mark-0} + 1))
    xdotool key F9
    try title_has "- mark $mark"
}
# The picture is all that was asked for; two screenshots in a row are equal, since one may be on its way to the
# screen. It is $1.
settled() {
    take_in && try title_has 'at rest' && shot before && take_in && title_has 'at rest' && shot "$1" || return 1
    cmp -s before.png "$1.png" || [ "$(difference before "$1" | awk '{ print ($1 == 0) }')" = 1 ]
}

# Escape quits, with exit code 0 and nothing to complain about.
quit() {
    xdotool key Escape
    status=0
    wait "$viewer" || status=$?
    [ $status -eq 0 ] || fail "exit code $status"
    if grep -q 'error' log; then fail 'errors in the log'; fi
}

