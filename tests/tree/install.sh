#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# `make install DESTDIR=`: the library, its headers and its pkg-config file land where they should.
# Other tests in this folder compile against what is left in tests/tree/stage.
. "${srcdir:?}/tests/tree/stage.sh"
set -e

rm -rf "$stage"
env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make -s install DESTDIR="$stage" >tests/tree/install.out 2>&1 || {
    cat tests/tree/install.out
    exit 1
}
test -e "$stage$libdir/libtensor.so"
test -e "$stage$includedir/libtensor/graph/op.h"
$PKG_CONFIG --exists --print-errors libtensor
flags=$($PKG_CONFIG --cflags --libs libtensor)
case $flags in
*"$stage"*-ltensor*) ;;
*)
    echo "pkg-config says $flags"
    exit 1
    ;;
esac
