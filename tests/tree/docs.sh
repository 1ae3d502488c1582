#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# What the documents print is what the files hold: each C block of docs/adding-a-layer.md, docs/your-first-network.md and
# docs/from-c-and-python.md stands, line for line, in the example's source, every file that a document links to exists,
# each command has a section in the user guide and a manual page, and each score is in the formats.
commands=$(./palmar help | awk '/^  [a-z]+ / && $1 != "palmar" { print $1 }')
cd "${srcdir:?}" || exit 1
bad=0

[ -n "$commands" ] || bad=1
for c in $commands; do
    grep -q "^## $c" docs/user-guide.md || {
        echo "docs/user-guide.md has no section on palmar $c"
        bad=1
    }
    grep -q "palmar-$c\\.1" Makefile.am || {
        echo "Makefile.am makes no manual page palmar-$c.1"
        bad=1
    }
done

# Blank lines aside, the blocks in order are the whole program.
# shows DOCUMENT PROGRAM
shows()
{
    shown=$(awk '/^```c$/ { on = 1; next } /^```$/ { on = 0 } on && NF' "$1")
    [ "$shown" = "$(awk NF "$2")" ] || {
        echo "$1 and $2 differ"
        bad=1
    }
}
shows docs/adding-a-layer.md docs/examples/swish_layer/swish.c
shows docs/your-first-network.md docs/examples/first_network/first.c
shows docs/from-c-and-python.md docs/examples/from_c/pose.c

# Every key that predict writes
json=$(sed -n '/^## A picture.s JSON/,/^## Hand models/p' docs/formats.md)
keys=$(grep -oE '(\([a-z_]+|\{), *"[a-z0-9_]+"|\{ "[a-z0-9_]+"' pipeline/json.c | sed 's/.*"\(.*\)"/\1/' | sort -u)
for key in $keys; do
    echo "$json" | grep -q "\`$key\`" || {
        echo "docs/formats.md does not tell of predict's key $key"
        bad=1
    }
done

# Every key that is scored is explained.
keys=$(grep -oh '"[a-z0-9_]*", FROM_' tasks/*/scores.c | cut -d'"' -f2)
for key in $keys; do
    grep -q "^| \`$key\` |" docs/formats.md || {
        echo "docs/formats.md does not list the score $key"
        bad=1
    }
done

for doc in *.md docs/*.md $(find libtensor assets vision data synth models estimate train eval pipeline libpalmar python cli tests -name README.md); do
    links=$(grep -oE '\]\([^)#: ]+[)#]' "$doc" | sed 's/^](//; s/.$//')
    for link in $links; do
        [ -e "$(dirname "$doc")/$link" ] || {
            echo "$doc links to $link, which is not there"
            bad=1
        }
    done
done
exit $bad
