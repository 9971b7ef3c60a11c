//! An STM32F405: rigless's models of the STM32F427, which RM0090 describes too, with what they lack.
//!
//! What is modelled, what is not, and what was checked against what stands in `README.md`.

use rigless::device::{Device, DeviceContext, ErasedDevice, Level, RegisterFile, ResetCause};
use rigless::mcu::Mcu;
use rigless::soc::stm32f427::Stm32f427;
use rigless::soc::stm32f427::generated::adc1::{self, cr1, sr};
use rigless::soc::stm32f427::generated::dbg::Register as DbgRegister;
use rigless::soc::stm32f427::generated::flash::Register as FlashRegister;
use rigless::soc::stm32f427::generated::gpioa::Register as PortRegister;
use rigless::soc::stm32f427::generated::rcc::{Register as RccRegister, cir, cr};
use rigless::soc::stm32f427::generated::{tim1, tim3};
use rigless::soc::stm32f427::peripherals::gpio::{Gpio, Pin as PinNumber};
use rigless::soc::stm32f427::peripherals::tim::{Advanced, Tim};
use rigless::soc::stm32f427::peripherals::{adc, flash as interface};
use rigless::soc::{Bus, Error, Layout};
use rigless::time::VirtualNanos;

use basic_timer::BasicTimer;
use bridge_timer::BridgeTimer;
use converter::Converter;
use dac::Dac;
use flash::Flash;
use pins::Pin;

pub mod basic_timer;
pub mod bridge_timer;
pub mod converter;
pub mod dac;
pub mod description;
pub mod flash;
pub mod pins;

/// Which model answers for which instance.
#[derive(Debug, Clone, Copy)]
struct Slots {
    tim7: usize,
    dac: usize,
    tim1: usize,
    adc1: usize,
    flash: usize,
    debug: usize,
}

/// The chip.
#[derive(Debug)]
pub struct Stm32f405 {
    /// The models that are rigless's own.
    pub part: Stm32f427,
    /// The throttle's tick.
    pub tim7: BasicTimer,
    /// The position tracks.
    pub dac: Dac,
    /// The bridge.
    pub tim1: BridgeTimer,
    /// The controller's tick.
    pub adc1: Converter,
    /// The program's memory and its parameters.
    pub flash: Flash,
    /// Whether the crystal stands still: a fault for a test.
    crystal_is_dead: bool,
    /// What the pins are driven to from outside.
    driven: Vec<(Pin, Level)>,
    slots: Slots,
}

impl Stm32f405 {
    /// Out of reset, with a crystal of 8 MHz and 3.3 V.
    ///
    /// # Errors
    /// rigless describes the part otherwise than expected: it is another version.
    pub fn new() -> Result<Self, Error> {
        let mut part = Stm32f427::new()?;
        part.rcc.attach_crystals(8_000_000, 0);
        part.set_supply(SUPPLY);
        *part.bus_mut() = description::bus()?;
        let bus = part.bus();
        let slots = Slots {
            tim7: bus.slot("TIM7")?,
            dac: bus.slot("DAC")?,
            tim1: bus.slot(bridge_timer::INSTANCE)?,
            adc1: bus.slot("ADC1")?,
            flash: bus.slot("FLASH")?,
            debug: bus.slot("DBG")?,
        };
        let (timer, adc, interface) = Self::fresh_models()?;
        Ok(Self {
            part,
            tim7: BasicTimer::default(),
            dac: Dac::default(),
            tim1: BridgeTimer::new(timer),
            adc1: Converter::new(adc),
            flash: Flash::new(interface),
            crystal_is_dead: false,
            driven: Vec::new(),
            slots,
        })
    }

    /// rigless's models that ours contain, out of reset.
    fn fresh_models() -> Result<(Tim<Advanced>, adc::Adc, interface::Flash), Error> {
        let mut part = Stm32f427::new()?;
        part.set_supply(SUPPLY);
        let Stm32f427 {
            advanced: [timer, _],
            adc: [mut adc, _, _],
            flash,
            ..
        } = part;
        adc.set_reference(SUPPLY);
        Ok((timer, adc, flash))
    }

    /// The level on a pin, as a wire soldered to it has it.
    pub fn level(&mut self, pin: Pin) -> Level {
        let (port, registers) = self.part.port(pin.port);
        port.level(pin.number(), registers)
    }

    /// Drives a pin from outside, and what hears it: the port, the timer whose input it is, the break
    /// input.
    pub fn drive(&mut self, at: VirtualNanos, pin: Pin, level: Level) {
        self.driven.retain(|(other, _)| *other != pin);
        self.driven.push((pin, level));
        let number: PinNumber = pin.number();
        let function = self
            .part
            .drive_port(at, pin.port, |port, registers, context| {
                port.drive(number, Some(level), registers, context);
                Gpio::function(number, registers)
            });
        if let Some(input) = pin.timer_input()
            && function == Some(input.function)
        {
            self.part
                .drive_timer(at, input.timer, |timer, registers, context| {
                    timer.drive_input(input.channel, level, registers, context);
                });
        }
        if pin == pins::BRIDGE_BREAK {
            let Self {
                part, tim1, slots, ..
            } = self;
            let (registers, mut context): (&mut RegisterFile, DeviceContext<'_>) =
                part.bus_mut().drive(at, slots.tim1);
            tim1.drive_break(level, registers, &mut context);
        }
    }

    /// Drives every pin anew, as its wire does behind a reset too.
    pub fn drive_again(&mut self, at: VirtualNanos) {
        for (pin, level) in self.driven.clone() {
            self.drive(at, pin, level);
        }
    }

    /// Puts a voltage on an input of ADC1, mV.
    pub fn set_analogue(&mut self, channel: u8, millivolts: u32) {
        if let Some(channel) = adc::Channel::new(channel) {
            self.adc1.adc.set_input(channel, millivolts);
        }
    }

    /// Level of the interrupt line of the three converters, of which images use the first: RM0090, section 13.11.
    pub fn converter_interrupt(&self) -> Level {
        let status = self.register(self.slots.adc1, adc1::Register::Sr);
        let control = self.register(self.slots.adc1, adc1::Register::Cr1);
        let asks = [
            (sr::EOC, cr1::EOCIE),
            (sr::JEOC, cr1::JEOCIE),
            (sr::AWD, cr1::AWDIE),
            (sr::OVR, cr1::OVRIE),
        ];
        let is_high = asks
            .iter()
            .any(|(flag, enable)| flag.is_set(status) && enable.is_set(control));
        Level::from(is_high)
    }

    fn register<R: Layout>(&self, slot: usize, register: R) -> u64 {
        self.part.bus().slots()[slot].registers().get(register)
    }

    /// The alternate function that a pin carries, if it carries one.
    fn function(&mut self, pin: Pin) -> Option<u8> {
        let (_, registers) = self.part.port(pin.port);
        Gpio::function(pin.number(), registers)
    }

    /// Share of the supply that the two half bridges put on the winding, −1 to 1; none while the timer
    /// has let go of them, or where not all four switches are its own, with the dead time that
    /// `docs/board.md` has. From the compare values, without that.
    pub fn bridge(&mut self) -> Option<f64> {
        /// `MOE` of `TIM1_BDTR`, and its dead time.
        const MASTER_ENABLE: u64 = 1 << 15;
        const DEAD_TIME: u64 = 0xff;
        /// Half a microsecond at 168 MHz.
        const HALF_MICROSECOND: u64 = 84;
        /// `CC1E`, `CC1NE`, `CC2E`, `CC2NE` of `TIM1_CCER`; and its bits of polarity for these.
        const SWITCHES: u64 = 0x55;
        const POLARITY: u64 = 0xaa;
        let reach_pins = pins::BRIDGE.map(|pin| self.function(pin) == Some(pins::BRIDGE_FUNCTION));
        let tim1 = |register| self.register(self.slots.tim1, register);
        let period = tim1(tim1::Register::Arr) as f64;
        let breaking = tim1(tim1::Register::Bdtr);
        let enabled = tim1(tim1::Register::Ccer) & (SWITCHES | POLARITY) == SWITCHES
            && breaking & MASTER_ENABLE != 0
            && breaking & DEAD_TIME == HALF_MICROSECOND;
        let difference = tim1(tim1::Register::Ccr1) as f64 - tim1(tim1::Register::Ccr2) as f64;
        (enabled && reach_pins == [true; 4] && period > 0.0).then(|| difference / period)
    }

    /// Share of time that the PWM of TIM4's channel 3 is high at its pin, 0 to 1: the throttle's current output.
    pub fn current_output(&mut self) -> f64 {
        const TIM4: usize = 2;
        /// `CC3E` of `TIM4_CCER`, and its polarity.
        const ENABLE: u64 = 0x100;
        const POLARITY: u64 = 0x200;
        let reaches_pin =
            self.function(pins::CURRENT_OUTPUT) == Some(pins::CURRENT_OUTPUT_FUNCTION);
        let (_, registers) = self.part.timer(TIM4);
        if !reaches_pin || registers.get(tim3::Register::Ccer) & (ENABLE | POLARITY) != ENABLE {
            return 0.0;
        }
        let compare = registers.get(tim3::Register::Ccr3) as f64;
        compare / (registers.get(tim3::Register::Arr) as f64 + 1.0)
    }

    /// Codes of the two position tracks at their pins, 0 to 4095: 0 where a pin is not the converter's.
    pub fn tracks(&mut self) -> [u16; 2] {
        /// A pin's mode in `GPIOx_MODER` that leaves it to the converter.
        const ANALOGUE: u64 = 3;
        let [first, second] = pins::TRACKS.map(|pin| {
            let (_, registers) = self.part.port(pin.port);
            registers.get(PortRegister::Moder) >> (2 * pin.index) & ANALOGUE == ANALOGUE
        });
        let [one, two] = self.dac.outputs();
        [if first { one } else { 0 }, if second { two } else { 0 }]
    }

    /// Whether the core waits for an operation of the flash.
    pub fn is_stalled(&self) -> bool {
        Flash::is_busy(self.part.bus().slots()[self.slots.flash].registers())
    }

    /// Stops the crystal, or lets it swing again. What clocks from it is clock security's, where that is on.
    pub fn stop_crystal(&mut self, at: VirtualNanos, is_dead: bool) {
        self.crystal_is_dead = is_dead;
        if is_dead {
            self.part.drive_clocks(at, |clocks, registers, context| {
                clocks.fail_hse(registers, context);
            });
        }
    }

    /// Whether clock security has noticed that the crystal stopped: it asks for the exception that cannot be
    /// masked.
    pub fn asks_for_nmi(&mut self) -> bool {
        let (_, registers) = self.part.clocks();
        cir::CSSF.is_set(registers.get(RccRegister::Cir))
    }

    /// Keeps a dead crystal from becoming ready: rigless's model takes any for one that swings. To be called
    /// behind each access that may have started it.
    pub fn hold_crystal(&mut self, at: VirtualNanos) {
        if !self.crystal_is_dead {
            return;
        }
        self.part.drive_clocks(at, |clocks, registers, context| {
            let control = registers.get(RccRegister::Cr);
            if cr::HSEON.is_set(control) {
                let stopped = cr::HSEON.set(control, 0);
                registers.set(RccRegister::Cr, stopped);
                Device::write(clocks, RccRegister::Cr, stopped, registers, context);
            }
        });
    }

    /// Sets the supply, mV, which the voltage detector compares with its level.
    pub fn set_supply(&mut self, millivolts: u32) {
        self.part.set_supply(millivolts);
    }

    /// Cuts the supply, or gives it back.
    pub fn supply(&mut self, at: VirtualNanos, is_on: bool) {
        let slot = self.slots.flash;
        let (_, mut context): (&mut RegisterFile, DeviceContext<'_>) =
            self.part.bus_mut().drive(at, slot);
        context.request_power(is_on);
    }

    /// What stands still while a probe has halted the core: `DBGMCU_APB1_FZ` and `DBGMCU_APB2_FZ`.
    pub fn debug_freeze(&self) -> [u64; 2] {
        [DbgRegister::DbgmcuApb1Fz, DbgRegister::DbgmcuApb2Fz]
            .map(|register| self.register(self.slots.debug, register))
    }

    /// What the flash's access control register reads: wait states, prefetch and caches.
    pub fn flash_access_control(&self) -> u64 {
        self.register(self.slots.flash, FlashRegister::Acr)
    }
}

/// What `RCC_CSR` reads behind power on: RM0090, section 7.3.21.
const POWER_ON: u64 = 0x0e00_0000;

/// The chip's supply and reference, mV.
pub const SUPPLY: u32 = 3300;

impl Mcu for Stm32f405 {
    fn bus(&self) -> &Bus {
        self.part.bus()
    }

    fn bus_mut(&mut self) -> &mut Bus {
        self.part.bus_mut()
    }

    /// The part builds itself anew, on a bus like its own: it is lent one with the registers of ours,
    /// and gives back what a reset keeps of them.
    fn reset(&mut self, at: VirtualNanos, cause: ResetCause) {
        let assembled = "a chip that was assembled once is assembled again";
        let mut lent = description::registers().build().expect(assembled);
        description::exchange_registers(&mut lent, self.part.bus_mut());
        *self.part.bus_mut() = lent;
        let options = self.flash_options();
        // rigless has the part lose its supply never: the flags are set behind it.
        let (taken, flags) = match cause {
            ResetCause::PowerOn => (ResetCause::Pin, Some(POWER_ON)),
            other => (other, None),
        };
        self.part.reset(at, taken);
        if let Some(flags) = flags {
            let (_, registers) = self.part.clocks();
            registers.set(RccRegister::Csr, flags);
        }
        let mut own = description::bus().expect(assembled);
        description::exchange_registers(&mut own, self.part.bus_mut());
        *self.part.bus_mut() = own;
        let (timer, mut adc, mut interface) = Self::fresh_models().expect(assembled);
        adc.inherit(&self.adc1.adc);
        let (_, registers) = self.part.program();
        interface.keep_options(options.0, options.1, registers);
        self.tim1 = self.tim1.restarted(timer);
        self.adc1.adc = adc;
        self.flash = self.flash.restarted(interface);
        Device::reset(&mut self.tim7);
        Device::reset(&mut self.dac);
    }

    fn poll(&mut self, now: VirtualNanos) {
        self.part.poll(now);
    }

    fn split(&mut self, slot: usize) -> (&mut Bus, Option<&mut dyn ErasedDevice>) {
        let Self {
            part,
            tim7,
            dac,
            tim1,
            adc1,
            flash,
            slots,
            ..
        } = self;
        let model: &mut dyn ErasedDevice = if slot == slots.tim7 {
            tim7
        } else if slot == slots.dac {
            dac
        } else if slot == slots.tim1 {
            tim1
        } else if slot == slots.adc1 {
            adc1
        } else if slot == slots.flash {
            flash
        } else {
            return part.split(slot);
        };
        (part.bus_mut(), Some(model))
    }
}

impl Stm32f405 {
    /// The option registers, which a reset keeps. An image writes the level of its brown-out reset there, once.
    pub fn flash_options(&self) -> (u64, u64) {
        (
            self.register(self.slots.flash, FlashRegister::Optcr),
            self.register(self.slots.flash, FlashRegister::Optcr1),
        )
    }
}
