//! Search for the parameters that fit a cost.
