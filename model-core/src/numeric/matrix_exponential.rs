//! Matrix exponential for the discretisation of affine modes.

/// A square matrix of a fixed size, row by row.
pub type Matrix<const N: usize> = [[f64; N]; N];

/// Terms of the Taylor series: with a norm of at most 1/4 the remainder is below 1e-17.
const TERMS: u32 = 12;

/// Norm under which the series is summed; larger matrices are halved first and squared after.
const SERIES_NORM: f64 = 0.25;

/// Product of two matrices, summed in the order of the columns.
///
/// Factors of zero, which a mode's matrices are half full of, are passed over: in software a
/// multiplication costs a hundred instructions whatever the factors are.
pub fn multiply<const N: usize>(a: &Matrix<N>, b: &Matrix<N>) -> Matrix<N> {
    let mut product = [[0.0; N]; N];
    for row in 0..N {
        for inner in (0..N).filter(|&inner| !is_zero(a[row][inner])) {
            for column in (0..N).filter(|&column| !is_zero(b[inner][column])) {
                product[row][column] += a[row][inner] * b[inner][column];
            }
        }
    }
    product
}

/// A comparison in integers.
fn is_zero(value: f64) -> bool {
    value.to_bits() << 1 == 0
}

/// `exp(a)` by scaling, Taylor series and squaring.
///
/// Constructors call it, never a step. It works in `f64` with `+ × ÷` alone, which software
/// floating point rounds as the host does, so both get the same bits. Entries must be finite; the
/// relative error of a stable mode's matrix (norm up to 1e6) is below 1e-9.
///
/// ```
/// use model_core::numeric::matrix_exponential::exponential;
/// let rotation = exponential(&[[0.0, -1.0], [1.0, 0.0]]);
/// assert!((rotation[0][0] - 0.540_302_305_868_139_8).abs() < 1e-14);
/// assert!((rotation[1][0] - 0.841_470_984_807_896_5).abs() < 1e-14);
/// ```
pub fn exponential<const N: usize>(a: &Matrix<N>) -> Matrix<N> {
    let norm = a
        .iter()
        .map(|row| row.iter().map(|entry| entry.abs()).sum::<f64>())
        .fold(0.0, f64::max);
    let mut squarings = 0;
    let mut scale = 1.0;
    while norm * scale > SERIES_NORM && squarings < 64 {
        scale *= 0.5;
        squarings += 1;
    }
    let scaled = a.map(|row| row.map(|entry| entry * scale));

    let mut sum = [[0.0; N]; N];
    for (index, row) in sum.iter_mut().enumerate() {
        row[index] = 1.0;
    }
    let mut term = sum;
    for order in 1..=TERMS {
        term = multiply(&term, &scaled);
        for row in 0..N {
            for column in 0..N {
                if !is_zero(term[row][column]) {
                    term[row][column] /= f64::from(order);
                    sum[row][column] += term[row][column];
                }
            }
        }
    }
    for _ in 0..squarings {
        sum = multiply(&sum, &sum);
    }
    sum
}
