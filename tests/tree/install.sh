#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# `make install DESTDIR=`: the library, its headers, its pkg-config file, manual pages and completion land where they
# should.
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
test -e "$stage$libdir/libpalmar.so"
test -e "$stage$includedir/palmar.h"
$PKG_CONFIG --exists --print-errors libtensor palmar
flags=$($PKG_CONFIG --cflags --libs libtensor)
case $flags in
*"$stage"*-ltensor*) ;;
*)
    echo "pkg-config says $flags"
    exit 1
    ;;
esac

# installed PATTERN: a file that is not empty has that path
installed()
{
    [ "$(find "$stage" -path "$1" -size +0 | wc -l)" = 1 ] || {
        echo "no $1 was installed"
        exit 1
    }
}

installed '*/share/bash-completion/completions/palmar'
installed '*/doc/palmar/README.md'
installed '*/share/palmar/python/palmar.py'
for page in "$srcdir"/docs/*.md; do
    installed "*/doc/palmar/docs/$(basename "$page")"
done

for model in "$srcdir"/models/starter/*.safetensors; do
    installed "*/models/starter/$(basename "$model")"
    installed "*/models/starter/$(basename "$model" .safetensors).json"
done

# A tree that was installed can be moved: the program reads the configs beside it. In its build folder it reads those of
# its own tree, whatever is installed.
: "${bindir:?}" "${datadir:?}"
rm -rf "$stage/moved"
mkdir "$stage/moved"
cp -R "$stage$prefix/." "$stage/moved"
moved=$stage/moved${bindir#"$prefix"}/palmar
config=$stage/moved${datadir#"$prefix"}/palmar/models/hocat/configs/tiny.json
sed -i 's/"width": *16/"width": 8/' "$config"
ours=$(./palmar info --model hocat --config hocat-tiny | awk '$1 == "parameters" { print $2 }')
theirs=$("$moved" info --model hocat --config hocat-tiny | awk '$1 == "parameters" { print $2 }')
[ "$theirs" -lt "$ours" ]
rm -r "$stage/moved"

# A folder without help2man has none.
[ -e palmar.1 ] || exit 0
installed '*/man1/palmar.1'
for c in $(./palmar help | awk '/^  [a-z]+ / && $1 != "palmar" { print $1 }'); do
    installed "*/man1/palmar-$c.1"
done
