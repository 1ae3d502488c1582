#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Shell scripts pass shellcheck.
command -v shellcheck >/dev/null || {
    echo "shellcheck is not installed"
    exit 77
}
cd "${srcdir:?}" || exit 1
grep -lE '^#!/bin/(ba)?sh|^# shellcheck shell' autogen.sh scripts/* cli/bash-completion/* tests/*/*.sh 2>/dev/null |
    xargs shellcheck -x -P "$PWD" -e SC1090,SC1091,SC2154
