//! `cargo hil` as a user calls it: what it reads, refuses, prints and leaves.

mod bad_input;
mod bench_command;
mod bench_points;
mod board_image;
mod capture;
mod command_line;
mod decode;
#[path = "../../formats/src/defmt.rs"]
mod defmt;
mod documents;
mod export;
#[path = "../../formats/src/guard.rs"]
mod guard;
mod identify_command;
mod import;
mod live;
mod machine_command;
mod outputs;
mod printed_log;
#[path = "../tracing/pushed_slide.rs"]
mod pushed_slide;
mod record;
mod replay;
mod track;
