//! What reads users' files and a user's lines, by itself: nothing else of the host's is built.

// What is read alone has more uses in the program.
#[allow(dead_code)]
#[path = "../../src"]
mod host {
    pub mod board_log;
    pub mod console_on_host;
    pub mod error;
    pub mod exercise;
    pub mod failure;
    pub mod gap {
        //! The tracing's part of it.
        mod catalogue;
        pub mod declared;
    }
    pub mod import {
        //! What looks for the call that mends a log.
        pub(crate) mod call;
        mod convert;
        mod foreign {
            //! No program is built and run for a fuzzer.

            use std::path::Path;

            use super::raw::Raw;
            use crate::failure::Failure;

            #[derive(Clone, Copy)]
            pub struct Format;

            impl Format {
                pub fn of(_: &[u8]) -> Option<Self> {
                    None
                }
            }

            pub(super) fn read(_: &Path, _: &[u8], _: Format) -> Result<Raw, Failure> {
                Err(Failure::other("not read while fuzzing"))
            }
        }
        mod guess;
        mod layout;
        mod mat;
        mod raw;
        mod recipe;
        mod source;
        mod text;
        mod unit;
    }
    pub mod log;
    pub mod machine;
    pub mod printed_log;
    pub(crate) mod quantity;
}

pub use host::*;
