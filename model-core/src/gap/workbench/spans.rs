//! When an effect acts that comes and goes: its edges in time are moved from sample to sample.

use super::Workbench;
use crate::gap::criterion::MOST_FILLED;
use crate::gap::fit::Fit;
use crate::gap::model::Model;
use crate::gap::replay::{Replays, Schedule};
use crate::gap::screen;
use crate::gap::span::best_span;

/// Samples under which an edge in time is left to a fit.
const FINEST_EDGE: f32 = 4.0;

/// Most turns of looking for edges and fitting to them.
const MOST_TURNS: u32 = 3;

impl<S: Schedule> Workbench<'_, S> {
    /// The fit of a model whose last effect acts for a while, from where that while follows the log best.
    /// `None` inside if no window is followed better, or nearly all are.
    ///
    /// A derivative does not carry an edge beyond the window that it is in: near the window's end an
    /// edge changes nothing that the window sees. So the edges are looked for, and everything is fitted
    /// to them, in turns.
    #[inline(never)]
    pub(super) fn fit_edges(&mut self, model: &Model) -> Option<Option<Fit>> {
        let mut best: Option<Fit> = None;
        for _ in 0..MOST_TURNS {
            let last = best.as_ref().map_or(model, |fit| &fit.model);
            let Some(found) = self.find_span(last)? else {
                break;
            };
            if best.is_some() && self.is_near(&found, last) {
                break;
            }
            let moved = self.move_edges(found)?;
            let fit = self.fit(&moved)?;
            if best.as_ref().is_some_and(|best| fit.cost >= best.cost) {
                break;
            }
            best = Some(fit);
        }
        Some(best)
    }

    /// The model with its last effect acting where the log is followed best by that, to a window. `None`
    /// inside where that is nowhere, or nearly always.
    // Two simulators, which are not to lie below a fit.
    #[inline(never)]
    fn find_span(&mut self, model: &Model) -> Option<Option<Model>> {
        let data = self.data;
        let period = data.logs.first()?.period;
        let mut without = model.clone();
        let effect = without.effects.pop()?;
        let acting = |(begin, end): (f32, f32)| {
            let mut acting = effect;
            let shapes = &mut acting.values[effect.id.strengths()..];
            (shapes[0], shapes[1]) = (end, end - begin);
            screen::with_effect(&without, acting)
        };
        let throughout = acting((0.0, 2.0 * self.options.scope.seconds))?;
        let (without, throughout) = (without.build(period).ok()?, throughout.build(period).ok()?);
        let (span, windows) = best_span(&data, self.schedule, (&without, &throughout));
        self.count(windows, data.settings.window);
        let comes_and_goes = |span: &(f32, f32)| {
            let filled = data.overlapping(&[*span]).count();
            (filled as f32) < MOST_FILLED * data.windows() as f32
        };
        Some(span.filter(comes_and_goes).and_then(acting))
    }

    /// Whether the last effects of two models act at the same time, to a window.
    fn is_near(&self, a: &Model, b: &Model) -> bool {
        let span = |model: &Model| model.effects.last().and_then(|effect| effect.law().span());
        let window = self.data.settings.window as f32 * self.options.scope.period;
        span(a).zip(span(b)).is_some_and(|(a, b)| {
            let apart = (a.0 - b.0).abs().max((a.1 - b.1).abs());
            apart <= window
        })
    }

    /// The model with the edges of its last effect's span moved, within a window, to where the log is
    /// followed best. Elsewhere they change nothing.
    #[inline(never)]
    fn move_edges(&mut self, mut best: Model) -> Option<Model> {
        let slot = best.effects.len() - 1;
        let shapes = best.effects[slot].id.strengths();
        let (begin, end) = best.effects[slot].law().span()?;
        let window = self.data.settings.window as f32 * self.options.scope.period;
        let near = |edge: f32| (edge - window, edge + window);
        let edges = [near(begin), near(end)];
        let mut least = self.cost_within(&best, edges)?;
        let mut step = 0.5 * window;
        while step > FINEST_EDGE * self.options.scope.period {
            for (begin, end) in [(-step, 0.0), (step, 0.0), (0.0, -step), (0.0, step)] {
                let mut tried = best.clone();
                let values = &mut tried.effects[slot].values;
                values[shapes] += end;
                values[shapes + 1] += end - begin;
                if values[shapes] <= 0.0 || values[shapes + 1] <= 0.0 {
                    continue;
                }
                let cost = self.cost_within(&tried, edges)?;
                if cost < least {
                    (best, least) = (tried, cost);
                }
            }
            step *= 0.5;
        }
        Some(best)
    }

    /// Sum of a model's squared weighted residuals in the windows that have something in common with one
    /// of two spans.
    #[inline(never)]
    fn cost_within(&mut self, model: &Model, spans: [(f32, f32); 2]) -> Option<f64> {
        let data = self.data;
        let simulator = model.build(data.logs.first()?.period).ok()?;
        let numbers = || data.overlapping(&spans);
        let window = |place| data.window(numbers().nth(place)?);
        let count = numbers().count();
        let total = Replays::whole(&data, &simulator, &window).cost(self.schedule, count);
        self.count(count as u64, data.settings.window);
        Some(total)
    }
}
