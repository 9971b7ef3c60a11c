//! What reads users' files and a user's lines, by itself: nothing else of the host's is built.

#[path = "../../src/board_log.rs"]
pub mod board_log;
#[path = "../../src/console_on_host.rs"]
pub mod console_on_host;
#[path = "../../src/error.rs"]
pub mod error;
#[path = "../../src/exercise.rs"]
pub mod exercise;
#[path = "../../src/failure.rs"]
pub mod failure;
#[path = "../../src/gap"]
pub mod gap {
    //! The tracing's part of it.
    pub mod declared;
}
#[path = "../../src/log.rs"]
pub mod log;
#[path = "../../src/machine.rs"]
pub mod machine;
