#!/bin/sh
# Prints the help of the program and of each of its commands, for help.awk.  Each
# help text follows a line "== COMMAND".
#
#   help.sh ./hbil
set -eu
hbil=$1
help=$("$hbil" --help)
printf '== \n%s\n' "$help"
for command in $(printf '%s\n' "$help" | sed -n 's/^  \([a-z]*\) .*/\1/p'); do
  echo "== $command"
  "$hbil" "$command" --help
done
