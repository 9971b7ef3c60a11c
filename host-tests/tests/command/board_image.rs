//! An image of a board and frames of its log, made by hand. Also what the fuzzer decodes with.

use object::write::{Object, Symbol, SymbolSection};
use object::{
    Architecture, BinaryFormat, Endianness, SectionKind, SymbolFlags, SymbolKind, SymbolScope,
};

const SAMPLE: &str = "sample sequence={=u32} time_us={=u64} input={=f32} position={=f32} \
                      command={=f32} current_a={=f32} true_position={=f32} true_velocity={=f32} \
                      true_current_a={=f32}";

/// Interned words and their addresses in the image.
const WORDS: [(u64, &str, &str); 6] = [
    (1, "defmt_timestamp", "{=u64:us}"),
    (2, "defmt_info", SAMPLE),
    (3, "defmt_warn", "supply at {=f32} V"),
    (4, "defmt_info", "experiment name=number_{=u8}"),
    (5, "defmt_info", "experiment name=capture"),
    (
        6,
        "defmt_info",
        "capture quantities=position,true_velocity trigger_row={=u8}",
    ),
];

/// An ELF file with the symbols that defmt leaves in an image.
pub fn image(encoding: &str) -> Vec<u8> {
    let mut object = Object::new(BinaryFormat::Elf, Architecture::Arm, Endianness::Little);
    let section = object.add_section(vec![], b".defmt".to_vec(), SectionKind::Metadata);
    let mut symbol = |name: String, value: u64| {
        object.add_symbol(Symbol {
            name: name.into_bytes(),
            value,
            size: 1,
            kind: SymbolKind::Data,
            scope: SymbolScope::Dynamic,
            weak: false,
            section: SymbolSection::Section(section),
            flags: SymbolFlags::None,
        });
    };
    symbol("_defmt_version_ = 4".to_owned(), 0);
    symbol(format!("_defmt_encoding_ = {encoding}"), 0);
    for (address, tag, data) in WORDS {
        let name = serde_json::json!({
            "package": "board", "disambiguator": "1", "tag": tag, "data": data, "crate_name": "board"
        });
        symbol(name.to_string(), address);
    }
    object.write().unwrap()
}

/// A frame as it is sent: reverse zero-compressing COBS (James Munns' `rzcobs`), then a zero byte.
pub fn frame(message: &[u8]) -> Vec<u8> {
    let mut sent = Vec::new();
    let (mut run, mut zeros) = (0_u8, 0_u8);
    for &byte in message {
        if byte == 0 && run >= 7 {
            sent.push((run - 7) | 0x80);
            (run, zeros) = (0, 0);
            continue;
        }
        if byte == 0 {
            zeros |= 1 << run;
        } else {
            sent.push(byte);
        }
        run += 1;
        if run == 7 && zeros != 0 {
            sent.push(zeros);
            (run, zeros) = (0, 0);
        } else if run == 134 {
            sent.push(0xff);
            (run, zeros) = (0, 0);
        }
    }
    match run {
        0 => {}
        1..=6 => sent.push((zeros | (0xff << run)) & 0x7f),
        _ => sent.push((run - 7) | 0x80),
    }
    sent.push(0);
    sent
}
