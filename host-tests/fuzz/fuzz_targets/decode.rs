//! Any bytes as a board's log, decoded with an image of a few words, and as the image itself.
#![no_main]

use std::sync::LazyLock;

use formats::defmt::Dictionary;
use fuzz::board_log::BoardLog;
use fuzz::exercise;
use libfuzzer_sys::fuzz_target;

#[expect(dead_code, reason = "the fuzzer makes its own frames")]
#[path = "../../tests/command/board_image.rs"]
mod board_image;

static DICTIONARY: LazyLock<Dictionary> = LazyLock::new(|| {
    Dictionary::of_bytes(&board_image::image("rzcobs")).expect("an image with a defmt log")
});

fuzz_target!(|bytes: &[u8]| {
    let mut said = Vec::new();
    DICTIONARY.pass_on(bytes, &mut said).expect("room");
    exercise::board_log(&BoardLog::of_frames(&said[..]), bytes);
    // An image is refused or has words: nothing else.
    drop(Dictionary::of_bytes(bytes));
});
