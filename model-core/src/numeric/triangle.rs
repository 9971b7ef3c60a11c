//! Symmetric matrices, of which the lower triangle is kept, row by row.

/// Entries of the lower triangle of a matrix of this order.
pub const fn entries(order: usize) -> usize {
    order * (order + 1) / 2
}

/// A symmetric matrix of a fixed order; `ENTRIES` is [`entries`] of it.
///
/// ```
/// use model_core::numeric::triangle::{Triangle, entries};
/// let mut matrix = Triangle::<f32, { entries(3) }>::default();
/// matrix.row_mut(2)[1] = 7.0;
/// assert_eq!((matrix.at(1, 2), matrix.row(2).len()), (7.0, 3));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Triangle<T, const ENTRIES: usize>([T; ENTRIES]);

impl<T: Copy + Default, const ENTRIES: usize> Default for Triangle<T, ENTRIES> {
    fn default() -> Self {
        Self([T::default(); ENTRIES])
    }
}

impl<T: Copy + Default, const ENTRIES: usize> Triangle<T, ENTRIES> {
    /// With these entries in its leading `order` rows and columns, and nothing in the others. `entry`
    /// is asked for those up to the diagonal.
    ///
    /// ```
    /// use model_core::numeric::triangle::{Triangle, entries};
    /// let matrix = Triangle::<f32, { entries(3) }>::leading(2, |row, column| (10 * row + column) as f32);
    /// assert_eq!((matrix.at(1, 0), matrix.at(1, 1), matrix.at(2, 2)), (10.0, 11.0, 0.0));
    /// ```
    #[inline]
    pub fn leading(order: usize, entry: impl Fn(usize, usize) -> T) -> Self {
        let mut matrix = Self::default();
        for row in 0..order {
            for (column, value) in matrix.row_mut(row).iter_mut().enumerate() {
                *value = entry(row, column);
            }
        }
        matrix
    }
}

impl<T: Copy, const ENTRIES: usize> Triangle<T, ENTRIES> {
    /// An entry, from either side of the diagonal.
    #[inline]
    pub fn at(&self, row: usize, column: usize) -> T {
        let (row, column) = (row.max(column), row.min(column));
        self.0[entries(row) + column]
    }

    /// A row up to the diagonal.
    #[inline]
    pub fn row(&self, row: usize) -> &[T] {
        &self.0[entries(row)..entries(row + 1)]
    }

    /// A row up to the diagonal.
    #[inline]
    pub fn row_mut(&mut self, row: usize) -> &mut [T] {
        &mut self.0[entries(row)..entries(row + 1)]
    }

    /// The rows from the first on, each up to the diagonal.
    #[inline]
    pub fn rows_mut(&mut self) -> impl Iterator<Item = &mut [T]> {
        let mut rest = &mut self.0[..];
        (1..).map_while(move |length| {
            let (row, behind) = core::mem::take(&mut rest).split_at_mut_checked(length)?;
            rest = behind;
            Some(row)
        })
    }
}
