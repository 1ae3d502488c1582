#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The libraries export lt_ names and palmar_ names, and nothing else.
. "${srcdir:?}/tests/tree/stage.sh"

# only LIBRARY PREFIX NAME: NAME is exported, and all that is begins with PREFIX
only()
{
    names=$(nm -D --defined-only "$stage$libdir/$1" | awk '$2 ~ /[A-Z]/ { print $3 }')
    echo "$names" | grep -q "^$3\$" || {
        echo "$1: $3 is not exported"
        exit 1
    }
    # Some linkers export their own marks, and so does the address sanitizer.
    foreign=$(echo "$names" | grep -vE "^$2|^__odr_asan\.$2|^(_edata|_end|__bss_start|_init|_fini)\$")
    [ -z "$foreign" ] || {
        echo "$1 exports what is not ours to export:"
        echo "$foreign"
        exit 1
    }
}

only libtensor.so lt_ lt_compile
only libpalmar.so palmar_ palmar_estimate
