//! How fast frames of the tour are made: 320 x 240, with blur and noise, one thread.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use visloc_core::Source;
use visloc_sim::{Scenario, Simulation};

fn frames(c: &mut Criterion) {
    let mut group = c.benchmark_group("frame");
    group.throughput(Throughput::Elements(1));
    for name in ["tour", "crowd"] {
        let make = || Scenario::load(name).and_then(|scenario| Simulation::new(&scenario, 1));
        let Ok(mut simulation) = make() else { continue };
        group.bench_function(name, |b| {
            b.iter(|| {
                let frame = simulation.next_item();
                if frame.is_none()
                    && let Ok(again) = make()
                {
                    simulation = again;
                }
                black_box(frame)
            });
        });
    }
    group.finish();
}

criterion_group!(benches, frames);
criterion_main!(benches);
