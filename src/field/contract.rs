use super::fixture::*;
use super::*;
#[test]
fn speed() {
    let mut random = Random(1);
    let stack = busy_stack(&mut random, 9, 100);
    let arrangement = stack.arrangement();
    let queries = stack.queries(&mut random, 100_000);
    let cpu = Cpu::new(&arrangement, 1e-6).unwrap();
    for _ in 0..3 {
        let now = cpu_seconds();
        let values = cpu.evaluate(&queries).unwrap();
        let s = cpu_seconds() - now;
        println!("{} {} edges {:.3} G/s", cpu.name(), cpu.edges(0), queries.edge_evaluations(&cpu) as f64 / s / 1e9);
        std::hint::black_box(values);
    }
    let queries = stack.queries(&mut random, 5000);
    let r = Reference::new(&arrangement, 1e-6).unwrap();
    let now = cpu_seconds();
    let want = r.evaluate(&queries).unwrap();
    println!("ref {:.3} G/s", queries.edge_evaluations(&r) as f64 / (cpu_seconds() - now) / 1e9);
    let got = cpu.evaluate(&queries).unwrap();
    let worst = want.iter().zip(&got).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    println!("worst {worst:e}");
}

fn cpu_seconds() -> f64 {
    let s = std::fs::read_to_string("/proc/self/stat").unwrap();
    let v: Vec<&str> = s.rsplit(')').next().unwrap().split_whitespace().collect();
    (v[11].parse::<f64>().unwrap() + v[12].parse::<f64>().unwrap()) / 100.0
}
#[test]
fn speed_gpu() {
    let mut random = Random(1);
    let stack = busy_stack(&mut random, 9, 100);
    let arrangement = stack.arrangement();
    let queries = stack.queries(&mut random, 10_000);
    let gpu = Gpu::new(&arrangement, 1e-6, Adapter::Any).unwrap();
    let cpu = Cpu::new(&arrangement, 1e-6).unwrap();
    for _ in 0..3 {
        let now = cpu_seconds();
        let values = gpu.evaluate(&queries).unwrap();
        let s = cpu_seconds() - now;
        println!("{} {} edges {:.3} G/s", gpu.name(), gpu.edges(0), queries.edge_evaluations(&gpu) as f64 / s / 1e9);
        std::hint::black_box(values);
    }
    let want = cpu.evaluate(&queries).unwrap();
    let got = gpu.evaluate(&queries).unwrap();
    let worst = want.iter().zip(&got).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    println!("worst {worst:e}");
}
