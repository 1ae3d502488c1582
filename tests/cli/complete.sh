#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# What bash offers behind palmar: its commands, a command's options, and nothing where files are meant.
. "${srcdir:?}/cli/bash-completion/palmar"
bad=0

# offers WANTED WORD...: with these words typed, the last not yet to its end, exactly the wanted ones are offered
offers()
{
    wanted=$1
    shift
    COMP_WORDS=(./palmar "$@")
    COMP_CWORD=$#
    _palmar ./palmar
    [ "${COMPREPLY[*]}" = "$wanted" ] && return
    echo "palmar $*: offers \"${COMPREPLY[*]}\", want \"$wanted\""
    bad=1
}

offers 'predict' pr
offers 'eval export' e
offers 'help' h
offers '--version' --v
offers 'report' help r
offers '' help --v
offers '--hand= --hand-box= --help' predict --h
offers '--boxes=' predict runs/tiny --box
offers '--resume' train --re
offers '--require=' eval --r
offers '--tables=' eval --ta
offers '--op' gradcheck --o
offers '' predict runs/t
offers '' nothing --o
for command in $(./palmar help | awk '/^  [a-z]+ / && $1 != "palmar" { print $1 }'); do
    offers '--help' "$command" --help
done
exit $bad
