# An image with the server as one static file and nothing else. `docker build .`, or deploy/build-image.sh without Docker.

# Both bases can come from a private mirror: --build-arg BUILD_IMAGE=mirror.example/rust:1.95-slim-bookworm
ARG BUILD_IMAGE=docker.io/library/rust:1.95-slim-bookworm
# Nothing is needed beside the server: it is linked statically, has no temporary files and speaks no TLS.
ARG RUNTIME_IMAGE=scratch

FROM ${BUILD_IMAGE} AS toolchain
SHELL ["/bin/sh", "-eu", "-c"]
WORKDIR /build
# Nothing is installed if the image has the musl tools, so that a mirror needs no apt.
# Versions follow the base image's Debian release: pinning them would break the build at every point release.
# hadolint ignore=DL3008
RUN command -v musl-gcc || { \
      apt-get update; \
      apt-get install --yes --no-install-recommends musl-tools; \
      rm -rf /var/lib/apt/lists/*; \
    }; \
    target="$(uname -m)-unknown-linux-musl"; \
    [ -d "$(rustc --print sysroot)/lib/rustlib/$target" ] || rustup target add "$target"

# The dependencies, from the manifest and an empty program: this layer lasts until one of the two files changes.
# Tables of benches, tests and examples refer to files that are not copied yet.
FROM toolchain AS dependencies
COPY Cargo.toml Cargo.lock ./
RUN cp Cargo.toml Cargo.toml.whole; \
    awk '/^\[/ { keep = !/^\[\[(bench|test|example)\]\]/ } keep || NR == 1' Cargo.toml.whole > Cargo.toml; \
    mkdir src; \
    echo 'fn main() {}' > src/main.rs; \
    touch src/lib.rs; \
    cargo build --profile container --locked --target "$(uname -m)-unknown-linux-musl"; \
    rm -r src

FROM dependencies AS build
# The revision shown by /metrics.
ARG REVISION=unknown
COPY . .
# Newer than the empty program, whatever the checkout's times are.
RUN touch src/lib.rs src/main.rs; \
    SCALLOPD_REVISION="$REVISION" cargo build --profile container --locked --target "$(uname -m)-unknown-linux-musl"; \
    install -D -s "target/$(uname -m)-unknown-linux-musl/container/scallopd" /image/scallopd

FROM ${RUNTIME_IMAGE}
ARG VERSION=0.1.0
ARG REVISION=unknown
ARG CREATED=
ARG SOURCE=
LABEL org.opencontainers.image.title="scallopd" \
      org.opencontainers.image.description="Scallop heights, feeds and step-overs of finish milling, over HTTP" \
      org.opencontainers.image.licenses="MIT OR Apache-2.0" \
      org.opencontainers.image.version="${VERSION}" \
      org.opencontainers.image.revision="${REVISION}" \
      org.opencontainers.image.created="${CREATED}" \
      org.opencontainers.image.source="${SOURCE}"
COPY --from=build /image/scallopd /scallopd
# A number, so that Kubernetes can verify that it is not root; the same as in distroless images.
USER 65532:65532
# In a container every address is the container's own. The allocator's delay is the one that the program would set.
ENV SCALLOPD_LISTEN=0.0.0.0:8080 \
    MIMALLOC_PURGE_DELAY=10
EXPOSE 8080
# The server checks itself, because there is no shell and no curl.
HEALTHCHECK --interval=10s --timeout=3s --start-period=2s --retries=3 CMD ["/scallopd", "healthcheck"]
STOPSIGNAL SIGTERM
ENTRYPOINT ["/scallopd"]
