//! Ends of the program, what they leave for the next start, and the state that they leave the outputs in.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::panic::PanicInfo;
use core::sync::atomic::{AtomicBool, Ordering::Relaxed};

use cortex_m::peripheral::SCB;
use cortex_m_rt::exception;
use embassy_stm32::pac;

use crate::app::fault::Fault;
use crate::app::fault::last_words::LastWords;
use crate::app::fault::overload;
use crate::app::fault::reset::ResetFlags;

/// RAM that no start clears.
struct Kept(UnsafeCell<MaybeUninit<LastWords>>);

// SAFETY: it is touched at the start, before anything else runs, and at an end, when nothing else runs
// any more.
unsafe impl Sync for Kept {}

#[unsafe(link_section = ".uninit.LAST_WORDS")]
static LAST_WORDS: Kept = Kept(UnsafeCell::new(MaybeUninit::uninit()));

#[unsafe(link_section = ".uninit.WINDING_HEAT")]
static WINDING_HEAT: MaybeUninit<overload::Kept> = MaybeUninit::uninit();

/// Where the winding's heat outlives a reset.
pub fn winding_heat() -> &'static overload::Kept {
    // SAFETY: any bits are a value of it, and it is touched by atomic accesses alone.
    unsafe { WINDING_HEAT.assume_init_ref() }
}

/// The last words.
///
/// # Safety
/// Nobody else has them.
unsafe fn last_words() -> &'static mut LastWords {
    // SAFETY: any bits are a value of it, and nobody else has it, as the caller says.
    unsafe { (*LAST_WORDS.0.get()).assume_init_mut() }
}

/// Why the processor started: the fault that it stands for, and what was left to say. Both are
/// forgotten.
///
/// To be called once, before anything else runs.
pub fn cause() -> Option<Fault> {
    let status = pac::RCC.csr().read();
    let flags = ResetFlags {
        power_on: status.porrstf(),
        brown_out: status.borrstf(),
        watchdog: status.wdgrstf() || status.wwdgrstf(),
        software: status.sftrstf(),
    };
    pac::RCC.csr().modify(|register| register.set_rmvf(true));
    // SAFETY: nothing else runs yet.
    let words = unsafe { last_words() };
    let left = words.read();
    let fault = flags.fault(left.map(|(fault, _)| fault));
    if let Some(fault) = fault {
        let text = left.map_or("", |(_, text)| text);
        defmt::error!("before this start: {} {=str}", fault, text);
    }
    words.clear();
    fault
}

/// Bridge off, brake on, both tracks and the current's output at 0 V. Touches registers alone, so it
/// does what it can in any state.
pub fn make_safe() {
    pac::GPIOC.bsrr().write(|register| {
        register.set_br(8, true);
        register.set_br(9, true);
    });
    pac::TIM1.bdtr().modify(|register| register.set_moe(false));
    pac::DAC1.dhr12rd().write(|_| ());
    pac::TIM4.ccr(2).write(|_| ());
}

/// Ends in the safe state, and tells the log whether everything was in order.
pub fn exit(sound: bool) -> ! {
    defmt::info!("exit sound={=bool}", sound);
    cortex_m::interrupt::disable();
    make_safe();
    loop {
        cortex_m::asm::nop();
    }
}

/// A fault of the processor. A stack that has overflowed leaves nowhere to push to, so this begins
/// on an empty one.
// SAFETY: the name is the vector's; the stack is not used again, since this never returns.
#[unsafe(export_name = "HardFault")]
#[unsafe(naked)]
unsafe extern "C" fn hard_fault() -> ! {
    core::arch::naked_asm!(
        "mrs r0, msp",
        "movw r1, #:lower16:_stack_start",
        "movt r1, #:upper16:_stack_start",
        "msr msp, r1",
        "b {end}",
        end = sym end_in_hard_fault,
    )
}

/// The beginning of the RAM, below which there is nothing: the stack lies there.
pub const STACK_END: u32 = 0x2000_0000;

/// Most bytes that one instruction pushes: 32 words, of the floating-point registers.
const LARGEST_PUSH: u32 = 128;

/// `BFARVALID` in `CFSR`: `BFAR` has the address of a precise bus fault (PM0214, section 4.4.10).
const ADDRESS_IS_VALID: u32 = 1 << 15;

extern "C" fn end_in_hard_fault(stack: u32) -> ! {
    cortex_m::interrupt::disable();
    make_safe();
    // SAFETY: nothing else runs any more.
    let words = unsafe { last_words() };
    // A panic has left its own.
    if words.read().is_none() {
        // SAFETY: registers that say what the fault was; reading has no effect.
        let (status, address) = unsafe { ((*SCB::PTR).cfsr.read(), (*SCB::PTR).bfar.read()) };
        // What of the last words that were pushed is below the RAM: behind such a store the stack pointer is where it was
        // before, and the exception's own words may just have had room.
        let pushed = STACK_END - LARGEST_PUSH..STACK_END;
        let is_beyond = status & ADDRESS_IS_VALID != 0 && pushed.contains(&address);
        let fault = if stack < STACK_END || is_beyond {
            Fault::StackOverflow
        } else {
            Fault::ProcessorFault
        };
        words.write(
            fault,
            format_args!("stack {stack:#010x}, status {status:#010x}, address {address:#010x}"),
        );
    }
    SCB::sys_reset()
}

/// The crystal has stopped. The processor runs from its internal oscillator, at a tenth of its clock, and the timer
/// has let go of the bridge: RM0090, section 7.2.7.
#[exception]
unsafe fn NonMaskableInt() -> ! {
    cortex_m::interrupt::disable();
    make_safe();
    // SAFETY: nothing else runs any more.
    unsafe { last_words() }.write(Fault::ClockFailed, format_args!("the crystal stopped"));
    SCB::sys_reset()
}

/// An interrupt that nobody serves.
#[exception]
unsafe fn DefaultHandler(number: i16) -> ! {
    panic!("interrupt {number} has no handler")
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    static PANICKED: AtomicBool = AtomicBool::new(false);
    cortex_m::interrupt::disable();
    make_safe();
    // What is left, and the logger, panic if they are what panicked.
    if !PANICKED.load(Relaxed) {
        PANICKED.store(true, Relaxed);
        // SAFETY: nothing else runs any more.
        unsafe { last_words() }.write(Fault::Panic, format_args!("{info}"));
        defmt::error!("{}", defmt::Display2Format(info));
    }
    // A probe stops here with a backtrace; then, or without one, `HardFault` starts the processor anew.
    cortex_m::asm::udf()
}
