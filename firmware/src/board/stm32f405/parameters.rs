//! The parameters' place: the second, third and fourth sector of 16 KB.

use embassy_stm32::Peri;
use embassy_stm32::flash::{Bank1Region1, Blocking, Error, Flash};
use embassy_stm32::peripherals::FLASH;
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use model_core::numeric::invalid_parameter::InvalidParameter;

use super::cache;
use crate::app::store::Store;

/// Where the second sector begins in the region: the first one holds the vector table.
const START: u32 = 0x4000;

/// The region of the sectors of 16 KB.
///
/// Its operations end before they return, with the processor standing still: whoever awaits one does
/// not wait.
pub struct Region(Bank1Region1<'static, Blocking>);

/// The store in it.
///
/// # Errors
/// None: the region has the sectors.
pub fn store(flash: Peri<'static, FLASH>) -> Result<Store<Region>, InvalidParameter> {
    let regions = Flash::new_blocking(flash).into_blocking_regions();
    Store::new(Region(regions.bank1_region1), START)
}

impl ErrorType for Region {
    type Error = Error;
}

impl ReadNorFlash for Region {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Error> {
        self.0.blocking_read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        4 * Self::ERASE_SIZE
    }
}

impl NorFlash for Region {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = 16 * 1024;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Error> {
        let result = self.0.blocking_erase(from, to);
        cache::forget_data();
        result
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Error> {
        self.0.blocking_write(offset, bytes)
    }
}
