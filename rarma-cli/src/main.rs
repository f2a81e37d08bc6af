//! rarma
fn main() {}
