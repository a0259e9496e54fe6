#!/bin/sh
# Runs one test with a PoCL kernel cache of its own: programs that build kernels
# side by side would fight over a common one.
name=$(for last in "$@"; do :; done; basename "$last" .sh)
POCL_CACHE_DIR=$PWD/test/pocl-cache/$name
export POCL_CACHE_DIR
mkdir -p "$POCL_CACHE_DIR"
exec "$@"
