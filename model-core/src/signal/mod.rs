//! Test signals, each a function of the tick: nothing accumulates, nothing drifts.
