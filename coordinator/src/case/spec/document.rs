//! Tables of keys for `cases/FORMAT.md`.
