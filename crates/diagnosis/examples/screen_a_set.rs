//! Screens a recording set for effects that the nominal model lacks: `screen_a_set SET [patch]`.

use dataset::{RecordingSet, ingest};
use diagnosis::{NoiseModel, Observations, ScreenSettings, screen, steady_ingest};
use models::{Analytical, PushModel, SurfaceKind};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("usage: screen_a_set SET [patch]")?;
    let surface = match arguments.next() {
        Some(_) => SurfaceKind::UniformPatch,
        None => SurfaceKind::Ellipsoid,
    };
    let set = RecordingSet::open(path.as_ref())?;
    let (table, _) = ingest(&set, &steady_ingest())?;
    let observations = Observations::steady(&table, set.manifest())?;
    let nominal = Analytical::nominal(set.manifest().pusher.friction)?;
    let model = nominal.with_surface(surface)?.describe()?;
    let noise = NoiseModel::learn(&model, &[], &observations)?;
    let found = screen(&model, &[], &observations, &noise, &ScreenSettings::default())?;
    let rms = found.whitened_rms.map(|rms| rms.map_or("–".into(), |rms| format!("{rms:.2}")));
    let (steps, pushes) = (found.n_steps, found.n_pushes);
    println!("{steps} steps of {pushes} pushes, whitened RMS {}", rms.join(", "));
    for effect in found.effects.iter().filter(|effect| effect.not_testable.is_none()).take(8) {
        let (p, statistic) = (effect.p_adjusted, effect.statistic);
        print!("{:26} {statistic:9.1}  p {p:.4} ", effect.id);
        for coordinate in &effect.coordinates {
            let (name, unit) = (coordinate.name, coordinate.unit);
            print!(" {name} {:+.2e} ± {:.0e} {unit}", coordinate.change, coordinate.se);
        }
        println!();
    }
    Ok(())
}
