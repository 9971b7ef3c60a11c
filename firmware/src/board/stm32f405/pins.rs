//! The pins, all in one place: each image takes those that it needs, and no pin is there twice.
//!
//! | pin | function | image | use | safe |
//! |---|---|---|---|---|
//! | PH0, PH1 | OSC | all | crystal: 8 MHz, with the feature `crystal-12mhz` 12 MHz | |
//! | PA13, PA14 | SWD | all | debug probe, and the log | |
//! | PB6, PB7 | USART1 TX, RX, AF7; DMA2 streams 7 and 2, channel 4 | throttle, controller | console, 115,200 baud, 8N1 | |
//! | PC12 | output | throttle, controller | LED to ground: on armed, slow disarmed, fast with a fault | |
//! | PA4, PA5 | DAC1, DAC2 | all | position tracks, 0 to 3.3 V, through an op-amp of gain 5/3.3 | both 0 V |
//! | PB8 | TIM4 CH3, AF2, 41 kHz | throttle | motor current, −25 to 25 A over 0 to 3.3 V behind two RC stages | 0 V |
//! | PA0 | TIM2 CH1, AF1 | throttle | PWM in, 400 Hz to 40 kHz | pulled down: 0 |
//! | PA1 | input | throttle | direction: high towards larger positions | pulled down |
//! | PA2 | input | throttle | disable: high switches the emulated bridge off | pulled up: off |
//! | PA8, PB13 | TIM1 CH1, CH1N, AF1 | controller | half bridge at the winding's positive end: upper, lower switch | both low |
//! | PA9, PB14 | TIM1 CH2, CH2N, AF1 | controller | half bridge at the negative end | both low |
//! | PB12 | TIM1 BKIN, AF1 | controller | low: the bridge's driver reports a fault, and the timer lets go of the bridge | pulled up |
//! | PC8 | output | all | bridge enable, active high; needs a pull-down for the time before it is driven | low |
//! | PC9 | output | controller | high releases the brake; needs a pull-down | low: the brake holds |
//! | PC0 | ADC1 channel 10 | controller | motor current, 66 mV/A about 1.65 V, from a shunt in line with the motor | |
//! | PC1 | ADC1 channel 11 | controller | supply of the bridge, divided by 11 | |
//! | PC2 | ADC1 channel 12 | controller | NTC of the switches, to ground; 10 kΩ to 3.3 V | |
//! | PC3 | ADC1 channel 13 | controller | NTC of the motor, the same | |
//! | PC6, PC7 | TIM3 CH1, CH2, AF2 | controller | encoder A and B, filtered, 0.38 µs | pulled up |
//! | PC10, PC11 | input | controller | lower, upper limit switch, normally closed to ground | pulled up: reached |
//! | PB15 | input | controller | emergency stop, normally closed to ground; a strap to ground on a board without one | pulled up: pressed |
//!
//! TIM5 is embassy's clock and TIM7 the plant's tick where no converter gives it. DAC and ADC are used
//! without DMA. The DAC's output buffers, which leave 0.2 V at either end, are off: its outputs have
//! 15 kΩ and drive inputs of high impedance.
//!
//! `docs/board.md` has a drawing.

use embassy_stm32::Peri;
use embassy_stm32::Peripherals;
use embassy_stm32::peripherals::{
    ADC1, DAC1, DMA2_CH2, DMA2_CH7, FLASH, IWDG, PA0, PA1, PA2, PA4, PA5, PA8, PA9, PB6, PB7, PB8,
    PB12, PB13, PB14, PB15, PC0, PC1, PC2, PC3, PC6, PC7, PC8, PC9, PC10, PC11, PC12, TIM1, TIM2,
    TIM3, TIM4, TIM7, USART1,
};

/// The two tracks.
pub struct Tracks {
    pub(super) converter: Peri<'static, DAC1>,
    pub(super) first: Peri<'static, PA4>,
    pub(super) second: Peri<'static, PA5>,
}

/// What holds the actuator or lets it go, and the clock of an emulated plant.
pub struct Safety {
    pub(super) bridge_enable: Peri<'static, PC8>,
    pub(super) brake_release: Peri<'static, PC9>,
    pub(super) watchdog: Peri<'static, IWDG>,
}

/// The console and what it keeps.
pub struct Terminal {
    pub(super) uart: Peri<'static, USART1>,
    pub(super) transmit: Peri<'static, PB6>,
    pub(super) receive: Peri<'static, PB7>,
    pub(super) transmit_dma: Peri<'static, DMA2_CH7>,
    pub(super) receive_dma: Peri<'static, DMA2_CH2>,
    pub(super) led: Peri<'static, PC12>,
    pub(super) flash: Peri<'static, FLASH>,
}

/// An emulated throttle body's wires.
pub struct Body {
    pub(super) duty_timer: Peri<'static, TIM2>,
    pub(super) duty: Peri<'static, PA0>,
    pub(super) direction: Peri<'static, PA1>,
    pub(super) disable: Peri<'static, PA2>,
    pub(super) current_timer: Peri<'static, TIM4>,
    pub(super) current: Peri<'static, PB8>,
}

/// A real actuator's wires.
pub struct Actuator {
    pub(super) bridge_timer: Peri<'static, TIM1>,
    pub(super) positive_upper: Peri<'static, PA8>,
    pub(super) positive_lower: Peri<'static, PB13>,
    pub(super) negative_upper: Peri<'static, PA9>,
    pub(super) negative_lower: Peri<'static, PB14>,
    pub(super) bridge_break: Peri<'static, PB12>,
    pub(super) converter: Peri<'static, ADC1>,
    pub(super) current: Peri<'static, PC0>,
    pub(super) supply: Peri<'static, PC1>,
    pub(super) temperatures: (Peri<'static, PC2>, Peri<'static, PC3>),
    pub(super) encoder_timer: Peri<'static, TIM3>,
    pub(super) encoder: (Peri<'static, PC6>, Peri<'static, PC7>),
    pub(super) switches: (Peri<'static, PC10>, Peri<'static, PC11>),
    pub(super) emergency_stop: Peri<'static, PB15>,
}

/// All of them.
pub struct Pins {
    pub(super) tracks: Tracks,
    pub(super) safety: Safety,
    pub(super) plant_timer: Peri<'static, TIM7>,
    pub(super) terminal: Terminal,
    pub(super) body: Body,
    pub(super) actuator: Actuator,
}

impl Pins {
    /// Gives each its use.
    pub fn new(chip: Peripherals) -> Self {
        Self {
            tracks: Tracks {
                converter: chip.DAC1,
                first: chip.PA4,
                second: chip.PA5,
            },
            safety: Safety {
                bridge_enable: chip.PC8,
                brake_release: chip.PC9,
                watchdog: chip.IWDG,
            },
            plant_timer: chip.TIM7,
            terminal: Terminal {
                uart: chip.USART1,
                transmit: chip.PB6,
                receive: chip.PB7,
                transmit_dma: chip.DMA2_CH7,
                receive_dma: chip.DMA2_CH2,
                led: chip.PC12,
                flash: chip.FLASH,
            },
            body: Body {
                duty_timer: chip.TIM2,
                duty: chip.PA0,
                direction: chip.PA1,
                disable: chip.PA2,
                current_timer: chip.TIM4,
                current: chip.PB8,
            },
            actuator: Actuator {
                bridge_timer: chip.TIM1,
                positive_upper: chip.PA8,
                positive_lower: chip.PB13,
                negative_upper: chip.PA9,
                negative_lower: chip.PB14,
                bridge_break: chip.PB12,
                converter: chip.ADC1,
                current: chip.PC0,
                supply: chip.PC1,
                temperatures: (chip.PC2, chip.PC3),
                encoder_timer: chip.TIM3,
                encoder: (chip.PC6, chip.PC7),
                switches: (chip.PC10, chip.PC11),
                emergency_stop: chip.PB15,
            },
        }
    }
}
