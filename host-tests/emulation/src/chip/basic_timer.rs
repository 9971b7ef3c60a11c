//! TIM7, a basic timer: RM0090, chapter 20.
//!
//! Modelled: counting up from `CK_INT` with prescaler and auto-reload, `CEN`, `UG`, `URS`, `UIF`, `UIE`.
//! Not modelled: the count itself (it reads 0), one-pulse mode, `UDIS`, the triggers for DMA and DAC, and
//! the buffering of a new reload value (it acts at the next start or `UG`).

use rigless::device::{Device, DeviceContext, Level, RegisterFile};
use rigless::soc::stm32f427::generated::tim6::Register;
use rigless::time::{EventId, VirtualNanos};

const ENABLE: u64 = 1;
const UPDATE_REQUEST_SOURCE: u64 = 1 << 2;
const UPDATE: u64 = 1;

/// The timer, with what it counts for the test.
#[derive(Debug, Default)]
pub struct BasicTimer {
    clock: u64,
    running: bool,
    /// When the count was last at its start, and how many periods ended since.
    base: u64,
    periods: u64,
    period_cycles: u64,
    event: Option<EventId>,
    level: Option<Level>,
    /// Periods that ended since the reset.
    pub updates: u64,
    /// Those of them at which the one before had not been acknowledged: a tick that the program missed.
    pub missed: u64,
    /// Longest time from a tick to its acknowledgement by the program, ns.
    pub longest_latency: u64,
    since: Option<u64>,
    /// No period ends while this is set: a fault for a test.
    pub is_stopped: bool,
}

impl BasicTimer {
    fn schedule(&mut self, context: &mut DeviceContext<'_>) {
        if !self.running || self.clock == 0 {
            self.event = None;
            return;
        }
        let cycles = u128::from(self.periods + 1) * u128::from(self.period_cycles);
        let nanoseconds = cycles * 1_000_000_000 / u128::from(self.clock);
        // A run is far shorter than the 584 years of the virtual clock.
        let at = VirtualNanos(self.base + nanoseconds as u64);
        self.event = Some(context.schedule(at));
    }

    fn start_period(&mut self, registers: &RegisterFile, context: &mut DeviceContext<'_>) {
        let prescaler = (registers.get(Register::Psc) & 0xffff) + 1;
        let reload = (registers.get(Register::Arr) & 0xffff) + 1;
        self.period_cycles = prescaler * reload;
        self.base = context.now().0;
        self.periods = 0;
        self.schedule(context);
    }

    fn drive_interrupt(&mut self, registers: &RegisterFile, context: &mut DeviceContext<'_>) {
        let pending = registers.get(Register::Sr) & registers.get(Register::Dier) & UPDATE != 0;
        let level = Level::from(pending);
        if self.level != Some(level) {
            self.level = Some(level);
            context.interrupt(0, level);
        }
    }
}

impl Device for BasicTimer {
    type Register = Register;

    fn write(
        &mut self,
        register: Register,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        match register {
            Register::Cr1 => {
                let running = value & ENABLE != 0;
                if running != self.running {
                    self.running = running;
                    self.start_period(registers, context);
                }
            }
            Register::Egr if value & UPDATE != 0 => {
                self.start_period(registers, context);
                if registers.get(Register::Cr1) & UPDATE_REQUEST_SOURCE == 0 {
                    let status = registers.get(Register::Sr);
                    registers.set(Register::Sr, status | UPDATE);
                }
            }
            Register::Sr if registers.get(Register::Sr) & UPDATE == 0 => {
                if let Some(since) = self.since.take() {
                    self.longest_latency = self.longest_latency.max(context.now().0 - since);
                }
            }
            _ => {}
        }
        self.drive_interrupt(registers, context);
    }

    fn on_event(
        &mut self,
        event: EventId,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        if self.event != Some(event) {
            return;
        }
        self.periods += 1;
        if !self.is_stopped {
            let status = registers.get(Register::Sr);
            self.updates += 1;
            self.missed += status & UPDATE;
            if registers.get(Register::Dier) & UPDATE != 0 {
                self.since.get_or_insert(context.now().0);
            }
            registers.set(Register::Sr, status | UPDATE);
            self.drive_interrupt(registers, context);
        }
        self.schedule(context);
    }

    fn on_clock(&mut self, hz: u64, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.clock = hz;
        if self.running {
            self.start_period(registers, context);
        }
    }

    /// What the test counts goes on.
    fn reset(&mut self) {
        *self = Self {
            clock: self.clock,
            updates: self.updates,
            missed: self.missed,
            longest_latency: self.longest_latency,
            is_stopped: self.is_stopped,
            ..Self::default()
        };
    }
}
