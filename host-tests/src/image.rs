//! What an image occupies of the microcontroller.

use std::path::Path;

use object::elf::{SHF_ALLOC, SHF_WRITE};
use object::{Object, ObjectSection, SectionFlags, SectionKind};

use crate::board_log;
use crate::error::InputError;

/// Flash of the STM32F405RG, bytes.
pub const FLASH: u64 = 1024 * 1024;

/// SRAM of the STM32F405RG without the core-coupled memory, bytes.
pub const RAM: u64 = 128 * 1024;

/// Bytes of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    /// Code, constants, and the initial values of variables.
    pub flash: u64,
    /// Variables. What is left of the RAM is the stack's.
    pub ram: u64,
}

impl Size {
    /// Adds up an ELF file's sections.
    ///
    /// # Errors
    /// No such file, or no ELF file.
    pub fn read(elf: &Path) -> Result<Self, InputError> {
        let bytes = board_log::read(elf, "the board's image (ELF)")?;
        let file = object::File::parse(&*bytes).map_err(|error| {
            InputError::new(
                elf,
                None,
                format!("{error}; expected the board's image (ELF)"),
            )
        })?;
        let mut size = Self { flash: 0, ram: 0 };
        for section in file.sections() {
            let SectionFlags::Elf { sh_flags } = section.flags() else {
                continue;
            };
            let has = |flag: u32| sh_flags & u64::from(flag) != 0;
            if !has(SHF_ALLOC) {
                continue;
            }
            if has(SHF_WRITE) {
                size.ram += section.size();
            }
            if section.kind() != SectionKind::UninitializedData {
                size.flash += section.size();
            }
        }
        Ok(size)
    }

    /// Whether the chip holds it.
    pub fn fits(&self) -> bool {
        self.flash <= FLASH && self.ram <= RAM
    }
}
