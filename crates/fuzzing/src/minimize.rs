//! The shortest input that still fails in the same way.

use anyhow::Result;

/// Most inputs that are tried.
const MOST_TRIES: usize = 400;

/// Delta debugging: pieces are left out, large ones first, for as long as the failure stays.
///
/// # Errors
/// What `fails` says.
pub(super) fn minimize(
    input: &[u8],
    fails: &mut dyn FnMut(&[u8]) -> Result<bool>,
) -> Result<Vec<u8>> {
    let mut best = input.to_vec();
    let mut tries = 0;
    let mut length = best.len().div_ceil(2).max(1);
    loop {
        let mut at = 0;
        let mut is_shorter = false;
        while at < best.len() && tries < MOST_TRIES {
            let end = best.len().min(at + length);
            let candidate = [&best[..at], &best[end..]].concat();
            tries += 1;
            if fails(&candidate)? {
                best = candidate;
                is_shorter = true;
            } else {
                at = end;
            }
        }
        if tries >= MOST_TRIES || (length == 1 && !is_shorter) {
            return Ok(best);
        }
        if !is_shorter {
            length = length.div_ceil(2);
        }
        length = length.min(best.len().max(1));
    }
}

#[cfg(test)]
mod tests {
    use super::minimize;

    #[test]
    fn what_does_not_matter_is_left_out() {
        let input: Vec<u8> = (0..200).collect();
        let mut n = 0;
        let mut fails = |bytes: &[u8]| {
            n += 1;
            Ok(bytes.contains(&17) && bytes.contains(&150))
        };
        assert_eq!(minimize(&input, &mut fails).unwrap(), [17, 150]);
        assert!(n < 200, "{n}");
    }

    #[test]
    fn an_input_that_fails_by_itself_becomes_empty() {
        assert_eq!(minimize(b"abc", &mut |_| Ok(true)).unwrap(), b"");
        assert_eq!(minimize(b"", &mut |_| Ok(true)).unwrap(), b"");
    }
}
