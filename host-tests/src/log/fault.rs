//! What is wrong with the form of a log, and what would mend it.

/// One fault of the rows of a log.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fault {
    /// The line to blame, counted from 1.
    pub line: usize,
    /// What is wrong and what was expected, in one line, without the call that would mend it.
    pub message: String,
    /// What mends it; `None` where nothing but another measurement does.
    pub mend: Option<Mend>,
}

/// What an import has to do to make a log of rows that are none as they stand.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Mend {
    /// To read them: other names, another delimiter, decimal commas, more values than are allowed.
    Read,
    /// To leave out the rows without a number where one has to be.
    SkipBad,
    /// To put the rows into the order of their time.
    Sort,
    /// To keep these lines, the first and the last one.
    Lines(usize, usize),
    /// To make a log of each of these parts, by their first and last lines.
    Parts(Vec<(usize, usize)>),
    /// To believe the order of the rows instead of their stamps, at this rate, Hz.
    Even(f64),
    /// To bring them to this rate, Hz.
    Rate(f64),
    /// To read the time in this unit.
    TimeUnit(&'static str),
    /// To reverse the sign of this column of the log.
    Reverse(&'static str),
}

impl Fault {
    /// A fault that nothing mends.
    pub(crate) fn new(line: usize, message: impl Into<String>) -> Self {
        Self {
            line,
            message: message.into(),
            mend: None,
        }
    }

    /// A fault with what mends it.
    pub(crate) fn mended_by(line: usize, message: impl Into<String>, mend: Mend) -> Self {
        Self {
            mend: Some(mend),
            ..Self::new(line, message)
        }
    }
}
