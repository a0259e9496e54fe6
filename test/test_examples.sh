#!/bin/sh
# Every example runs and finds its own results sane.
echo 1..3
n=0
for name in 01_minimal 02_in_your_pipeline 03_single_passes; do
  n=$((n + 1))
  if "$EXAMPLES/$name" >&2; then
    echo "ok $n - example $name"
  else
    echo "not ok $n - example $name"
  fi
done
