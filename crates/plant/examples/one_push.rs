//! Scratch.
use dataset::ObjectSpec;
use planar::Pose;
use plant::{Numerics, Plant, TipPath, Truth, Variation};
use std::time::Instant;
fn main() {
    let object = ObjectSpec::mit("rect1").unwrap();
    let run = |n: usize, tol: f64, longest: f64, creep: f64, y: f64, beta: f64, speed: f64| {
        let numerics = Numerics { n_pads: n, tolerance: tol, longest_step: longest, creep };
        let plant = Plant::new(&object, &Truth::default(), 9.81, &numerics).unwrap();
        let (s, c) = beta.sin_cos();
        let app = 0.004 + speed * speed / 20.0;
        let path = TipPath {
            start: [-0.045 - 0.00475 - app * c, y - app * s],
            direction: [c, s],
            length: 0.05 + app,
            speed,
            acceleration: 10.0,
            wait: 0.1,
            hold: 0.3,
        };
        let t = Instant::now();
        let tr = plant.push(&Pose::default(), &path, &Variation::default()).unwrap();
        (t.elapsed().as_secs_f64(), tr)
    };
    for (y, beta, speed) in [(0.0, 0.0, 0.02), (0.02, 0.2, 0.02), (0.03, -0.6, 0.02), (-0.01, 0.35, 0.02), (0.02, 0.2, 0.4), (0.04, 0.5, 0.1)] {
        let base = run(400, 2e-7, 5e-3, 5e-5, y, beta, speed);
        let e = base.1.energy();
        println!("y={y} b={beta} v={speed}: {:.1} ms {} steps end {:?} E {:.3e} res {:.2e} {:?}", base.0 * 1e3, base.1.n_steps(), base.1.end_pose(), e.pusher_work, e.residual(), e.slip_heat);
        let end = base.1.end_pose();
        for (n, tol, longest, creep) in [(800, 2e-7, 5e-3, 5e-5), (1600, 2e-7, 5e-3, 5e-5),(144, 2e-7, 5e-3, 5e-5), (400, 5e-8, 2.5e-3, 5e-5), (400, 1e-9, 1e-3, 5e-5), (400, 2e-6, 5e-3, 5e-5), (400, 2e-7, 5e-3, 1e-5), (400, 2e-7, 5e-3, 2e-4)] {
            let o = run(n, tol, longest, creep, y, beta, speed);
            let p = o.1.end_pose();
            println!("   n={n} tol={tol} longest={longest} creep={creep}: {:.1} ms {} steps d={:.4} mm {:.4} mrad", o.0 * 1e3, o.1.n_steps(), (p.position - end.position).norm() * 1e3, (p.angle - end.angle) * 1e3);
        }
    }
}
