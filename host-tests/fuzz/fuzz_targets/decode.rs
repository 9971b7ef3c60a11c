//! Any bytes as a board's log, decoded with an image of a few words, and as the image itself.
#![no_main]

use std::path::PathBuf;
use std::sync::LazyLock;

use fuzz::board_log::Dictionary;
use fuzz::exercise;
use libfuzzer_sys::fuzz_target;

#[expect(dead_code, reason = "the fuzzer makes its own frames")]
#[path = "../../tests/board_image/mod.rs"]
mod board_image;

static DICTIONARY: LazyLock<Dictionary> = LazyLock::new(|| {
    let image = board_image::image("rzcobs");
    Dictionary::of_bytes(&PathBuf::from("image"), &image).expect("an image with a defmt log")
});

fuzz_target!(|bytes: &[u8]| {
    exercise::board_log(&DICTIONARY, bytes);
    // An image is refused or has words: nothing else.
    drop(Dictionary::of_bytes(&PathBuf::from("bytes"), bytes));
});
