//! The fault latch in every order in which two interrupts and a task may run, and with every value that a load may give under
//! the memory model of C11. The latch's source is compiled here once more, with loom's atomic words in the place of the
//! processor's.

#![allow(unexpected_cfgs, reason = "the latch has a feature of the firmware's")]

#[path = "."]
mod app {
    use firmware::app::fault::{Fault, Faults, output};

    #[expect(dead_code, reason = "what an image has more uses of")]
    #[path = "../../firmware/src/app/fault/latch.rs"]
    pub mod latch;

    pub mod arming {
        pub use firmware::app::arming::Switch;
    }

    /// loom's words are made while a model runs, so these are when they are first touched.
    pub mod atomic {
        use std::sync::OnceLock;

        use loom::sync::atomic;
        pub use loom::sync::atomic::Ordering;

        macro_rules! word {
            ($name:ident, $of:ty) => {
                #[derive(Debug, Default)]
                pub struct $name(OnceLock<atomic::$name>, $of);

                impl $name {
                    pub const fn new(value: $of) -> Self {
                        Self(OnceLock::new(), value)
                    }

                    fn word(&self) -> &atomic::$name {
                        self.0.get_or_init(|| atomic::$name::new(self.1))
                    }

                    pub fn load(&self, order: Ordering) -> $of {
                        self.word().load(order)
                    }

                    pub fn store(&self, value: $of, order: Ordering) {
                        self.word().store(value, order);
                    }
                }
            };
        }

        word!(AtomicBool, bool);
        word!(AtomicU32, u32);

        impl AtomicU32 {
            pub fn fetch_or(&self, bits: u32, order: Ordering) -> u32 {
                self.word().fetch_or(bits, order)
            }

            pub fn fetch_update(
                &self,
                set: Ordering,
                fetch: Ordering,
                update: impl FnMut(u32) -> Option<u32>,
            ) -> Result<u32, u32> {
                self.word().fetch_update(set, fetch, update)
            }

            pub fn compare_exchange(
                &self,
                current: u32,
                new: u32,
                success: Ordering,
                failure: Ordering,
            ) -> Result<u32, u32> {
                self.word().compare_exchange(current, new, success, failure)
            }
        }
    }
}

use app::latch::{Latch, NotCleared};
use firmware::app::fault::{Fault, Faults, output};
use loom::sync::Arc;
use loom::thread;

/// The fault of either interrupt, and the tick at which it comes.
const TRIPS: [(Fault, u32); 2] = [(Fault::OverCurrent, 1), (Fault::StopReached, 2)];

/// A latch whose words are all there before anything else runs.
fn new_latch() -> Arc<Latch> {
    let latch = Arc::new(Latch::new());
    latch.trip(Fault::Panic, 0);
    assert_eq!(latch.clear(), Ok(()));
    latch
}

fn interrupts<const COUNT: usize>(
    latch: &Arc<Latch>,
    trips: [(Fault, u32); COUNT],
) -> [thread::JoinHandle<()>; COUNT] {
    trips.map(|(fault, tick)| {
        let latch = latch.clone();
        thread::spawn(move || latch.trip(fault, tick))
    })
}

fn end(interrupts: impl IntoIterator<Item = thread::JoinHandle<()>>) {
    for interrupt in interrupts {
        interrupt.join().expect("an interrupt that ends");
    }
}

fn both() -> Faults {
    Faults::from(TRIPS[0].0) | TRIPS[1].0.into()
}

#[test]
fn no_fault_is_lost_to_a_task_that_clears_the_latch() {
    loom::model(|| {
        let latch = new_latch();
        // One that is there already, and one that comes: with two that come there are too many orders for a test.
        let [(before, tick), comes] = TRIPS;
        latch.trip(before, tick);
        let interrupts = interrupts(&latch, [comes]);
        let clearing = latch.begin_to_clear();
        let seen = latch.causes();
        let cleared = clearing.end();
        end(interrupts);
        let latched = latch.causes();
        match cleared {
            // What came before it looked is forgotten, and nothing else.
            Ok(()) => assert_eq!(seen | latched, both()),
            Err(NotCleared::Renewed) => assert_eq!(latched, both()),
            Err(refused) => panic!("{refused:?}"),
        }
        if !latched.is_empty() {
            let first = latch.first().expect("a first cause");
            assert!(latched.contains(first.fault), "{first:?} of {latched}");
        }
    });
}

#[test]
fn whoever_sees_a_first_cause_sees_one_that_came_and_a_time_of_one() {
    loom::model(|| {
        let latch = new_latch();
        let interrupts = interrupts(&latch, TRIPS);
        if let Some(cause) = latch.first() {
            assert!(both().contains(cause.fault), "{cause:?}");
            assert!([1, 2].contains(&cause.tick), "{cause:?}");
            assert!(latch.is_tripped());
        }
        end(interrupts);
        assert_eq!(latch.causes(), both());
        assert!(latch.first().is_some());
    });
}

#[test]
fn a_drive_that_is_armed_while_a_fault_comes_is_not_driven() {
    loom::model(|| {
        let latch = new_latch();
        let interrupts = interrupts(&latch, TRIPS);
        let armed = latch.arm();
        end(interrupts);
        assert_eq!(latch.is_armed(), armed.is_ok());
        assert_eq!(latch.outputs().bridge, output::Bridge::Off);
        let cleared = latch.clear();
        assert_eq!(cleared == Err(NotCleared::Armed), armed.is_ok());
    });
}
