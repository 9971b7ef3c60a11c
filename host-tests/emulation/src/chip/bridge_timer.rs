//! TIM1 with its trigger output led to the converters, and the level of its break input.
//!
//! The timer is rigless's model of RM0090, chapter 17. Added: each rising edge of `TRGO` becomes a request
//! that [`super::converter`] hears (table 68), and the level of `BKIN`, which rigless does not take from a
//! pin, is put on the timer whenever its break register is written (section 17.3.12).

use rigless::device::{Device, DeviceContext, Level, RegisterFile, RequestChange};
use rigless::soc::RegisterSpec;
use rigless::soc::stm32f427::generated::tim1::Register;
use rigless::soc::stm32f427::peripherals::tim::{Advanced, Tim};
use rigless::time::{EventId, VirtualNanos};

/// Name of the instance.
pub const INSTANCE: &str = "TIM1";

/// The request that is `TRGO`. The timer's own ones for DMA have smaller numbers.
pub const TRIGGER_OUTPUT: usize = 32;

/// The timer.
#[derive(Debug)]
pub struct BridgeTimer {
    timer: Tim<Advanced>,
    trigger: Level,
    break_input: Level,
    /// Rising edges of `TRGO` since the chip was made.
    pub triggers: u64,
}

impl BridgeTimer {
    /// With nothing on its break input, which rests high on a pin that is pulled up.
    pub fn new(timer: Tim<Advanced>) -> Self {
        Self {
            timer,
            trigger: Level::Low,
            break_input: Level::High,
            triggers: 0,
        }
    }

    /// As after a reset, with what lies outside the chip as it is.
    pub fn restarted(&self, timer: Tim<Advanced>) -> Self {
        Self {
            timer,
            trigger: Level::Low,
            ..*self
        }
    }

    /// Drives the break input.
    pub fn drive_break(
        &mut self,
        level: Level,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        self.break_input = level;
        self.timer.drive_break(level, registers, context);
    }

    fn follow_trigger(&mut self, context: &mut DeviceContext<'_>) {
        let (level, _) = self.timer.trigger_output();
        if level != self.trigger {
            self.trigger = level;
            self.triggers += u64::from(level == Level::High);
            context.request(TRIGGER_OUTPUT, level);
        }
    }
}

impl Device for BridgeTimer {
    type Register = Register;

    fn layout(&self) -> &'static [RegisterSpec] {
        Device::layout(&self.timer)
    }

    fn read(
        &mut self,
        register: Register,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) -> Option<u64> {
        let value = self.timer.read(register, registers, context);
        self.follow_trigger(context);
        value
    }

    fn peek(&self, register: Register, registers: &RegisterFile, now: VirtualNanos) -> Option<u64> {
        self.timer.peek(register, registers, now)
    }

    fn write(
        &mut self,
        register: Register,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        if register == Register::Bdtr {
            self.timer.drive_break(self.break_input, registers, context);
        }
        self.timer.write(register, value, registers, context);
        self.follow_trigger(context);
    }

    fn on_event(
        &mut self,
        event: EventId,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        self.timer.on_event(event, registers, context);
        self.follow_trigger(context);
    }

    fn on_request(
        &mut self,
        change: RequestChange,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        self.timer.on_request(change, registers, context);
        self.follow_trigger(context);
    }

    fn on_clock(&mut self, hz: u64, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.timer.on_clock(hz, registers, context);
    }

    fn reset(&mut self) {
        Device::reset(&mut self.timer);
        self.trigger = Level::Low;
    }

    fn reset_line(&mut self, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.timer.reset_line(registers, context);
        self.trigger = Level::Low;
    }
}
