#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The library exports lt_ names and nothing else.
. "${srcdir:?}/tests/tree/stage.sh"
names=$(nm -D --defined-only "$stage$libdir/libtensor.so" | awk '$2 ~ /[A-Z]/ { print $3 }')

echo "$names" | grep -q '^lt_compile$' || {
    echo "lt_compile is not exported"
    exit 1
}
# Some linkers export their own marks, and so does the address sanitizer.
foreign=$(echo "$names" | grep -vE '^lt_|^__odr_asan\.lt_|^(_edata|_end|__bss_start|_init|_fini)$')
[ -z "$foreign" ] || {
    echo "exported, and not ours to export:"
    echo "$foreign"
    exit 1
}
