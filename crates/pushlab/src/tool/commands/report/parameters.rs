//! What the models' files say.

use ::report::Section;

use super::super::models::parameters::{Parameter, Parameters};
use super::{Report, tag};

pub(super) fn section(report: &Report) -> Section {
    let mut section = Section::new("parameters", "The models' parameters");
    for (index, model) in report.models.iter().enumerate() {
        let parameters = Parameters::of(&model.file);
        let surface = parameters.limit_surface.map(|surface| format!(", limit surface: {surface}"));
        let effects: Vec<_> =
            model.file.description.effects.iter().map(|effect| effect.id.as_str()).collect();
        let effects = match effects[..] {
            [] => "no effects".to_owned(),
            _ => format!("effects: {}", effects.join(", ")),
        };
        section = section.text(&format!(
            "{} – {}: {}{}, {effects}.",
            tag(index),
            model.name,
            parameters.kind,
            surface.unwrap_or_default()
        ));
        if !parameters.parameters.is_empty() {
            let rows = parameters.parameters.iter().map(row).collect();
            let head = ["parameter", "value", "standard error", "unit", "source"];
            section = section.table(&head, rows);
        }
        for output in &parameters.learned {
            section = section.text(&format!("{output}: a Gaussian process of p and β."));
        }
    }
    section
}

fn row(parameter: &Parameter) -> Vec<String> {
    let Parameter { name, value, se, unit, source } = parameter;
    let value = value.map_or_else(|| "of the object".to_owned(), |value| value.to_string());
    let se = if *se > 0.0 { se.to_string() } else { "taken as exact".to_owned() };
    vec![name.clone(), value, se, (*unit).to_owned(), source.clone()]
}
