//! The operator's tasks: bytes from the terminal and to it, the operator between them, and the long
//! work below.
//!
//! A debug probe has a console beside it, which is told what the terminal is told, at its pace.
//!
//! The operator never waits for the terminal: bytes go through pipes. Disarmed, no further one is taken from
//! the terminal until there is room for the longest answer; armed, `stop` must not wait behind answers.

use core::fmt::{self, Write};

use embassy_executor::{Executor, SendSpawner};
use embassy_stm32::gpio::{Level, Output, Pull, Speed};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{DMA2_CH2, DMA2_CH7, FLASH, USART1};
use embassy_stm32::usart::{self, RingBufferedUartRx, Uart, UartTx};
use embassy_stm32::{Peri, bind_interrupts, dma};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::pipe::Pipe;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, Ticker, TimeoutError, with_timeout};
use static_cell::{ConstStaticCell, StaticCell};

use super::parameters::Region;
use super::{core_coupled, end, parameters, pins, probe, supply, watchdog};
use crate::app::capture::{self, Capture, QUANTITIES};
use crate::app::console::LONGEST_ANSWER;
use crate::app::fault::Faults;
use crate::app::liveness::{IDLE_PERIOD_MS, Task};
use crate::app::operation::evaluation::{Done, Job};
use crate::app::operation::kit::Kit;
use crate::app::operation::operator::{
    self, Cells, Joints, Keyboard, Operator, POLL_PERIOD_MS, Station,
};
use crate::app::record::log_values;
use crate::app::store::Loaded;
use crate::app::store::field::Values;
use crate::app::timing::PLANT_PERIOD_US;
use crate::app::wiring::Wiring;
use crate::board::{interrupts, now};

bind_interrupts!(struct Interrupts {
    USART1 => usart::InterruptHandler<USART1>;
    DMA2_STREAM2 => dma::InterruptHandler<DMA2_CH2>;
    DMA2_STREAM7 => dma::InterruptHandler<DMA2_CH7>;
});

/// The board as the operator sees it.
pub struct BoardStation;

impl Station for BoardStation {
    const UNIT: &'static str = "cycles";

    fn worst(&self) -> [u32; 2] {
        let loads = interrupts::loads();
        [loads.plant.worst(), loads.control.worst()]
    }

    fn stall(&mut self, stalled: bool) {
        watchdog::stall(stalled);
    }

    fn clock(&self) -> u32 {
        // A tick of its clock is one of the plant's.
        const { assert!(embassy_time::TICK_HZ == 1_000_000 / PLANT_PERIOD_US as u64) };
        embassy_time::Instant::now().as_ticks() as u32
    }

    fn send_head(&mut self, capture: &Capture) {
        capture::log_head(capture);
    }

    fn send_log_head(&mut self, rows: usize) {
        capture::log_log_head(rows);
    }

    fn room(&self) -> usize {
        ANSWERED.free_capacity().saturating_sub(LONGEST_ANSWER)
    }

    fn send_row(&mut self, number: u32, values: &[f32; QUANTITIES]) {
        log_values(number, values);
    }
}

/// The operator on this board.
pub type BoardOperator = Operator<Region, BoardStation>;

/// Room for the longest answer, `help`, and for one announcement behind it.
const ANSWERS: usize = 4096;

static TYPED: Pipe<CriticalSectionRawMutex, 256> = Pipe::new();
static ANSWERED: Pipe<CriticalSectionRawMutex, ANSWERS> = Pipe::new();
static JOBS: Signal<CriticalSectionRawMutex, Job> = Signal::new();
static DONE: Signal<CriticalSectionRawMutex, Done> = Signal::new();

/// What is written goes to the terminal, as far as there is room.
struct Answers;

impl Write for Answers {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let mut bytes = text.as_bytes();
        while !bytes.is_empty() {
            let written = ANSWERED.try_write(bytes).map_err(|_| fmt::Error)?;
            bytes = bytes.get(written..).unwrap_or_default();
        }
        Ok(())
    }
}

/// The statics of the operator.
fn cells() -> &'static mut Cells {
    static CELLS: ConstStaticCell<Cells> = ConstStaticCell::new(Cells::new());
    CELLS.take()
}

/// The terminal's two directions and the lamp.
pub struct Terminal {
    transmit: UartTx<'static, Async>,
    receive: RingBufferedUartRx<'static>,
    led: Output<'static>,
}

impl Terminal {
    /// At 115,200 baud; and the flash, where the parameters are.
    ///
    /// # Panics
    /// If it is called twice.
    fn new(pins: pins::Terminal) -> (Self, Peri<'static, FLASH>) {
        static RING: ConstStaticCell<[u8; 256]> = ConstStaticCell::new([0; 256]);
        for line in [
            interrupt::USART1,
            interrupt::DMA2_STREAM2,
            interrupt::DMA2_STREAM7,
        ] {
            line.set_priority(Priority::P12);
        }
        let mut config = usart::Config::default();
        // Without a terminal the line is at rest.
        config.rx_pull = Pull::Up;
        let uart = Uart::new(
            pins.uart,
            pins.receive,
            pins.transmit,
            pins.transmit_dma,
            pins.receive_dma,
            Interrupts,
            config,
        );
        let (transmit, receive) = defmt::unwrap!(uart).split();
        let terminal = Self {
            transmit,
            receive: receive.into_ring_buffered(RING.take()),
            led: Output::new(pins.led, Level::Low, Speed::Low),
        };
        (terminal, pins.flash)
    }
}

/// What the operator of an image begins with.
pub struct Beginning {
    /// The terminal that it answers on.
    pub terminal: Terminal,
    /// All but the spare body.
    pub joints: Joints<Region, BoardStation>,
    /// The values to run with.
    pub values: Values,
    /// Where they come from.
    pub loaded: Loaded,
}

/// Latches what ended the run before, and reads the stored parameters.
///
/// # Panics
/// If it is called twice.
pub fn begin(kit: &'static Kit, wiring: &'static Wiring, pins: pins::Terminal) -> Beginning {
    if let Some(fault) = end::cause() {
        wiring.trip(fault);
    }
    supply::watch();
    let (terminal, flash) = Terminal::new(pins);
    let mut store = defmt::unwrap!(parameters::store(flash).ok(), "store");
    let loaded = now(operator::load(kit, &mut store, wiring));
    let (values, loaded) = defmt::unwrap!(loaded.ok(), "parameters");
    let joints = Joints {
        kit,
        wiring,
        station: BoardStation,
        store,
        memory: core_coupled::memory(),
        cells: cells(),
        spare: None,
    };
    Beginning {
        terminal,
        joints,
        values,
        loaded,
    }
}

/// Runs the operator, for good.
pub fn run(
    above: SendSpawner,
    terminal: Terminal,
    (operator, loaded): (BoardOperator, Loaded),
    wiring: &'static Wiring,
) -> ! {
    static EXECUTOR: StaticCell<Executor> = StaticCell::new();
    let Terminal {
        transmit,
        receive,
        led,
    } = terminal;
    EXECUTOR.init(Executor::new()).run(|below| {
        above.spawn(defmt::unwrap!(type_in(receive, wiring)));
        above.spawn(defmt::unwrap!(answer(transmit, wiring)));
        above.spawn(defmt::unwrap!(operate(operator, loaded, led, wiring)));
        below.spawn(defmt::unwrap!(evaluate(wiring)));
    })
}

/// How long a task waits before it says that it goes on.
const IDLE_PERIOD: Duration = Duration::from_millis(IDLE_PERIOD_MS as u64);

/// A byte that is no text: the line that it is in is refused.
const NO_TEXT: u8 = 0;

#[embassy_executor::task]
async fn type_in(mut receive: RingBufferedUartRx<'static>, wiring: &'static Wiring) -> ! {
    let mut bytes = [0; 32];
    loop {
        wiring.goes_on(Task::Reception);
        let typed = match with_timeout(IDLE_PERIOD, receive.read(&mut bytes)).await {
            Ok(Ok(read)) => bytes.get(..read).unwrap_or_default(),
            // What came with an error, or was lost while flash was written.
            Ok(Err(_)) => &[NO_TEXT],
            Err(TimeoutError) => &[],
        };
        pass_on(typed, wiring).await;
    }
}

/// Bytes to the operator, as soon as there is room for them.
async fn pass_on(mut bytes: &[u8], wiring: &Wiring) {
    while !bytes.is_empty() {
        wiring.goes_on(Task::Reception);
        if let Ok(written) = with_timeout(IDLE_PERIOD, TYPED.write(bytes)).await {
            bytes = bytes.get(written..).unwrap_or_default();
        }
    }
}

#[embassy_executor::task]
async fn answer(mut transmit: UartTx<'static, Async>, wiring: &'static Wiring) -> ! {
    let mut bytes = [0; 64];
    loop {
        wiring.goes_on(Task::Answers);
        let Ok(read) = with_timeout(IDLE_PERIOD, ANSWERED.read(&mut bytes)).await else {
            continue;
        };
        let said = bytes.get(..read).unwrap_or_default();
        probe::tell(said);
        // A terminal that does not take it has lost it.
        let _ = transmit.write(said).await;
    }
}

#[embassy_executor::task]
async fn evaluate(wiring: &'static Wiring) -> ! {
    loop {
        wiring.goes_on(Task::Evaluation);
        if let Ok(job) = with_timeout(IDLE_PERIOD, JOBS.wait()).await {
            DONE.signal(job.run());
        }
    }
}

/// Most bytes that are taken in a poll: a probe may write without an end.
const MOST_TYPED: usize = 256;

/// The next byte that was typed, and where.
fn typed() -> Option<(Keyboard, u8)> {
    let mut byte = [0];
    if TYPED.try_read(&mut byte) == Ok(1) {
        return Some((Keyboard::Terminal, byte[0]));
    }
    probe::typed().map(|byte| (Keyboard::Probe, byte))
}

/// Polls between two lines of the log about the interrupts: 10 s.
const REPORT: u32 = 10_000 / POLL_PERIOD_MS;

#[embassy_executor::task]
async fn operate(
    mut operator: BoardOperator,
    loaded: Loaded,
    mut led: Output<'static>,
    wiring: &'static Wiring,
) -> ! {
    let mut answers = Answers;
    operator.greet(&loaded, &mut answers);
    let mut ticker = Ticker::every(Duration::from_millis(POLL_PERIOD_MS.into()));
    let mut logged = Faults::NONE;
    let mut poll = 0_u32;
    loop {
        ticker.next().await;
        poll = poll.wrapping_add(1);
        if let Some(done) = DONE.try_take() {
            operator.finish(done, &mut answers);
        }
        operator.poll(&mut answers);
        for _ in 0..MOST_TYPED {
            // While the drive acts, no order waits for answers to be sent: what there is no room for is lost.
            let may_answer =
                wiring.latch().is_armed() || ANSWERED.free_capacity() >= LONGEST_ANSWER;
            let Some((keyboard, byte)) = may_answer.then(typed).flatten() else {
                break;
            };
            operator.take(keyboard, byte, &mut answers).await;
        }
        if let Some(job) = operator.job() {
            JOBS.signal(job);
        }
        let latched = wiring.latch().causes();
        if latched != logged {
            logged = latched;
            defmt::error!("faults: {}", latched);
        }
        if poll.is_multiple_of(REPORT) {
            super::log_loads();
        }
        led.set_level(lamp(wiring, poll).into());
    }
}

/// Lit while armed; blinking once a second disarmed, five times with a fault.
fn lamp(wiring: &Wiring, poll: u32) -> bool {
    let milliseconds = poll.wrapping_mul(POLL_PERIOD_MS);
    if wiring.latch().is_tripped() {
        milliseconds % 200 < 100
    } else {
        wiring.latch().is_armed() || milliseconds % 1000 < 100
    }
}
