//! `cargo hil`: the command line.
fn main() {}
