#!/bin/sh
# Builds the image without Docker and without a registry, and tests it: the server is started from the image's root file system,
# read-only and as its own user, and its health is checked.
#
#   deploy/build-image.sh [IMAGE]            as root, on Debian with: apt-get install buildah musl-tools
#   deploy/build-image.sh --whole [IMAGE]    with: apt-get install buildah debootstrap
#
# The server is built here, with this machine's Rust toolchain for musl, and the last stage of the Dockerfile puts it into the image:
# half a gigabyte of disk. With --whole, buildah builds all stages of the Dockerfile on a Debian from debootstrap, with a copy of this
# machine's toolchain; without overlay file systems that takes 18 GB.
#
# WORK (default: a temporary directory, removed at the end) keeps what is built between runs when it is set. With KEEP_MOUNTED=1 the
# image's root file system stays mounted, and deploy/run-image.sh runs the server from it.
set -eu

whole=no
if [ "${1:-}" = --whole ]; then
    whole=yes
    shift
fi
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
    if [ -n "${KEEP_MOUNTED:-}" ]; then return; fi
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

# Runs buildah bud with the labels of this revision.
bud() {
    build bud --isolation chroot --pull-never --format docker --tag "$image" --build-arg "VERSION=$version" \
        --build-arg "REVISION=$revision" --build-arg "CREATED=$(date -u +%Y-%m-%dT%H:%M:%SZ)" "$@"
}

build_whole() {
    build inspect --type image "$base" > /dev/null 2>&1 || make_base
    bud --layers --build-arg "BUILD_IMAGE=$base" "$root"
}

build_last_stage() {
    target="$(uname -m)-unknown-linux-musl"
    sysroot=$(rustc --print sysroot)
    [ -d "$sysroot/lib/rustlib/$target" ] || rustup target add "$target"
    (cd "$root" && CARGO_TARGET_DIR="$work/target" SCALLOPD_REVISION="$revision" cargo build --quiet --profile container --locked --target "$target")
    mkdir -p "$work/context"
    install -s "$work/target/$target/container/scallopd" "$work/context/scallopd"
    awk '/^FROM \$\{RUNTIME_IMAGE\}/ { print "ARG RUNTIME_IMAGE=scratch"; last = 1 } last { sub(/^COPY --from=build \/image\//, "COPY "); print }' \
        "$root/Dockerfile" > "$work/context/Dockerfile"
    bud --layers=false "$work/context"
}

say "image $image"
revision=$(git -C "$root" rev-parse --short HEAD 2> /dev/null || echo unknown)
version=$(sed -n 's/^version = "\(.*\)"/\1/p' "$root/Cargo.toml" | head -n 1)
if [ "$whole" = yes ]; then build_whole; else build_last_stage; fi

say "the server from the image, read-only, as user 65532"
container=$(build from --pull-never "$image")
mounted=$(build mount "$container")
files=$(find "$mounted" -type f | wc -l)
bytes=$(find "$mounted" -type f -exec stat -c %s {} + | awk '{ sum += $1 } END { print sum }')
mkdir -p "$work/proof"
mount --bind "$mounted" "$work/proof"
mount -o remount,bind,ro "$work/proof"
listen=127.0.0.1:18080
MIMALLOC_PURGE_DELAY=10 chroot --userspec=65532:65532 "$work/proof" /scallopd --listen "$listen" > "$work/server.log" &
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
