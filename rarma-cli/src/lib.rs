//! The `rarma` command as a library, so that tests can call it.
