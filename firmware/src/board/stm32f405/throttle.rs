//! The image that is a throttle body for an engine controller: the duty and the direction that it is
//! told come in, and its two tracks and its motor's current go out.

use embassy_stm32::Peri;
use embassy_stm32::gpio::{Input, OutputType, Pull};
use embassy_stm32::pac;
use embassy_stm32::peripherals::{PA0, PB8, TIM2, TIM4, TIM7};
use embassy_stm32::timer::input_capture::CapturePin;
use embassy_stm32::timer::low_level::{
    CountingMode, FilterValue, InputCaptureMode, InputTISelection, OutputCompareMode, SlaveMode,
    Timer, TriggerSource,
};
use embassy_stm32::timer::simple_pwm::PwmPin;
use embassy_stm32::timer::{Ch1, Ch3, Channel};
use model_core::plant::bridge::Bridge;
use model_core::plant::throttle::Throttle;
use static_cell::StaticCell;

use super::terminal::{self, Beginning};
use super::tracks::Tracks;
use super::vector::{self, Edge};
use super::{Chip, PERIOD_CYCLES, pins, safety, ticker, watchdog};
use crate::app::ecu::loopback::Wires;
use crate::app::operation::body::Body;
use crate::app::operation::calibration::CURRENT_FULL_SCALE;
use crate::app::operation::drive::Drive;
use crate::app::operation::duty_input::{DutyInput, Edges};
use crate::app::operation::kit::{Kit, THROTTLE_BODY};
use crate::app::operation::operator::Operator;
use crate::app::wiring::Wiring;

static WIRING: Wiring = Wiring::new();
static WIRES: Wires = Wires::new();

const KIT: &Kit = &THROTTLE_BODY;

/// Clock of the timers behind the slower bus, Hz.
const TIMER_CLOCK: u32 = 84_000_000;

/// The slowest PWM that is measured, Hz: one that comes slower is taken for its level. A tenth below the 400 Hz
/// that a controller may have, whose clock is off and whose edges jitter.
const SLOWEST: u32 = 360;

/// The duty's timer with its pin.
struct Capture {
    timer: Timer<'static, TIM2>,
    _pin: CapturePin<'static, TIM2, Ch1>,
    input: DutyInput,
}

impl Capture {
    /// PWM input mode: the rising edge resets the count and catches it on channel 1, the falling one
    /// catches it on channel 2.
    fn new(timer: Peri<'static, TIM2>, pin: Peri<'static, PA0>) -> Self {
        let pin = CapturePin::new(pin, Pull::Down);
        let timer = Timer::new(timer);
        timer.set_counting_mode(CountingMode::EdgeAlignedUp);
        timer.set_max_compare_value(u32::MAX);
        let channels = [
            (
                Channel::Ch1,
                InputTISelection::Normal,
                InputCaptureMode::Rising,
            ),
            (
                Channel::Ch2,
                InputTISelection::Alternate,
                InputCaptureMode::Falling,
            ),
        ];
        for (channel, selection, mode) in channels {
            timer.set_input_ti_selection(channel, selection);
            timer.set_input_capture_mode(channel, mode);
            // Eight samples alike, 0.1 µs: what is shorter is no edge.
            timer.set_input_capture_filter(channel, FilterValue::FCK_INT_N8);
            timer.enable_channel(channel, true);
        }
        timer.set_trigger_source(TriggerSource::TI1FP1);
        timer.set_slave_mode(SlaveMode::RESET_MODE);
        timer.generate_update_event();
        timer.start();
        Self {
            timer,
            _pin: pin,
            input: DutyInput::new(TIMER_CLOCK, SLOWEST),
        }
    }

    fn duty(&mut self) -> f32 {
        // To read the period takes the flag back.
        let rising = self.timer.get_input_interrupt(Channel::Ch1);
        self.input.duty(&Edges {
            rising,
            period: self.timer.get_capture_value(Channel::Ch1),
            width: self.timer.get_capture_value(Channel::Ch2),
            since: self.timer.regs_gp32().cnt().read(),
            high: pac::GPIOA.idr().read().idr(0) == pac::gpio::vals::Idr::HIGH,
        })
    }
}

/// The current's output.
struct CurrentOutput {
    timer: Timer<'static, TIM4>,
    _pin: PwmPin<'static, TIM4, Ch3>,
}

impl CurrentOutput {
    fn new(timer: Peri<'static, TIM4>, pin: Peri<'static, PB8>) -> Self {
        let pin = PwmPin::new(pin, OutputType::PushPull);
        let timer = Timer::new(timer);
        timer.set_counting_mode(CountingMode::EdgeAlignedUp);
        // A code of full scale is a duty of one.
        timer.set_max_compare_value(CURRENT_FULL_SCALE - 1);
        timer.set_autoreload_preload(true);
        timer.set_output_compare_mode(Channel::Ch3, OutputCompareMode::PwmMode1);
        timer.set_output_compare_preload(Channel::Ch3, true);
        timer.set_compare_value(Channel::Ch3, 0);
        timer.enable_channel(Channel::Ch3, true);
        timer.generate_update_event();
        timer.start();
        Self { timer, _pin: pin }
    }

    fn set(&self, code: u16) {
        self.timer.set_compare_value(Channel::Ch3, code);
    }
}

/// What the plant interrupt reads and writes.
struct BodyEdge {
    capture: Capture,
    direction: Input<'static>,
    disable: Input<'static>,
    tracks: Tracks,
    current: CurrentOutput,
}

impl Edge for BodyEdge {
    fn read(&mut self) {
        ticker::acknowledge();
        let duty = self.capture.duty();
        WIRES.drive(if self.disable.is_high() {
            Bridge::Freewheel
        } else if self.direction.is_high() {
            Bridge::Drive { duty }
        } else {
            Bridge::Drive { duty: -duty }
        });
    }

    fn write(&mut self) {
        self.tracks.set(WIRING.tracks());
        self.current.set(WIRING.current_output());
    }
}

/// Runs the image.
///
/// # Panics
/// If it is called twice.
pub fn run() -> ! {
    let (mut chip, pins) = defmt::unwrap!(Chip::take());
    // Neither bridge nor brake is there, but what is should be held.
    let _safety = safety::Safety::new(pins.safety.bridge_enable, pins.safety.brake_release);
    let edge = edge(pins.body, Tracks::new(pins.tracks));
    let Beginning {
        terminal,
        mut joints,
        values,
        loaded,
    } = terminal::begin(KIT, &WIRING, pins.terminal);
    let bodies = [(); 2].map(|()| defmt::unwrap!(KIT.throttle(&values).ok(), "throttle"));
    let [throttle, spare] = place(bodies);
    joints.spare = Some(spare);
    let (operator, drive, receiver) = defmt::unwrap!(Operator::new(joints, &values).ok());
    let calibration = KIT.calibration(&values);
    let converters = KIT.machine_with(&values).converters;
    let body = Body::new(
        throttle,
        receiver,
        (converters, calibration),
        (&WIRES, &WIRING),
    );
    start(&mut chip, drive, body, edge, pins.plant_timer);
    watchdog::start(pins.safety.watchdog);
    terminal::run(chip.start_tasks(), terminal, (operator, loaded), &WIRING)
}

/// In a frame of its own, which is gone when the tasks run.
#[inline(never)]
fn place(bodies: [Throttle; 2]) -> [&'static mut Throttle; 2] {
    static BODIES: [StaticCell<Throttle>; 2] = [StaticCell::new(), StaticCell::new()];
    let [first, second] = bodies;
    [BODIES[0].init(first), BODIES[1].init(second)]
}

fn edge(pins: pins::Body, tracks: Tracks) -> BodyEdge {
    BodyEdge {
        capture: Capture::new(pins.duty_timer, pins.duty),
        direction: Input::new(pins.direction, Pull::Down),
        disable: Input::new(pins.disable, Pull::Up),
        tracks,
        current: CurrentOutput::new(pins.current_timer, pins.current),
    }
}

fn start(chip: &mut Chip, drive: Drive, body: Body, edge: BodyEdge, timer: Peri<'static, TIM7>) {
    static DRIVE: StaticCell<Drive> = StaticCell::new();
    static BODY: StaticCell<Body> = StaticCell::new();
    static EDGE: StaticCell<BodyEdge> = StaticCell::new();
    chip.start_control(Some(DRIVE.init(drive)));
    vector::set(BODY.init(body), &WIRING, EDGE.init(edge), PERIOD_CYCLES);
    ticker::start(timer);
}
