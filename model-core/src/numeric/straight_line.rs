//! A straight line by least squares, one point at a time.

/// Running sums of a straight line's least squares.
///
/// The sums are plain: for some hundred points whose abscissas are of one size with their spread.
///
/// ```
/// use model_core::numeric::straight_line::StraightLine;
///
/// let mut line = StraightLine::default();
/// for (abscissa, ordinate) in [(0.0, 1.0), (1.0, 3.0), (2.0, 5.0)] {
///     line.add(abscissa, ordinate);
/// }
/// assert_eq!((line.slope(), line.means()), (2.0, (1.0, 3.0)));
/// ```
#[derive(Debug, Clone, Copy, Default)]
pub struct StraightLine {
    count: f32,
    abscissa: f32,
    ordinate: f32,
    square: f32,
    product: f32,
}

impl StraightLine {
    /// Takes one point.
    #[inline]
    pub fn add(&mut self, abscissa: f32, ordinate: f32) {
        self.count += 1.0;
        self.abscissa += abscissa;
        self.ordinate += ordinate;
        self.square += abscissa * abscissa;
        self.product += abscissa * ordinate;
    }

    /// Ordinate per abscissa; 0 if all abscissas are equal, except for rounding.
    #[inline]
    pub fn slope(&self) -> f32 {
        let spread = self.count * self.square - self.abscissa * self.abscissa;
        if spread > f32::EPSILON * self.count * self.square {
            (self.count * self.product - self.abscissa * self.ordinate) / spread
        } else {
            0.0
        }
    }

    /// Means of abscissa and ordinate; 0 without points.
    #[inline]
    pub fn means(&self) -> (f32, f32) {
        let count = self.count.max(1.0);
        (self.abscissa / count, self.ordinate / count)
    }
}
