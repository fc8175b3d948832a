//! `pushlab report`: the page as text, and in a browser where there is one.

use std::fs;

use serde_json::Value;

use crate::browser::Browser;
use crate::comparison::pushes;

const NASTY: &str = "</script><script>alert(1)</script> & \\\"two\\\" 🦀";
const TWO: [&str; 6] = ["report", "pushes", "--model", "model.toml", "--model", "grain.toml"];

#[test]
fn the_page_is_one_file_that_asks_for_nothing() {
    let set = pushes();
    let run = set.done(&[&TWO[..], &["-o", "a.html", "--json"]].concat());
    let page = set.read("a.html");
    let own = page.replace("http://www.w3.org/2000/svg", "");
    for outside in ["http:", "https:", "//cdn", "@import", "url(", " src=", "<link", "fetch("] {
        assert!(!own.contains(outside), "{outside}");
    }
    assert!(page.contains("content=\"default-src 'none'"));
    let document: Value = serde_json::from_str(&run.stdout).unwrap();
    let result = &document;
    assert_eq!(result["bytes"].as_u64(), Some(page.len() as u64));
    assert_eq!((result["n_pushes"].as_u64(), result["n_played"].as_u64()), (Some(60), Some(60)));
    assert!(page.len() < 3_000_000, "{} bytes", page.len());
    set.done(&[&TWO[..], &["-o", "b.html", "--jobs", "1"]].concat());
    assert!(set.read("b.html") == page, "the same input gives another page");
}

#[test]
fn the_page_shows_errors_pushes_parameters_and_their_origin() {
    let set = pushes();
    set.done(&TWO);
    let page = set.read("report.html");
    for part in [
        "noise floor",
        "On the outline",
        "All 60 pushes",
        "table-anisotropy ratio",
        "<code>report pushes --model model.toml --model grain.toml</code>",
        "64 inputs with their SHA-256",
        "Rows excluded: 51 first_touch",
        "6 repeats of 2 pushes",
    ] {
        assert!(page.contains(part), "no {part}");
    }
    for anchor in ["found", "errors", "pushes", "outline", "maps", "parameters", "provenance"] {
        assert_eq!(page.matches(&format!("id=\"{anchor}\"")).count(), 1, "{anchor}");
    }
    assert_eq!(page.matches("<h1>").count(), 1);
}

#[test]
fn names_from_files_stay_text() {
    let set = pushes();
    let name =
        set.read("model.toml").lines().find(|line| line.starts_with("name")).unwrap().to_owned();
    set.edit("model.toml", &name, &format!("name = \"{NASTY}\""));
    fs::write(set.path("other.toml"), set.read("model.toml")).unwrap();
    let recordings = set.path("pushes/pushes");
    let first = fs::read_dir(&recordings).unwrap().next().unwrap().unwrap().path();
    fs::rename(&first, recordings.join("push <b> & 'x' 🦀")).unwrap();
    set.done(&["report", "pushes", "--model", "model.toml", "--model", "other.toml"]);
    let page = set.read("report.html");
    assert!(!page.contains("<script>alert") && !page.contains("<b>"));
    assert!(page.contains(
        "&lt;/script&gt;&lt;script&gt;alert(1)&lt;/script&gt; &amp; &quot;two&quot; 🦀 (other.toml)"
    ));
    assert!(page.contains("push &lt;b&gt; &amp; &#39;x&#39; 🦀#0"));
    // The data of the player, and each script of drawings and players once.
    assert_eq!(page.matches("</script>").count(), 7);
}

#[test]
fn what_cannot_be_reported_is_refused_with_the_reason() {
    let set = pushes();
    for (arguments, reason) in [
        (&["report", "pushes", "--model", "missing.toml"][..], "cannot read missing.toml"),
        (&["report", "nowhere"], "cannot read nowhere"),
        (&["report", "pushes", "-o", "none/a.html"], "there is no folder none"),
        (&["report", "set"], "2 pushes have steps to compare, at least 3"),
    ] {
        let message = set.error(arguments);
        assert!(message.contains(reason), "{message}");
    }
    fs::create_dir(set.path("folder.html")).unwrap();
    assert!(set.error(&["report", "pushes", "-o", "folder.html"]).contains("it is a folder"));
    set.wrong_usage(&["report", "pushes", "-o", "report.pdf"]);
    assert!(!set.exists("report.html"));
}

/// What a reader does with the player.
const PLAYED: &str = "const seen = document.documentElement.dataset;
const player = document.querySelector('[data-player]');
const press = (node, key) => node.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));
const place = () => player.querySelector('g.measured').getAttribute('transform');
seen.still = place();
player.querySelector('[data-step=\"1\"]').click();
seen.second = player.dataset.push;
player.querySelector('[data-play]').click();
setTimeout(() => {
  seen.midway = player.dataset.time;
  seen.midplace = place();
  player.querySelector('[data-play]').click();
  seen.paused = player.dataset.playing;
  const scrub = player.querySelector('[data-scrub]');
  scrub.value = 0;
  scrub.dispatchEvent(new Event('input'));
  seen.startplace = place();
  const [first] = document.querySelectorAll('.live[tabindex]');
  first.focus();
  press(first, 'ArrowRight');
  seen.tip = document.querySelector('.tip.on')?.textContent ?? '';
  press(first, 'Escape');
  seen.gone = String(!document.querySelector('.tip.on'));
  seen.wide = document.documentElement.scrollWidth - document.documentElement.clientWidth;
  seen.tips = document.querySelectorAll('.spot').length;
  Object.assign(parent.document.documentElement.dataset, seen);
}, 700);
";

#[test]
fn in_a_browser_the_player_moves_and_nothing_fails() {
    let Some(browser) = Browser::found() else { return };
    let set = pushes();
    set.done(&TWO);
    let seen = browser.opened_on_phone(&set, &set.read("report.html"), PLAYED);
    assert_eq!((&seen.console, seen.failure()), (&Vec::new(), None));
    assert_eq!(seen.attribute("second"), "1");
    assert_eq!(seen.attribute("paused"), "false");
    let midway = seen.number("midway");
    assert!(midway > 0.1 && midway < 2.0, "{midway}");
    let places = ["still", "midplace", "startplace"].map(|name| seen.attribute(name));
    assert!(places[0] != places[1] && places[1] != places[2], "{places:?}");
    assert!(seen.attribute("tip").contains("floor"), "{}", seen.attribute("tip"));
    assert_eq!(seen.attribute("gone"), "true");
    assert_eq!(seen.number("wide"), 0.0, "the page scrolls sideways");
    assert!(seen.number("tips") > 100.0);
    let (_, ink) = seen.light_and_ink();
    assert!(ink > 0.05, "nothing is drawn: {ink}");
}
