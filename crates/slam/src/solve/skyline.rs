//! Sparse symmetric systems whose entries lie near the diagonal, but for a few rows.

use nalgebra::{DVector, SMatrix, SVector};

/// The lower half of a symmetric matrix: of each row the entries from the first that is not zero to the diagonal. Its Cholesky
/// factor has the same shape.
///
/// Source: George and Liu, "Computer solution of large sparse positive definite systems", 1981, chapter 4 (envelope methods).
#[derive(Debug, Clone)]
pub struct Skyline {
    /// Column of the first entry of each row.
    first: Vec<usize>,
    rows: Vec<Vec<f64>>,
}

impl Skyline {
    /// A matrix of zeros, given the first column of each row.
    #[must_use]
    pub fn new(first: Vec<usize>) -> Self {
        let rows = first.iter().enumerate().map(|(row, first)| vec![0.0; row + 1 - first]).collect();
        Self { first, rows }
    }

    /// A matrix of so many rows, given its entries on and below the diagonal: row, then column.
    #[must_use]
    pub fn of(size: usize, entry: impl Fn(usize, usize) -> f64) -> Self {
        let first = |row: usize| (0..row).find(|column| entry(row, *column) != 0.0).unwrap_or(row);
        let first: Vec<usize> = (0..size).map(first).collect();
        let row = |(row, first): (usize, &usize)| (*first..=row).map(|column| entry(row, column)).collect();
        let rows = first.iter().enumerate().map(row).collect();
        Self { first, rows }
    }

    /// Adds to an entry on or below the diagonal, at or right of the first column of its row.
    #[inline]
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        self.rows[row][column - self.first[row]] += value;
    }

    /// An entry on the diagonal.
    #[inline]
    pub fn diagonal_mut(&mut self, row: usize) -> &mut f64 {
        let last = row - self.first[row];
        &mut self.rows[row][last]
    }

    /// Solves the system. `None` if the matrix is not positive definite.
    #[must_use]
    pub fn solve(self, right: &DVector<f64>) -> Option<DVector<f64>> {
        Some(self.cholesky()?.solve(right))
    }

    /// The Cholesky factor. `None` if the matrix is not positive definite.
    #[must_use]
    pub fn cholesky(mut self) -> Option<SkylineFactor> {
        for row in 0..self.rows.len() {
            let (done, rest) = self.rows.split_at_mut(row);
            let own = &mut rest[0];
            let first = self.first[row];
            for column in first..row {
                let other = &done[column];
                let start = first.max(self.first[column]);
                let before = &own[start - first..column - first];
                let sum = dot(before, &other[start - self.first[column]..column - self.first[column]]);
                let pivot = other[column - self.first[column]];
                own[column - first] = (own[column - first] - sum) / pivot;
            }
            let last = row - first;
            let pivot = own[last] - dot(&own[..last], &own[..last]);
            if pivot.is_nan() || pivot <= 0.0 {
                return None;
            }
            own[last] = pivot.sqrt();
        }
        Some(SkylineFactor(self))
    }
}

/// The Cholesky factor of a [`Skyline`].
#[derive(Debug, Clone)]
pub struct SkylineFactor(Skyline);

impl SkylineFactor {
    /// Solves the system of the matrix.
    #[must_use]
    pub fn solve(&self, right: &DVector<f64>) -> DVector<f64> {
        let Skyline { first, rows } = &self.0;
        let mut x = right.clone();
        for (row, own) in rows.iter().enumerate() {
            let first = first[row];
            let sum: f64 =
                own[..row - first].iter().zip(x.as_slice()[first..row].iter()).map(|(a, b)| a * b).sum();
            x[row] = (x[row] - sum) / own[row - first];
        }
        for (row, own) in rows.iter().enumerate().rev() {
            let first = first[row];
            x[row] /= own[row - first];
            let value = x[row];
            for (column, entry) in (first..row).zip(own) {
                x[column] -= entry * value;
            }
        }
        x
    }

    /// A block on the diagonal of the inverse of the matrix, from a row on.
    #[must_use]
    pub fn inverse_block<const N: usize>(&self, start: usize) -> SMatrix<f64, N, N> {
        let Skyline { first, rows } = &self.0;
        // Columns of the inverse of the factor, row by row; they begin on the diagonal.
        let mut columns: Vec<SVector<f64, N>> = Vec::with_capacity(rows.len() - start);
        let mut block = SMatrix::zeros();
        for row in start..rows.len() {
            let from = first[row].max(start);
            let mut value = SVector::zeros();
            if row < start + N {
                value[row - start] = 1.0;
            }
            for (entry, known) in rows[row][from - first[row]..].iter().zip(&columns[from - start..]) {
                value -= known * *entry;
            }
            value /= rows[row][row - first[row]];
            block += value * value.transpose();
            columns.push(value);
        }
        block
    }
}

/// In four sums, which a processor adds up at once.
#[inline]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (in_fours, others) = (a.chunks_exact(4).zip(b.chunks_exact(4)), a.len() / 4 * 4);
    for (a, b) in in_fours {
        for i in 0..4 {
            sums[i] += a[i] * b[i];
        }
    }
    let rest: f64 = a[others..].iter().zip(&b[others..]).map(|(a, b)| a * b).sum();
    sums[0] + sums[1] + sums[2] + sums[3] + rest
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;
    use rand::RngExt;
    use visloc_core::RngTree;

    use super::*;

    #[test]
    fn solves_what_a_dense_solver_solves() {
        let mut rng = RngTree::new(1).stream("skyline", 0);
        let num = 30_usize;
        let first: Vec<usize> = (0..num).map(|i| if i % 9 == 8 { 0 } else { i.saturating_sub(3) }).collect();
        let mut skyline = Skyline::new(first.clone());
        let mut dense = DMatrix::<f64>::zeros(num, num);
        for row in 0..num {
            for column in first[row]..row {
                let value = rng.random_range(-1.0..1.0);
                skyline.add(row, column, value);
                dense[(row, column)] = value;
                dense[(column, row)] = value;
            }
            *skyline.diagonal_mut(row) += 20.0;
            dense[(row, row)] = 20.0;
        }
        let right = DVector::from_fn(num, |i, _| i as f64 - 10.0);
        let expected = dense.clone().cholesky().unwrap().solve(&right);
        assert!(
            (Skyline::of(num, |row, column| dense[(row, column)]).solve(&right).unwrap() - &expected).norm()
                < 1e-10
        );
        let factor = skyline.cholesky().unwrap();
        assert!((factor.solve(&right) - expected).norm() < 1e-10);
        let inverse = dense.try_inverse().unwrap();
        for start in [0, 6, 24] {
            let block = factor.inverse_block::<6>(start);
            assert!((block - inverse.fixed_view::<6, 6>(start, start)).norm() < 1e-12);
        }
    }

    #[test]
    fn refuses_what_is_not_positive() {
        let mut skyline = Skyline::new(vec![0, 0]);
        skyline.add(0, 0, 1.0);
        skyline.add(1, 0, 2.0);
        skyline.add(1, 1, 1.0);
        assert!(skyline.solve(&DVector::from_vec(vec![1.0, 1.0])).is_none());
    }
}
