//! The table of the thesis' claims.

use report::{Claim, Section, Verdict};

/// The section with all claims that the drawn figures settle.
pub(crate) fn section(claims: Vec<Claim>) -> Section {
    let count = |verdict| claims.iter().filter(|claim| claim.verdict == verdict).count();
    let text = format!(
        "Recomputed on these data: {} hold, {} do not hold here, {} cannot be tested.",
        count(Verdict::Holds),
        count(Verdict::DoesNotHold),
        count(Verdict::NotTestable)
    );
    Section::new("claims", "Claims").text(&text).claims(claims)
}

/// A claim judged by a rule on its value.
pub(crate) fn judged(claim: &str, value: String, holds: bool, reason: &str) -> Claim {
    let verdict = if holds { Verdict::Holds } else { Verdict::DoesNotHold };
    Claim { claim: claim.to_owned(), value, verdict, reason: reason.to_owned() }
}

/// A claim that the data cannot settle.
pub(crate) fn untestable(claim: &str, reason: &str) -> Claim {
    let (claim, reason) = (claim.to_owned(), reason.to_owned());
    Claim { claim, value: String::new(), verdict: Verdict::NotTestable, reason }
}
