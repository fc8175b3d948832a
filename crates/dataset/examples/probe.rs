use std::path::Path;
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let set = match args.get(3) {
        Some(p) => dataset::RecordingSet::open_with_preset(
            Path::new(&args[1]),
            dataset::Preset::by_name(p).unwrap(),
        ),
        None => dataset::RecordingSet::open(Path::new(&args[1])),
    }
    .unwrap();
    let mut settings = dataset::IngestSettings::default();
    if std::env::var("SMOOTH").is_ok() {
        settings.curve = dataset::Curve::Smooth;
    }
    if let Ok(s) = std::env::var("STEP") {
        settings.step = dataset::StepLength::Time(s.parse().unwrap());
    }
    let start = std::time::Instant::now();
    let (table, report) = dataset::ingest(&set, &settings).unwrap();
    eprintln!("{:?}", start.elapsed());
    table.write(Path::new(&args[2])).unwrap();
    print!("{}", report.to_text());
}
