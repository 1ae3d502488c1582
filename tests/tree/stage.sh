# shellcheck shell=sh
# SPDX-License-Identifier: Apache-2.0
# Where install.sh installs to, and how to compile against it. Sourced by tests in this folder, which run
# in the build folder and get their variables from Makefile.am.
: "${srcdir:?}" "${CC:?}" "${CXX:?}" "${PKG_CONFIG:?}" "${prefix:?}" "${libdir:?}" "${includedir:?}"
stage=$PWD/tests/tree/stage
PKG_CONFIG="$PKG_CONFIG --define-variable=prefix=$stage$prefix"
export PKG_CONFIG_PATH="$stage$libdir/pkgconfig"
export LD_LIBRARY_PATH="$stage$libdir${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
