//! A tape played in real time and logged.

use embassy_time::Timer;
use heapless::spsc::{Consumer, Queue};
use static_cell::{ConstStaticCell, StaticCell};

use super::replay::{ModelError, Playback, Replay, Row};
use super::tape::Tape;
use super::timing::{QUEUED_SAMPLES, RECORD_PERIOD_MS};
use super::wiring::Wiring;
use crate::board::Board;

static WIRING: Wiring = Wiring::new();
static ROWS: ConstStaticCell<Queue<Row, QUEUED_SAMPLES>> = ConstStaticCell::new(Queue::new());
static PLAYBACK: StaticCell<Playback> = StaticCell::new();

/// A tape that is being played.
pub struct Player {
    rows: Consumer<'static, Row>,
    expected: u32,
}

/// Gives the board the tape in `flash` to play: the plant in its interrupt, the log by
/// [`Player::run`]. None, and the reason in the log, if there is nothing to play.
///
/// # Panics
/// If it is called twice.
pub fn start(board: &mut impl Board, flash: &'static [u8]) -> Option<Player> {
    let tape = match Tape::read(flash) {
        Ok(tape) => tape,
        Err(error) => {
            defmt::error!("no replay: {}", error);
            return None;
        }
    };
    let replay = match Replay::new(tape) {
        Ok(replay) => replay,
        Err(ModelError::Physical(error)) => {
            defmt::error!(
                "no replay: {=str} must be {=str}",
                error.parameter,
                error.requirement
            );
            return None;
        }
        Err(ModelError::PiecewiseAffine(error)) => {
            defmt::error!("no replay: {=str} {=str}", error.name, error.requirement);
            return None;
        }
    };
    let expected = replay.rows();
    defmt::info!("replay rows={=u32}", expected);
    let (producer, rows) = ROWS.take().split();
    let playback = PLAYBACK.init(Playback::new(replay, producer, &WIRING));
    board.start(playback, None, &WIRING);
    Some(Player { rows, expected })
}

impl Player {
    /// Logs the replay to its end. True if every row was logged, no tick was missed and no fault was
    /// latched.
    pub async fn run(mut self) -> bool {
        let logged = self.log().await;
        if let Some(fault) = WIRING.fault() {
            defmt::error!("fault: {}", fault);
        }
        let (ticks, missed) = (WIRING.ticks(), WIRING.missed());
        defmt::info!("replayed rows={=u32}", logged);
        defmt::info!("deadlines ticks={=u32} missed={=u32}", ticks, missed);
        logged == self.expected && missed == 0 && WIRING.fault().is_none()
    }

    /// Logs rows up to the last one, or to a fault; how many.
    async fn log(&mut self) -> u32 {
        let mut logged = 0;
        loop {
            // Before the queue is emptied: what was queued before a fault is then still logged.
            let ended = WIRING.fault().is_some();
            while let Some(row) = self.rows.dequeue() {
                defmt::info!(
                    "row number={=u32} position={=f32} current_a={=f32}",
                    row.row,
                    row.position,
                    row.current
                );
                logged += 1;
                if row.row + 1 == self.expected {
                    return logged;
                }
            }
            if ended {
                return logged;
            }
            Timer::after_millis(RECORD_PERIOD_MS).await;
        }
    }
}
