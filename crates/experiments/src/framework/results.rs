//! What the runs found.

/// Records of all cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Results<R> {
    cells: Vec<Vec<Option<R>>>,
}

impl<R> Results<R> {
    pub(super) fn new(num_runs: impl Iterator<Item = u64>) -> Self {
        let empty = |runs: u64| (0..runs).map(|_| None).collect();
        Self { cells: num_runs.map(empty).collect() }
    }

    /// Records of a cell in the order of the runs; what has not been run is left out.
    pub fn cell(&self, cell: usize) -> impl Iterator<Item = &R> {
        self.cells[cell].iter().flatten()
    }

    /// How many runs are not there, because they belong to other parts or the runs were stopped.
    pub fn num_missing(&self) -> usize {
        self.cells.iter().flatten().filter(|record| record.is_none()).count()
    }

    /// How many runs there are in all.
    pub fn num_runs(&self) -> usize {
        self.cells.iter().map(Vec::len).sum()
    }

    pub(super) fn has(&self, cell: usize, run: usize) -> bool {
        self.cells[cell][run].is_some()
    }

    /// Takes in a record; runs beyond the wanted number are left out.
    pub(super) fn set(&mut self, cell: usize, run: usize, record: R) {
        if let Some(place) = self.cells[cell].get_mut(run) {
            *place = Some(record);
        }
    }
}
