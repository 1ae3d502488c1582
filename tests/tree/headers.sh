#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Each installed header compiles alone, as C and as C++, without a warning.
. "${srcdir:?}/tests/tree/stage.sh"
cd "$stage$includedir" || exit 1

# alone HEADER COMPILER...: what is read from standard input is that one line
alone()
{
    header=$1
    shift
    echo "#include \"$header\"" | "$@" -fsyntax-only -Wall -Wextra -Wshadow -Werror -I. -
}

bad=0
for h in palmar.h $(find libtensor -name '*.h' | sort); do
    # shellcheck disable=SC2086 # CC and CXX may be several words
    alone "$h" $CC -std=c11 -x c || bad=1
    # shellcheck disable=SC2086
    alone "$h" $CXX -std=c++14 -x c++ || bad=1
done
exit $bad
