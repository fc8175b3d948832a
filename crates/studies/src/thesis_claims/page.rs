//! `docs/thesis-claims.md`: a table of the claims, and each with its numbers.

use std::fmt::Write;

use anyhow::{Result, ensure};
use report::{Claim, Verdict};

use super::{Regime, decided};

const HEAD: &str = "\
# The thesis' claims, on real and on simulated pushes

What a thesis on data-driven models of pushing claims (M. Bauza, 2017), judged anew by rules that were
set before. Its pushes were real, so real pushes decide where they can tell, and else the rig that is
as rough as real ones; the quiet rig shows what of it is due to how much real pushes scatter. This page
is written by

```text
cargo xtask thesis-claims --data DIR
```

- **real steps**: `mit-push-table`, 3000 steps of 0.2 s at 20 mm/s of the MIT push data set.
- **real recordings**: `mit-push-raw`, 32 pushes of the same square at 100 mm/s.
- **rough rig**, **quiet rig**: the thesis' design of 1980 pushes at five speeds, simulated
  ([rigs](simulated-recordings.md#how-rough-a-rig)).

";

/// The page.
///
/// # Errors
/// Regimes that do not have the same claims.
pub(super) fn page(regimes: &[Regime]) -> Result<String> {
    let n_claims = regimes.first().map_or(0, |regime| regime.claims.len());
    let is_like = |regime: &Regime| regime.claims.len() == n_claims;
    ensure!(regimes.iter().all(is_like), "claims are of another version; judge without --only");
    let rows: Vec<Vec<&Claim>> =
        (0..n_claims).map(|k| regimes.iter().map(|regime| &regime.claims[k]).collect()).collect();
    let is_one = |row: &Vec<&Claim>| row.iter().all(|claim| claim.claim == row[0].claim);
    ensure!(rows.iter().all(is_one), "claims are of another version; judge without --only");
    let mut page = HEAD.to_owned();
    page += &headline(regimes, &rows);
    page += &table(regimes, &rows);
    page += "\n## Each claim\n";
    for row in &rows {
        page += &details(regimes, row);
    }
    Ok(page)
}

/// How many hold, by the regime that decides.
fn headline(regimes: &[Regime], rows: &[Vec<&Claim>]) -> String {
    let count = |wanted: Verdict, of_real: bool| {
        let decided = rows.iter().filter_map(|row| decided(row));
        let counts = decided.filter(|(regime, claim)| {
            claim.verdict == wanted && regimes[*regime].pushes.is_real() == of_real
        });
        counts.count()
    };
    let [held, failed] = [Verdict::Holds, Verdict::DoesNotHold];
    let open = rows.iter().filter(|row| decided(row).is_none()).count();
    let own = |regime: usize| {
        rows.iter().filter(|row| row[regime].verdict == Verdict::DoesNotHold).count()
    };
    let each: Vec<String> = (regimes.iter().enumerate())
        .map(|(k, regime)| format!("{} on the {}", own(k), regime.pushes.name()))
        .collect();
    format!(
        "**Of {} claims, {} hold and {} do not**: on real pushes {} and {}, and of those that real \
         pushes cannot tell, on the rough rig {} and {}{}. Each regime by itself: {} do not hold.\n\n",
        rows.len(),
        count(held, true) + count(held, false),
        count(failed, true) + count(failed, false),
        count(held, true),
        count(failed, true),
        count(held, false),
        count(failed, false),
        if open > 0 { format!("; {open} cannot be told") } else { String::new() },
        each.join(", ")
    )
}

fn table(regimes: &[Regime], rows: &[Vec<&Claim>]) -> String {
    let names: Vec<&str> = regimes.iter().map(|regime| regime.pushes.name()).collect();
    let mut table = format!("| claim | in all | {} |\n|---|---|", names.join(" | "));
    table += &"---|".repeat(names.len());
    table.push('\n');
    for row in rows {
        let all = decided(row).map_or("–", |(_, claim)| word(claim.verdict));
        let cells: Vec<&str> = row.iter().map(|claim| word(claim.verdict)).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(table, "| {} | {all} | {} |", row[0].claim, cells.join(" | "));
    }
    table
}

fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Holds => "holds",
        Verdict::DoesNotHold => "**no**",
        Verdict::NotTestable => "–",
    }
}

/// A claim's numbers in each regime, and by which rule it is judged.
fn details(regimes: &[Regime], row: &[&Claim]) -> String {
    let mut text = format!("\n### {}\n\n", row[0].claim.trim_end_matches('.'));
    for (regime, claim) in regimes.iter().zip(row) {
        let said = match claim.verdict {
            Verdict::NotTestable if claim.value.is_empty() => claim.reason.clone(),
            Verdict::NotTestable => format!("{}: {}", claim.reason, claim.value),
            _ => claim.value.clone(),
        };
        let verdict = match claim.verdict {
            Verdict::Holds => "holds",
            Verdict::DoesNotHold => "does not hold",
            Verdict::NotTestable => "cannot be told",
        };
        let _ = writeln!(text, "- {}: **{verdict}**. {said}", regime.pushes.name());
    }
    if let Some(claim) = row.iter().find(|claim| claim.verdict != Verdict::NotTestable) {
        let _ = writeln!(text, "\nRule: {}.", claim.reason);
    }
    text
}

#[cfg(test)]
mod tests {
    use report::{Claim, Verdict};

    use super::super::Pushes;
    use super::{Regime, page};

    fn regime(pushes: Pushes, verdicts: [Verdict; 2]) -> Regime {
        let claim = |(k, verdict): (usize, Verdict)| Claim {
            claim: format!("{}. Something is so.", k + 1),
            value: format!("{} {k}", pushes.name()),
            verdict,
            reason: "by a rule".into(),
        };
        Regime { pushes, claims: verdicts.into_iter().enumerate().map(claim).collect() }
    }

    #[test]
    fn verdicts_stand_side_by_side_and_the_first_that_can_tell_counts() {
        use Verdict::{DoesNotHold, Holds, NotTestable};
        let regimes = [
            regime(Pushes::RealSteps, [DoesNotHold, NotTestable]),
            regime(Pushes::RoughRig, [Holds, Holds]),
            regime(Pushes::QuietRig, [Holds, DoesNotHold]),
        ];
        let page = page(&regimes).unwrap();
        assert!(
            page.contains("Of 2 claims, 1 hold and 1 do not**: on real pushes 0 and 1"),
            "{page}"
        );
        assert!(
            page.contains("| 1. Something is so. | **no** | **no** | holds | holds |"),
            "{page}"
        );
        assert!(page.contains("| 2. Something is so. | holds | – | holds | **no** |"), "{page}");
        assert!(page.contains("- quiet rig: **does not hold**. quiet rig 1\n"), "{page}");
    }
}
