#!/bin/sh
# Runs the server from the root file system of the image that deploy/build-image.sh has built, read-only and as the image's user. The
# soak tests take it as a program:
#
#   export WORK=/var/tmp/image KEEP_MOUNTED=1 && deploy/build-image.sh && python3 tests/soak/attacks.py deploy/run-image.sh
#
# As root. The settings come from the environment, as in a container.
set -eu
export MIMALLOC_PURGE_DELAY=10
exec chroot --userspec=65532:65532 "${WORK:?the directory of build-image.sh}/proof" /scallopd "$@"
