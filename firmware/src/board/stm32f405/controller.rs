//! The image that drives a real brushed-DC actuator.
//!
//! TIM1 counts up and down at 20 kHz and switches both half bridges. At the top of its count, in the
//! middle of a period, it has ADC1 convert the motor's current and the supply; the end of that is the
//! plant interrupt. Compare values that are written there act from the next bottom of the count on.
//!
//! The break input, low, takes the outputs from the bridge without any software, and it is the drive
//! alone that gives them back, when it is armed anew. A short pulse does as much as a level: that the
//! timer let go is latched.

use embassy_stm32::Peri;
use embassy_stm32::gpio::{AfType, Flex, Input, OutputType, Pull};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::pac;
use embassy_stm32::pac::adc::regs::Sr;
use embassy_stm32::pac::timer::vals::{Bkp, Ossi, Ossr};
use embassy_stm32::peripherals::{ADC1, PB12, PC6, PC7, TIM1, TIM3};
use embassy_stm32::timer::complementary_pwm::ComplementaryPwmPin;
use embassy_stm32::timer::low_level::{
    CountingMode, FilterValue, MasterMode, OutputCompareMode, Timer,
};
use embassy_stm32::timer::qei::{self, Qei};
use embassy_stm32::timer::simple_pwm::PwmPin;
use embassy_stm32::timer::{Ch1, Ch2, Channel};
use static_cell::StaticCell;

use super::safety::Safety;
use super::terminal::{self, Beginning};
use super::tracks::Tracks;
use super::vector::{self, Edge};
use super::{Chip, PERIOD_CYCLES, end, pins, watchdog};
use crate::app::fault::output::Bridge;
use crate::app::fault::overload;
use crate::app::machine::FULL_DUTY;
use crate::app::operation::actuator::{Actuator, Inputs, Readings};
use crate::app::operation::bridge;
use crate::app::operation::drive::Drive;
use crate::app::operation::kit::{ACTUATOR, Kit};
use crate::app::operation::operator::Operator;
use crate::app::wiring::Wiring;

static WIRING: Wiring = Wiring::new();
static INPUTS: Inputs = Inputs::new();

const KIT: &Kit = &ACTUATOR;

/// Cycles of 168 MHz between a switch that opens and the other one of its half bridge that closes:
/// 0.5 µs.
const DEAD_TIME: u8 = 84;

/// Counts before the top at which the converter's trigger rises, and behind it at which it falls: two clocks of the
/// converter at 21 MHz either way, 0.2 µs in all, so that it cannot pass between two of them.
const TRIGGER_LEAD: u16 = 16;

/// The encoder's lines are taken as they are once eight samples are alike, one each four clocks of 84 MHz: 0.38 µs. A
/// bridge's switching couples in for less, its dead time is 0.5 µs. The encoder of the 24 V actuator at 30 V without
/// load, 500 rad/s, has 1.3 million counts a second: a line stays for two of them, 1.5 µs, and for three
/// quarters of that where its maker lets it be off by 45°.
const ENCODER_FILTER: FilterValue = FilterValue::FDTS_DIV4_N8;

/// The encoder's timer, with its inputs filtered.
fn encoder(
    timer: Peri<'static, TIM3>,
    (a, b): (Peri<'static, PC6>, Peri<'static, PC7>),
) -> Qei<'static, TIM3> {
    let pulled_up = qei::Config {
        ch1_pull: Pull::Up,
        ch2_pull: Pull::Up,
        ..qei::Config::default()
    };
    let encoder = Qei::new(timer, a, b, pulled_up);
    pac::TIM3.ccmr_input(0).modify(|register| {
        register.set_icf(0, ENCODER_FILTER);
        register.set_icf(1, ENCODER_FILTER);
    });
    encoder
}

/// The bridge's timer with its pins.
struct HalfBridges {
    timer: Timer<'static, TIM1>,
    _positive: (
        PwmPin<'static, TIM1, Ch1>,
        ComplementaryPwmPin<'static, TIM1, Ch1>,
    ),
    _negative: (
        PwmPin<'static, TIM1, Ch2>,
        ComplementaryPwmPin<'static, TIM1, Ch2>,
    ),
    _bridge_break: Flex<'static>,
    /// Whether the outputs are the timer's, as far as software has it.
    enabled: bool,
}

/// The pin's function.
const TIM1_FUNCTION: u8 = 1;

fn break_pin(pin: Peri<'static, PB12>) -> Flex<'static> {
    let mut pin = Flex::new(pin);
    pin.set_as_af_unchecked(TIM1_FUNCTION, AfType::input(Pull::Up));
    pin
}

impl HalfBridges {
    /// Running, with all four outputs low.
    fn new(
        timer: Peri<'static, TIM1>,
        positive: (
            PwmPin<'static, TIM1, Ch1>,
            ComplementaryPwmPin<'static, TIM1, Ch1>,
        ),
        negative: (
            PwmPin<'static, TIM1, Ch2>,
            ComplementaryPwmPin<'static, TIM1, Ch2>,
        ),
        bridge_break: Peri<'static, PB12>,
    ) -> Self {
        let timer = Timer::new(timer);
        timer.set_counting_mode(CountingMode::CenterAlignedBothInterrupts);
        timer.set_max_compare_value(FULL_DUTY.unsigned_abs());
        timer.set_autoreload_preload(true);
        let [middle, _] = bridge::compares(0);
        for channel in [Channel::Ch1, Channel::Ch2] {
            timer.set_output_compare_mode(channel, OutputCompareMode::PwmMode1);
            timer.set_output_compare_preload(channel, true);
            timer.set_compare_value(channel, middle);
            timer.set_ois(channel, false);
            timer.set_oisn(channel, false);
            timer.enable_channel(channel, true);
            timer.enable_complementary_channel(channel, true);
        }
        // Channel 4 has no pin: its reference rises at the top of the count, which starts the ADC.
        timer.set_output_compare_mode(Channel::Ch4, OutputCompareMode::PwmMode2);
        timer.set_compare_value(Channel::Ch4, FULL_DUTY.unsigned_abs() - TRIGGER_LEAD);
        timer.set_master_mode(MasterMode::COMPARE_OC4);
        timer.set_dead_time_value(DEAD_TIME);
        // Without the master enable the outputs are driven low, not let go.
        timer.set_ossi(Ossi::IDLE_LEVEL);
        timer.set_ossr(Ossr::IDLE_LEVEL);
        timer.set_break_polarity(Bkp::ACTIVE_LOW);
        timer.set_break_filter(FilterValue::NO_FILTER);
        timer.set_automatic_output_enable(false);
        timer.set_break_enable(true);
        timer.set_moe(false);
        // A probe that halts the processor stops the timer and takes the bridge from it.
        pac::DBGMCU
            .apb2fzr()
            .modify(|register| register.set_tim1(true));
        timer.generate_update_event();
        timer.start();
        Self {
            timer,
            _positive: positive,
            _negative: negative,
            _bridge_break: break_pin(bridge_break),
            enabled: false,
        }
    }

    /// Whether the driver has the bridge: it holds the input, or it did while the outputs were the
    /// timer's.
    fn is_broken(&self) -> bool {
        let held = pac::GPIOB.idr().read().idr(12) == pac::gpio::vals::Idr::LOW;
        held || (self.enabled && !self.timer.get_moe())
    }

    /// Switches with this duty, in counts; none lets go.
    fn set(&mut self, duty: Option<i16>) {
        let [positive, negative] = bridge::compares(duty.unwrap_or(0));
        self.timer.set_compare_value(Channel::Ch1, positive);
        self.timer.set_compare_value(Channel::Ch2, negative);
        let enabled = duty.is_some();
        if enabled != self.enabled {
            // While the driver holds the break input this does not enable anything.
            self.timer.set_moe(enabled);
            self.enabled = enabled;
        }
    }
}

/// ADC1: two conversions each time that TIM1 starts them.
fn start_converter(pins: (Peri<'static, ADC1>, [Flex<'static>; 4])) {
    let (_, mut inputs) = pins;
    for input in &mut inputs {
        input.set_as_analog();
    }
    // They are the converter's for good.
    core::mem::forget(inputs);
    embassy_stm32::rcc::enable_and_reset::<ADC1>();
    // 84 MHz / 4 = 21 MHz, of 36 at most.
    pac::ADC123_COMMON
        .ccr()
        .modify(|register| register.set_adcpre(pac::adccommon::vals::Adcpre::DIV4));
    let converter = pac::ADC1;
    // 28 cycles of sampling, 1.3 µs; with 12 of conversion and two channels 3.8 µs in all.
    for channel in [CURRENT_CHANNEL, SUPPLY_CHANNEL] {
        converter.smpr1().modify(|register| {
            register.set_smp(
                usize::from(channel) - 10,
                pac::adc::vals::SampleTime::CYCLES28,
            );
        });
    }
    // Of what changes slowly one is converted between two of those: 480 and 12 cycles are 23 µs.
    for channel in TEMPERATURE_CHANNELS {
        converter.smpr1().modify(|register| {
            register.set_smp(
                usize::from(channel) - 10,
                pac::adc::vals::SampleTime::CYCLES480,
            );
        });
    }
    converter.jsqr().write(|register| {
        // Of two, the third and the fourth place count.
        register.set_jl(1);
        register.set_jsq(2, CURRENT_CHANNEL);
        register.set_jsq(3, SUPPLY_CHANNEL);
    });
    converter.cr1().modify(|register| {
        register.set_scan(true);
        register.set_jeocie(true);
    });
    converter.cr2().modify(|register| {
        register.set_jextsel(TIM1_TRIGGER);
        register.set_jexten(pac::adc::vals::Exten::RISING_EDGE);
        register.set_adon(true);
    });
}

const CURRENT_CHANNEL: u8 = 10;
const SUPPLY_CHANNEL: u8 = 11;

/// Of the switches and of the motor.
const TEMPERATURE_CHANNELS: [u8; 2] = [12, 13];

/// What starts injected conversions: TIM1's trigger output.
const TIM1_TRIGGER: u8 = 1;

/// What the plant interrupt reads and writes.
struct ActuatorEdge {
    bridges: HalfBridges,
    encoder: Qei<'static, TIM3>,
    lower: Input<'static>,
    upper: Input<'static>,
    emergency_stop: Input<'static>,
    safety: Safety,
    tracks: Tracks,
    heat: &'static overload::Kept,
    /// Codes of the temperature sensors, and which of them is converted.
    temperatures: [u16; 2],
    sensor: usize,
}

impl ActuatorEdge {
    /// Takes the temperature that was converted since the tick before, and has the other one converted. What is
    /// triggered goes before it.
    fn convert_temperature(&mut self) {
        let converter = pac::ADC1;
        if converter.sr().read().eoc() {
            self.temperatures[self.sensor] = converter.dr().read().data();
            self.sensor = 1 - self.sensor;
        }
        let channel = TEMPERATURE_CHANNELS[self.sensor];
        converter
            .sqr3()
            .write(|register| register.set_sq(0, channel));
        converter
            .cr2()
            .modify(|register| register.set_swstart(true));
    }
}

impl Edge for ActuatorEdge {
    fn read(&mut self) {
        let converter = pac::ADC1;
        // Flags are cleared by zeros, and a one leaves one that is set meanwhile.
        let mut cleared = Sr(u32::MAX);
        cleared.set_jeoc(false);
        cleared.set_jstrt(false);
        converter.sr().write_value(cleared);
        self.convert_temperature();
        INPUTS.set(&Readings {
            current: converter.jdr(0).read().jdata(),
            supply: converter.jdr(1).read().jdata(),
            encoder: self.encoder.count(),
            switches: [self.lower.is_high(), self.upper.is_high()],
            broken: self.bridges.is_broken(),
            stopped: self.emergency_stop.is_high(),
            temperatures: self.temperatures,
        });
    }

    fn write(&mut self) {
        let outputs = WIRING.latch().outputs();
        let driven = outputs.bridge == Bridge::Driven;
        self.bridges.set(driven.then(|| {
            let volts = KIT.machine.converters.bridge.value(WIRING.duty());
            bridge::duty(volts, WIRING.supply())
        }));
        self.safety.set(&outputs);
        self.tracks.set(WIRING.tracks());
        self.heat.set(WIRING.heat());
    }
}

/// Runs the image.
///
/// # Panics
/// If it is called twice.
pub fn run() -> ! {
    let (mut chip, pins) = defmt::unwrap!(Chip::take());
    let safety = Safety::new(pins.safety.bridge_enable, pins.safety.brake_release);
    let (edge, converter) = edge(pins.actuator, safety, Tracks::new(pins.tracks));
    let Beginning {
        terminal,
        joints,
        values,
        loaded,
    } = terminal::begin(KIT, &WIRING, pins.terminal);
    WIRING.set_heat(end::winding_heat().get().word());
    let (operator, drive, receiver) = defmt::unwrap!(Operator::new(joints, &values).ok());
    let actuator = Actuator::new(receiver, (&INPUTS, &WIRING), &KIT.actuator(&values));
    start(&mut chip, drive, actuator, edge);
    start_converter(converter);
    watchdog::start(pins.safety.watchdog);
    terminal::run(chip.start_tasks(), terminal, (operator, loaded), &WIRING)
}

fn edge(
    pins: pins::Actuator,
    safety: Safety,
    tracks: Tracks,
) -> (ActuatorEdge, (Peri<'static, ADC1>, [Flex<'static>; 4])) {
    let positive = (
        PwmPin::new(pins.positive_upper, OutputType::PushPull),
        ComplementaryPwmPin::new(pins.positive_lower, OutputType::PushPull),
    );
    let negative = (
        PwmPin::new(pins.negative_upper, OutputType::PushPull),
        ComplementaryPwmPin::new(pins.negative_lower, OutputType::PushPull),
    );
    let (lower, upper) = pins.switches;
    let edge = ActuatorEdge {
        bridges: HalfBridges::new(pins.bridge_timer, positive, negative, pins.bridge_break),
        encoder: encoder(pins.encoder_timer, pins.encoder),
        lower: Input::new(lower, Pull::Up),
        upper: Input::new(upper, Pull::Up),
        emergency_stop: Input::new(pins.emergency_stop, Pull::Up),
        safety,
        tracks,
        heat: end::winding_heat(),
        temperatures: [0; 2],
        sensor: 0,
    };
    let (switches, motor) = pins.temperatures;
    let inputs = [
        Flex::new(pins.current),
        Flex::new(pins.supply),
        Flex::new(switches),
        Flex::new(motor),
    ];
    (edge, (pins.converter, inputs))
}

fn start(chip: &mut Chip, drive: Drive, actuator: Actuator, edge: ActuatorEdge) {
    static DRIVE: StaticCell<Drive> = StaticCell::new();
    static ACTUATOR_CELL: StaticCell<Actuator> = StaticCell::new();
    static EDGE: StaticCell<ActuatorEdge> = StaticCell::new();
    chip.start_control(Some(DRIVE.init(drive)));
    vector::set(
        ACTUATOR_CELL.init(actuator),
        &WIRING,
        EDGE.init(edge),
        PERIOD_CYCLES,
    );
    interrupt::ADC.set_priority(Priority::P0);
    // SAFETY: the interrupt has its work, which needs no critical section.
    unsafe { interrupt::ADC.enable() }
}
