#!/bin/sh
# Builds the image without Docker and without a registry, and tests it: the bases are made here (Debian by debootstrap, with this
# machine's Rust toolchain), buildah builds the Dockerfile on them, and the server is started from the image's root file system,
# read-only and as its own user, and its health is checked.
#
#   deploy/build-image.sh [IMAGE]          as root, on Debian with: apt-get install buildah debootstrap
#
# WORK (default: a temporary directory, removed at the end) keeps the base between runs when it is set.
set -eu

image=${1:-localhost/scallopd:local}
base=localhost/scallopd-build-base:local
root=$(cd "$(dirname "$0")/.." && pwd)
suite=bookworm
if [ -n "${WORK:-}" ]; then
    work=$WORK
    mkdir -p "$work"
else
    work=$(mktemp -d)
fi
storage="--storage-driver vfs --root $work/storage --runroot $work/run"
server=
container=

finish() {
    if [ -n "$server" ]; then kill "$server" 2> /dev/null || true; fi
    if mountpoint -q "$work/proof"; then umount "$work/proof"; fi
    # shellcheck disable=SC2086 # the options are words
    if [ -n "$container" ]; then buildah $storage rm "$container" > /dev/null || true; fi
    if [ -z "${WORK:-}" ]; then rm -rf "$work"; fi
}
trap finish EXIT

say() { printf '== %s\n' "$*"; }

# shellcheck disable=SC2086
build() { buildah $storage "$@"; }

make_base() {
    say "base image from debootstrap ($suite) and $(rustc --version)"
    [ -d "$work/base" ] || debootstrap --variant=minbase --include=ca-certificates,gcc,libc6-dev,musl-tools "$suite" "$work/base" > "$work/debootstrap.log"
    target="$(uname -m)-unknown-linux-musl"
    sysroot=$(rustc --print sysroot)
    [ -d "$sysroot/lib/rustlib/$target" ] || rustup target add "$target"
    mkdir -p "$work/base/usr/local/rust/lib" "$work/base/usr/local/rust/bin"
    # Compiler, linker and both standard libraries; no documentation, no tools.
    cp -a "$sysroot/bin/rustc" "$sysroot/bin/cargo" "$work/base/usr/local/rust/bin/"
    cp -a "$sysroot"/lib/*.so* "$sysroot/lib/rustlib" "$work/base/usr/local/rust/lib/"
    # The build uses this machine's certificates, because a mirror may have its own authority.
    cp /etc/ssl/certs/ca-certificates.crt "$work/base/etc/ssl/certs/ca-certificates.crt"
    from=$(build from scratch)
    build copy --quiet "$from" "$work/base" / > /dev/null
    build config --env PATH=/usr/local/rust/bin:/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin --env CARGO_HOME=/usr/local/cargo "$from"
    build commit --quiet --rm "$from" "$base" > /dev/null
}

build inspect --type image "$base" > /dev/null 2>&1 || make_base

say "image $image"
revision=$(git -C "$root" rev-parse --short HEAD 2> /dev/null || echo unknown)
version=$(sed -n 's/^version = "\(.*\)"/\1/p' "$root/Cargo.toml" | head -n 1)
build bud --isolation chroot --layers --pull-never --format docker --tag "$image" \
    --build-arg "BUILD_IMAGE=$base" --build-arg "VERSION=$version" --build-arg "REVISION=$revision" \
    --build-arg "CREATED=$(date -u +%Y-%m-%dT%H:%M:%SZ)" "$root"

say "the server from the image, read-only, as user 65532"
container=$(build from --pull-never "$image")
mounted=$(build mount "$container")
files=$(find "$mounted" -type f | wc -l)
bytes=$(find "$mounted" -type f -exec stat -c %s {} + | awk '{ sum += $1 } END { print sum }')
mkdir -p "$work/proof"
mount --bind "$mounted" "$work/proof"
mount -o remount,bind,ro "$work/proof"
listen=127.0.0.1:18080
chroot --userspec=65532:65532 "$work/proof" /scallopd --listen "$listen" > "$work/server.log" &
server=$!
healthy=no
for _ in 1 2 3 4 5 6 7 8 9 10; do
    if chroot --userspec=65532:65532 "$work/proof" /scallopd healthcheck --listen "$listen"; then
        healthy=yes
        break
    fi
    sleep 0.5
done
user=$(stat -c %u "/proc/$server")
kill -TERM "$server"
code=0
wait "$server" || code=$?
server=
cat "$work/server.log"
say "files in the image: $files; bytes: $bytes; server's user: $user; healthy by its own check: $healthy; exit code after SIGTERM: $code"
[ "$healthy" = yes ] && [ "$code" = 0 ] && [ "$user" = 65532 ] && [ "$bytes" -lt 30000000 ]
