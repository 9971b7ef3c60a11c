//! ADC1 with the trigger of its injected group: RM0090, section 13.6 and table 68.
//!
//! The converter is rigless's model of chapter 13, where software alone starts a conversion. Added: a
//! rising edge of TIM1's `TRGO` starts the injected group where `JEXTEN` and `JEXTSEL` say so. Not modelled:
//! the other triggers, and those of the regular group.

use rigless::device::{Device, DeviceContext, Level, RegisterFile, RequestChange};
use rigless::soc::stm32f427::generated::adc1::{Register, cr2, sr};
use rigless::soc::stm32f427::peripherals::adc::Adc;
use rigless::time::EventId;

use super::bridge_timer;

/// `JEXTSEL`: TIM1's `TRGO`.
const TIM1_TRIGGER_OUTPUT: u64 = 1;
/// `JEXTEN`: the rising edge, and both.
const RISING: [u64; 2] = [1, 3];

/// The converter.
#[derive(Debug)]
pub struct Converter {
    /// What converts, with what is on its pins.
    pub adc: Adc,
    /// Injected groups that a trigger started, since the chip was made.
    pub conversions: u64,
    /// Those of them at which the end of the one before had not been acknowledged: a tick that the program
    /// missed.
    pub missed: u64,
    /// Longest time from the end of a group to its acknowledgement by the program, ns.
    pub longest_latency: u64,
    since: Option<u64>,
    /// No trigger starts it while this is set: a fault for a test.
    pub is_stopped: bool,
}

impl Converter {
    /// Nothing converted yet.
    pub fn new(adc: Adc) -> Self {
        Self {
            adc,
            conversions: 0,
            missed: 0,
            longest_latency: 0,
            since: None,
            is_stopped: false,
        }
    }
}

impl Device for Converter {
    type Register = Register;

    fn read(
        &mut self,
        register: Register,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) -> Option<u64> {
        self.adc.read(register, registers, context)
    }

    fn write(
        &mut self,
        register: Register,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        self.adc.write(register, value, registers, context);
        if register == Register::Sr
            && !sr::JEOC.is_set(registers.get(Register::Sr))
            && let Some(since) = self.since.take()
        {
            self.longest_latency = self.longest_latency.max(context.now().0 - since);
        }
    }

    fn on_event(
        &mut self,
        event: EventId,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        self.adc.on_event(event, registers, context);
        if sr::JEOC.is_set(registers.get(Register::Sr)) {
            self.since.get_or_insert(context.now().0);
        }
    }

    fn on_request(
        &mut self,
        change: RequestChange,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        let is_trigger = change.instance == bridge_timer::INSTANCE
            && change.request == bridge_timer::TRIGGER_OUTPUT;
        if !is_trigger {
            self.adc.on_request(change, registers, context);
            return;
        }
        let control = registers.get(Register::Cr2);
        let is_chosen = cr2::JEXTSEL.get(control) == TIM1_TRIGGER_OUTPUT
            && RISING.contains(&cr2::JEXTEN.get(control));
        let is_heard = is_chosen && cr2::ADON.is_set(control) && !self.is_stopped;
        if change.level == Level::High && is_heard {
            self.conversions += 1;
            self.missed += u64::from(sr::JEOC.is_set(registers.get(Register::Sr)));
            // What software would write to start it; the model takes the bit back.
            let started = cr2::JSWSTART.set(control, 1);
            registers.set(Register::Cr2, started);
            self.adc.write(Register::Cr2, started, registers, context);
        }
    }

    fn on_clock(&mut self, hz: u64, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.adc.on_clock(hz, registers, context);
    }

    fn reset(&mut self) {
        Device::reset(&mut self.adc);
        self.since = None;
    }

    fn reset_line(&mut self, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.adc.reset_line(registers, context);
    }
}
