//! The pins that the images use, and the timer inputs behind them: the table in
//! `firmware/src/board/stm32f405/pins.rs`, and the STM32F405's data sheet, DS8626, table 9.

use rigless::soc::st::tim::Channel;
use rigless::soc::stm32f427::peripherals::gpio::Pin as PinNumber;

/// A pin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pin {
    /// Port: 0 for A.
    pub port: usize,
    /// Number in the port, 0 to 15.
    pub index: u8,
}

/// A timer's input behind a pin.
#[derive(Debug, Clone, Copy)]
pub struct TimerInput {
    /// Number of the alternate function that joins them.
    pub function: u8,
    /// Which general-purpose timer: 0 for TIM2.
    pub timer: usize,
    /// Which of its channels.
    pub channel: Channel,
}

const fn pin(port: usize, index: u8) -> Pin {
    Pin { port, index }
}

/// Throttle: PWM in.
pub const DUTY: Pin = pin(0, 0);
/// Throttle: direction, high towards larger positions.
pub const DIRECTION: Pin = pin(0, 1);
/// Throttle: high switches its bridge off.
pub const DISABLE: Pin = pin(0, 2);
/// Controller: low, the bridge's driver reports a fault.
pub const BRIDGE_BREAK: Pin = pin(1, 12);
/// Controller: encoder A.
pub const ENCODER_A: Pin = pin(2, 6);
/// Controller: encoder B.
pub const ENCODER_B: Pin = pin(2, 7);
/// All images: bridge enable.
pub const BRIDGE_ENABLE: Pin = pin(2, 8);
/// All images: high releases the holding brake.
pub const BRAKE_RELEASE: Pin = pin(2, 9);
/// Controller: both switches of each half bridge. As an image has them when its bridge can drive, with the
/// alternate function of TIM1.
pub const BRIDGE: [Pin; 4] = [pin(0, 8), pin(1, 13), pin(0, 9), pin(1, 14)];
/// The alternate function of TIM1 at these.
pub const BRIDGE_FUNCTION: u8 = 1;
/// Throttle: motor current as a PWM, by TIM4.
pub const CURRENT_OUTPUT: Pin = pin(1, 8);
/// The alternate function of TIM4 there.
pub const CURRENT_OUTPUT_FUNCTION: u8 = 2;
/// All images: the two position tracks.
pub const TRACKS: [Pin; 2] = [pin(0, 4), pin(0, 5)];
/// Controller: lower limit switch, closed to ground unless reached.
pub const LOWER_SWITCH: Pin = pin(2, 10);
/// Controller: upper limit switch.
pub const UPPER_SWITCH: Pin = pin(2, 11);

/// Controller: emergency stop, closed to ground unless pressed.
pub const EMERGENCY_STOP: Pin = pin(1, 15);

/// Controller: ADC1's channel of the motor current.
pub const CURRENT_CHANNEL: u8 = 10;
/// Controller: ADC1's channel of the bridge's supply.
pub const SUPPLY_CHANNEL: u8 = 11;

/// Controller: ADC1's channels of the temperatures of the switches and the motor.
pub const TEMPERATURE_CHANNELS: [u8; 2] = [12, 13];

impl Pin {
    /// Its number, as rigless has it.
    pub fn number(self) -> PinNumber {
        PinNumber::new(self.index).expect("a port has sixteen pins")
    }

    /// The timer's input that it can be.
    pub fn timer_input(self) -> Option<TimerInput> {
        let (function, timer, channel) = match self {
            DUTY => (1, 0, 1),
            ENCODER_A => (2, 1, 1),
            ENCODER_B => (2, 1, 2),
            _ => return None,
        };
        Some(TimerInput {
            function,
            timer,
            channel: Channel::new(channel)?,
        })
    }
}
