#!/bin/sh
# Every example in C runs and finds its own results sane; test_install.sh has
# those that need an installed library.
echo 1..4
n=0
for name in 01_minimal 02_in_your_pipeline 03_single_passes 04_many_devices; do
  n=$((n + 1))
  if "$EXAMPLES/$name" >&2; then
    echo "ok $n - example $name"
  else
    echo "not ok $n - example $name"
  fi
done
