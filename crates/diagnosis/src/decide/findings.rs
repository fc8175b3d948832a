//! What was found of each effect.

use std::sync::Arc;

use effects::{Effect, Off, by_id_with};

use super::claims::Claims;
use super::found::Found;
use super::rules::Objection;
use super::{DiagnoseSettings, EffectFinding, Grade, ParameterFinding};
use crate::cut_offs::HINT;
use crate::statistics::quantile::student_975;
use crate::{EffectFit, Gain, ParameterFit, ScreenedCoordinate, ScreenedEffect};

/// Every effect that the model under test lacks, those claimed first.
pub(super) fn findings(
    found: &Found,
    (claims, members): (&Claims, &[EffectFit]),
    settings: &DiagnoseSettings,
) -> Vec<EffectFinding> {
    let all = found.first_screen.effects.iter();
    let mut findings: Vec<EffectFinding> =
        all.map(|screened| Finding { found, claims, members, settings, screened }.tell()).collect();
    let place = |finding: &EffectFinding| {
        let accepted = found.accepted.iter().position(|one| one.id == finding.id);
        (finding.grade as usize, accepted.unwrap_or(usize::MAX))
    };
    findings.sort_by_key(place);
    findings
}

/// One effect with all that is known of it.
struct Finding<'a> {
    found: &'a Found,
    claims: &'a Claims,
    /// Members of groups as fitted.
    members: &'a [EffectFit],
    settings: &'a DiagnoseSettings,
    screened: &'a ScreenedEffect,
}

impl Finding<'_> {
    fn tell(&self) -> EffectFinding {
        let id = self.screened.id;
        let (found, claims) = (self.found, self.claims);
        let accepted = found.accepted.iter().position(|one| one.id == id);
        let last = found.last_screen.effects.iter().find(|effect| effect.id == id);
        let is_hint = last.is_some_and(|effect| effect.p_adjusted <= HINT);
        let objection = self.objection(accepted);
        // What a later model shows was hidden from the first screen alone.
        let not_testable = self.screened.not_testable.as_ref().filter(|_| accepted.is_none());
        let small = claims.small.iter().find(|(one, ..)| *one == id);
        let grade = if not_testable.is_some() {
            Grade::NotTestable
        } else if let Some((_, grade, _)) = small {
            *grade
        } else if claims.identified.contains(&id) {
            Grade::Identified
        } else if claims.effective.iter().any(|(one, _)| *one == id) {
            Grade::Effective
        } else if claims.groups.iter().any(|group| group.contains(&id)) {
            Grade::Ambiguous
        } else if objection.as_ref().map_or(is_hint, Objection::is_hint) {
            Grade::Hint
        } else {
            Grade::BelowDetectionLimit
        };
        let effective = claims.effective.iter().find(|(one, _)| *one == id);
        let is_tested = not_testable.is_none();
        let p_adjusted = accepted.map(|k| found.accepted[k].p_adjusted);
        let p_adjusted = p_adjusted
            .or_else(|| last.filter(|_| is_tested).map(|one| one.p_adjusted))
            .or_else(|| is_tested.then_some(self.screened.p_adjusted));
        let why = match (not_testable, objection) {
            (Some(why), _) => format!("{}; measure {}", why.because, why.measure),
            (None, Some(objection)) => objection.to_string(),
            (None, None) => {
                let of_small = small.map(|(.., why)| why.clone()).filter(|why| !why.is_empty());
                let told = of_small.or(effective.map(|(_, why)| why.clone()));
                told.unwrap_or_else(|| self.reason(grade, accepted, p_adjusted))
            }
        };
        EffectFinding {
            id: id.to_owned(),
            grade,
            small: small.is_some(),
            p_adjusted,
            gap_closed: accepted.and_then(|k| found.accepted[k].gap_closed),
            log_density_gain: accepted.map(|k| found.accepted[k].gain),
            parameters: self.parameters(accepted),
            rivals: self.rivals(accepted),
            why,
        }
    }

    /// Why an effect has its grade, where no rule spoke of it.
    fn reason(&self, grade: Grade, accepted: Option<usize>, p_adjusted: Option<f64>) -> String {
        if let Some(gain) = accepted.map(|k| self.found.accepted[k].gain) {
            let Gain { mean, se } = gain;
            return format!("pushes that no fit has seen gain {mean:.0} ± {se:.0} nats");
        }
        let p = p_adjusted.unwrap_or(1.0);
        match grade {
            Grade::Ambiguous => "it explains as much as the others of its group".to_owned(),
            Grade::Hint => format!("its sign is weak (p {p:.4})"),
            _ if p > HINT => format!("its sign is within chance (p {p:.2})"),
            _ if self.is_left_open() => {
                "its number is fitted beside every effect, and stays within what the manifest \
                 leaves open"
                    .to_owned()
            }
            _ => "its sign is weak beside that of others".to_owned(),
        }
    }

    /// Whether every fit leaves the effect's numbers open.
    fn is_left_open(&self) -> bool {
        let effect = self.effect();
        let tolerance = effect.and_then(|effect| self.settings.screen.tolerances.of(effect.info()));
        tolerance == Some(f64::INFINITY)
    }

    /// What keeps an effect that passed the screen from being claimed.
    fn objection(&self, accepted: Option<usize>) -> Option<Objection> {
        if accepted.is_some() {
            return None;
        }
        let mut refused = self.found.refused.iter().rev();
        let refused = refused.find(|refused| refused.id == self.screened.id);
        refused.map(|refused| refused.objection.clone())
    }

    /// Effects that explain as much, and those that the screen could not tell from it.
    fn rivals(&self, accepted: Option<usize>) -> Vec<String> {
        let id = self.screened.id;
        let mut rivals: Vec<&str> =
            accepted.map_or(Vec::new(), |k| self.found.accepted[k].rivals.clone());
        for pair in &self.found.first_screen.look_alikes {
            let other = match (pair.one == id, pair.other == id) {
                (true, _) => pair.other,
                (_, true) => pair.one,
                _ => continue,
            };
            if !rivals.contains(&other) {
                rivals.push(other);
            }
        }
        rivals.into_iter().map(str::to_owned).collect()
    }

    fn parameters(&self, accepted: Option<usize>) -> Vec<ParameterFinding> {
        let member = || self.members.iter().find(|member| member.id == self.screened.id);
        let fit = accepted.map(|k| &self.found.accepted[k].effect).or_else(member);
        let coordinates = &self.screened.coordinates;
        match fit {
            Some(fit) => self.fitted(fit),
            None if self.screened.not_testable.is_some() => {
                coordinates.iter().map(unknown).collect()
            }
            // Beside what was added: before, it took what the added effects do for itself.
            None => {
                let freedom = self.found.first_screen.calibration.n_clusters as f64 - 1.0;
                let quantile = student_975(freedom);
                self.beside_the_added().iter().map(|one| bounded(one, quantile)).collect()
            }
        }
    }

    /// The coordinates of an effect that was not added, tested beside those that were.
    fn beside_the_added(&self) -> &[ScreenedCoordinate] {
        let mut last = self.found.last_screen.effects.iter();
        let last = last.find(|effect| effect.id == self.screened.id);
        let known = last.map(|effect| effect.coordinates.as_slice());
        known.filter(|known| !known.is_empty()).unwrap_or(&self.screened.coordinates)
    }

    fn fitted(&self, fit: &EffectFit) -> Vec<ParameterFinding> {
        let effect = self.effect();
        let detectable = |name: &str| {
            let index = effect?.info().parameters.iter().position(|one| one.name == name)?;
            let is_sized = effect?.info().parameters[index].off != Off::Undefined;
            let coordinate = self.screened.coordinates.get(index).filter(|_| is_sized)?;
            // A coordinate of a ratio along a direction is ½ ln ratio.
            let is_axis = coordinate.name != name;
            let size = coordinate.detection_limit;
            Some(if is_axis { (2.0 * size).exp_m1() } else { size })
        };
        let finding = |parameter: &ParameterFit| ParameterFinding {
            name: parameter.name.to_owned(),
            unit: parameter.unit.to_owned(),
            off: parameter.off,
            estimate: Some(parameter.value),
            se: Some(parameter.se),
            low95: parameter.interval.map(|interval| interval.low95),
            high95: parameter.interval.map(|interval| interval.high95),
            detection_limit: detectable(parameter.name),
        };
        // A point that bears nothing is none.
        let is_told = |parameter: &&ParameterFit| {
            fit.follows.is_empty() || parameter.value != 0.0 || parameter.se > 0.0
        };
        fit.parameters.iter().filter(is_told).map(finding).collect()
    }

    fn effect(&self) -> Option<&Arc<dyn Effect>> {
        by_id_with(self.screened.id, &self.settings.own).ok()
    }
}

/// A coordinate that was not seen: within some standard errors of its one-step estimate, as far as the effect
/// allows.
fn bounded(coordinate: &ScreenedCoordinate, quantile: f64) -> ParameterFinding {
    let ScreenedCoordinate { off, here, range, change, se, detection_limit, .. } = *coordinate;
    let at = |quantile: f64| Some((here + change + quantile * se).clamp(range.0, range.1));
    ParameterFinding {
        off: Some(off),
        estimate: at(0.0),
        se: Some(se),
        low95: at(-quantile),
        high95: at(quantile),
        detection_limit: Some(detection_limit),
        ..unknown(coordinate)
    }
}

fn unknown(coordinate: &ScreenedCoordinate) -> ParameterFinding {
    ParameterFinding {
        name: coordinate.name.to_owned(),
        unit: coordinate.unit.to_owned(),
        off: None,
        estimate: None,
        se: None,
        low95: None,
        high95: None,
        detection_limit: None,
    }
}
