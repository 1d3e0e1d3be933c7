# Tasks for people who work on polishc. `just` lists them.

default:
    @just --list

# All tests.
test:
    cargo test

# Everything that the checks before landing run.
ci:
    .ci/run

# Take the present output as the snapshots. Read the diff before you commit it.
bless:
    INSTA_UPDATE=always cargo test --test ui --test pass
    TRYCMD=overwrite cargo test --test cli
    BOOK_UPDATE=always cargo test --test book

# Ratios to named references, in one run.
bench:
    cargo bench

# Fuzz one reader for ten minutes (needs cargo-fuzz and the nightly toolchain): `just fuzz x3p`.
fuzz TARGET:
    cargo +nightly fuzz run {{TARGET}} -- -max_total_time=600 -rss_limit_mb=2048

# Read maps that we wrote with prysm and surfalize (needs Python with both).
written-maps:
    cargo build --example convert
    python3 tests/written_maps.py target/debug/examples/convert

# Make the data of the examples again.
maps:
    cargo run --release --example make_maps
