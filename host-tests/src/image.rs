//! What an image occupies of the microcontroller.

use std::fmt;
use std::ops::Range;
use std::path::Path;

use object::elf::{SHF_ALLOC, SHF_WRITE};
use object::{Object, ObjectSection, SectionFlags, SectionKind};

use crate::board_log::IMAGE;
use crate::error::{InputError, LARGEST_DATA, read_bytes};
use crate::failure::Failure;

/// Where the linker puts what.
const MEMORY: &str = include_str!("../../memory.x");

/// Flash of the STM32F405RG that is the program's, bytes: what is before the recorded drive, without
/// the first four sectors. Of these the vector table has one.
pub fn flash() -> u64 {
    let program = region("FLASH");
    program.end - PARAMETERS.end
}

/// The addresses of a memory of `memory.x`.
///
/// # Panics
/// Of a name that stands in it in no line of the form `NAME : ORIGIN = 0x…, LENGTH = …K`.
pub fn region(name: &str) -> Range<u64> {
    let read = |line: &str| {
        let (named, rest) = line.split_once(" : ORIGIN = 0x")?;
        let (origin, length) = rest.split_once(", LENGTH = ")?;
        let origin = u64::from_str_radix(origin, 16).ok()?;
        let kilobytes: u64 = length.trim_end().strip_suffix('K')?.parse().ok()?;
        (named.trim() == name).then(|| origin..origin + kilobytes * 1024)
    };
    MEMORY.lines().find_map(read).expect("a memory of memory.x")
}

/// The other three: the program stores parameters there. Nothing of an image may lie in them.
const PARAMETERS: Range<u64> = 0x0800_4000..0x0801_0000;

/// SRAM of the STM32F405RG without the core-coupled memory, bytes.
pub const RAM: u64 = 128 * 1024;

/// The core-coupled memory. The linker keeps what is in there within it, and the stack has no use for
/// what is left.
const CORE_COUPLED: Range<u64> = 0x1000_0000..0x1001_0000;

/// Bytes by which the stack of an operated image must be larger than what the check has used of it, with an
/// interrupt in an interrupt: drivers and the console have frames of their own.
const MORE_STACK: u64 = 8 * 1024;

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
    /// No such file, no ELF file, or one with a section where the parameters are stored.
    pub fn read(elf: &Path) -> Result<Self, InputError> {
        let bytes = read_bytes(elf, IMAGE, LARGEST_DATA)?;
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
            if has(SHF_WRITE) && !CORE_COUPLED.contains(&section.address()) {
                size.ram += section.size();
            }
            if section.kind() != SectionKind::UninitializedData {
                size.flash += section.size();
            }
            let end = section.address() + section.size();
            if section.address() < PARAMETERS.end && end > PARAMETERS.start {
                return Err(InputError::new(
                    elf,
                    None,
                    format!(
                        "section {} lies where parameters are stored; _stext in memory.x keeps it out",
                        section.name().unwrap_or("?")
                    ),
                ));
            }
        }
        Ok(size)
    }

    /// The same, if the chip holds it. Whether the stack finds room is seen when it runs.
    ///
    /// # Errors
    /// It does not.
    pub fn fitting(self) -> Result<Self, Failure> {
        self.fitting_with(0)
    }

    /// The same, if the chip holds it with more stack than the check has used.
    ///
    /// # Errors
    /// It does not.
    pub fn fitting_above(self, used: u64) -> Result<Self, Failure> {
        self.fitting_with(used + MORE_STACK)
    }

    fn fitting_with(self, stack: u64) -> Result<Self, Failure> {
        if self.flash <= flash() && self.ram + stack <= RAM {
            Ok(self)
        } else {
            Err(Failure::Other(format!(
                "the image takes {} of {} bytes of flash and {} of {RAM} bytes of RAM, of which \
                 the stack needs {stack}",
                self.flash,
                flash(),
                self.ram
            )))
        }
    }
}

/// What is taken and what is left.
impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kilobytes = |bytes: u64| bytes as f64 / 1024.0;
        write!(
            f,
            "{:.1} KB of flash ({:.1} left), {:.1} KB of RAM ({:.1} left for the stack)",
            kilobytes(self.flash),
            kilobytes(flash().saturating_sub(self.flash)),
            kilobytes(self.ram),
            kilobytes(RAM.saturating_sub(self.ram))
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use object::write::Object as Written;
    use object::{Architecture, BinaryFormat, Endianness};

    /// An image with one section of four bytes.
    fn with_section_at(address: u32) -> Vec<u8> {
        let mut object = Written::new(BinaryFormat::Elf, Architecture::Arm, Endianness::Little);
        let section = object.add_section(vec![], b".text".to_vec(), SectionKind::Text);
        object.append_section_data(section, &[0; 4], 4);
        let mut elf = object.write().unwrap();
        // Where the heads of the sections begin; the first is of none, an address 12 bytes into it.
        let heads = u32::from_le_bytes(elf[32..36].try_into().unwrap()) as usize;
        elf[heads + 40 + 12..][..4].copy_from_slice(&address.to_le_bytes());
        elf
    }

    #[test]
    fn an_image_keeps_out_of_the_stored_parameters() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("image");
        let read = |address| {
            std::fs::write(&path, with_section_at(address)).unwrap();
            Size::read(&path)
        };
        for address in [0x0800_0000, 0x0800_3ffc, 0x0801_0000] {
            assert_eq!(read(address).unwrap(), Size { flash: 4, ram: 0 });
        }
        for address in [0x0800_3ffd, 0x0800_4000, 0x0800_fffc, 0x0800_ffff] {
            let error = read(address).unwrap_err().to_string();
            assert!(error.contains("section .text lies where"), "{error}");
        }
    }

    #[test]
    fn an_image_fits_to_the_last_byte() {
        let used = RAM / 2;
        let full = Size {
            flash: flash(),
            ram: RAM,
        };
        let real = Size {
            flash: flash(),
            ram: RAM - used - MORE_STACK,
        };
        assert_eq!(full.fitting().unwrap(), full);
        assert_eq!(real.fitting_above(used).unwrap(), real);
        for over in [
            Size {
                flash: flash() + 1,
                ..real
            },
            Size {
                ram: real.ram + 1,
                ..real
            },
        ] {
            assert!(over.fitting_above(used).is_err(), "{over:?}");
        }
        let over = Size {
            flash: flash(),
            ram: RAM + 1,
        };
        assert!(over.fitting().is_err());
    }

    #[test]
    fn a_size_says_what_is_left() {
        let size = Size {
            flash: 48 * 1024,
            ram: 3 * 1024 + 512,
        };
        assert_eq!(
            size.to_string(),
            "48.0 KB of flash (656.0 left), 3.5 KB of RAM (124.5 left for the stack)"
        );
    }
}
