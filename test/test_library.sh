#!/bin/sh
# The library as it is linked: exports what the header declares and nothing
# else, and never prints or ends the process.
header=$srcdir/include/hbil/hbil.h
library=.libs/libhbil.so
n=0

result() { # status, name
  n=$((n + 1))
  if [ "$1" = 0 ]; then echo "ok $n - $2"; else echo "not ok $n - $2"; fi
}

# hbil_ names that are followed by a parenthesis in a declaration of the API
declared() {
  awk '/^HBIL_API/ { api = 1 }
       api && match($0, /hbil_[a-z0-9_]+\(/) {
         print substr($0, RSTART, RLENGTH - 1); api = 0 }' "$header" | sort
}

exported() {
  nm -D --defined-only "$library" | awk '$2 == "T" { print $3 }' |
    sed 's/@.*//' | sort
}

undefined() {
  nm -D --undefined-only "$library" | awk '{ print $NF }' | sed 's/@.*//'
}

echo 1..3
if [ ! -f "$library" ]; then
  for name in exports 'no other symbols' 'no printing'; do
    n=$((n + 1))
    echo "ok $n - $name # SKIP no shared library"
  done
  exit 0
fi
[ -n "$(declared)" ] && [ "$(declared)" = "$(exported)" ]
result $? 'exports exactly what the header declares'
! undefined | grep -E '^(_exit|exit|abort|quick_exit|__assert_fail)$' >&2
result $? 'never ends the process'
! undefined | grep -E '^(v?f?printf|__v?f?printf_chk|puts|putchar|fputs|fwrite|perror|stderr|stdout)$' >&2
result $? 'never prints'
