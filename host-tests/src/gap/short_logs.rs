//! Training logs that are too short to prove much.

use model_core::gap::criterion::FEW_WINDOWS;
use model_core::gap::replay::{Data, MARGIN, Settings};
use serde::Serialize;

use crate::quantity::{Scale, decimal};

/// Training logs that are too short for predictions of the usual length. An effect is proven by predictions that it was not fitted
/// to, so a short log is cut into shorter ones, of which there are enough. Over these an effect moves the machine less: what pushes
/// moves it by half of what it accelerates it by, times the square of the time.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct ShortLogs {
    /// Length of all training logs together, s.
    pub duration_s: f64,
    /// Predictions that they are cut into.
    pub windows: usize,
    /// Length of each, s.
    pub window_s: f64,
    /// The usual length of a prediction, s.
    pub usual_s: f64,
    /// Length of one log that gives as many as a proof asks for, of the usual length, s.
    pub least_s: f64,
}

impl ShortLogs {
    /// Of logs before anything is fitted to them; none where they are long enough.
    pub fn of(data: &Data) -> Option<Self> {
        let period = decimal(data.logs.first()?.period);
        let usual = Settings::new(period as f32, 0.0).window;
        let own = data.settings.window;
        (own < usual).then(|| {
            let samples: usize = data.logs.iter().map(|log| log.samples()).sum();
            Self {
                duration_s: samples as f64 * period,
                windows: data.windows(),
                window_s: own as f64 * period,
                usual_s: usual as f64 * period,
                least_s: (FEW_WINDOWS * usual + 2 * MARGIN + 1) as f64 * period,
            }
        })
    }

    /// That they are short, and how long a log has to be.
    pub(super) fn in_words(&self) -> String {
        format!(
            "The logs are short: their {} give {} predictions of {} to prove an effect by, and over so short a time most \
             effects hardly move the machine. A log of {} gives as many of {}.",
            time(self.duration_s),
            self.windows,
            time(self.window_s),
            self.least(),
            time(self.usual_s)
        )
    }

    /// How long to record, rounded up to a tenth of a second.
    pub(super) fn least(&self) -> String {
        time((10.0 * self.least_s).ceil() / 10.0)
    }
}

fn time(seconds: f64) -> String {
    Scale::of("s", [seconds]).quantity(seconds)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::series::Series;

    /// So many logs of so many samples at 1 kHz.
    fn short(logs: usize, samples: usize) -> Option<ShortLogs> {
        let series = Series {
            label: String::new(),
            period: 1e-3,
            input: vec![0.0; samples],
            position: vec![0.0; samples],
            current: None,
            velocity: None,
            brake: None,
            load: None,
            enabled: None,
        };
        let logs = vec![series.log(); logs];
        ShortLogs::of(&Data::new(&logs, 0.0).unwrap())
    }

    #[test]
    fn a_log_as_long_as_a_short_one_is_told_to_be_is_not_short() {
        let told = short(2, 300).unwrap();
        // Of 0.3 s the 16 samples on either side start the model, and one ends the last prediction.
        assert_eq!(told.windows, 2 * (267 / 22));
        assert!((told.window_s - 0.022).abs() < 1e-9 && (told.usual_s - 0.2).abs() < 1e-9);
        let least = (told.least_s * 1e3).round() as usize;
        assert!(short(1, least).is_none() && short(1, least - 1).is_some());
    }
}
