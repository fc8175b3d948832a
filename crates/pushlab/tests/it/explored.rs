//! A report as a reader goes through it: from a finding to its steps and back, by keys, with files to save.

use std::fs;
use std::sync::OnceLock;

use crate::browser::{Browser, Seen};
use crate::comparison::pushes;
use crate::diagnosed::diagnosed;
use crate::small_set::SmallSet;

/// What the scripts of all tests begin with.
const HELPERS: &str = "
const seen = document.documentElement.dataset;
document.documentElement.style.scrollBehavior = 'auto';
const player = document.querySelector('[data-player]');
const wait = () => new Promise((done) => setTimeout(done, 60));
const press = (key) => document.activeElement.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true, cancelable: true }));
const panel = () => document.querySelector('aside.region');
const counted = (text) => (/(\\d+) steps of (\\d+) pushes/.exec(text) ?? []).slice(1).join(' ');
const files = [];
const blobs = URL.createObjectURL;
URL.createObjectURL = (blob) => { files.push(blob.text()); return blobs.call(URL, blob); };
const saved = async (button) => { button.click(); return (await files.pop()).trim().split('\\n'); };
const isSeen = (node) => { const { top, bottom } = node.getBoundingClientRect(); return bottom > 0 && top < innerHeight; };
";

/// The page of two models, of which the second claims a grain that is not there.
fn page() -> (SmallSet, String) {
    static PAGE: OnceLock<String> = OnceLock::new();
    let set = pushes();
    let page = PAGE.get_or_init(|| {
        set.done(&["report", "pushes", "--model", "grain.toml", "--model", "model.toml"]);
        set.read("report.html")
    });
    (set, page.clone())
}

/// What is seen after a script, which may wait.
fn after(script: &str) -> Option<Seen> {
    let browser = Browser::found()?;
    let (set, page) = page();
    let script = format!("{HELPERS}(async () => {{ {script} seen.done = 'yes'; }})();");
    let seen = browser.opened(&set, &page, &script, &[]);
    assert_eq!((&seen.console, seen.failure()), (&Vec::new(), None));
    assert_eq!(seen.attribute("done"), "yes");
    Some(seen)
}

#[test]
fn a_finding_leads_to_its_cells_its_pushes_and_the_player_and_back() {
    let script = "
        const links = [...document.querySelectorAll('a[data-in]')];
        const link = links.find((link) => link.dataset.in.includes('='));
        link.click();
        await wait();
        seen.hash = location.hash === '#in/' + link.dataset.in;
        const map = panel().previousElementSibling;
        seen.marked = map.querySelectorAll('.spot.chosen').length;
        seen.visible = isSeen(map) && isSeen(panel());
        const listed = [...panel().querySelectorAll('li a')];
        seen.listed = listed.length;
        seen.counted = counted(panel().textContent);
        listed[0].click();
        await wait();
        seen.push = location.hash === listed[0].hash && player.dataset.push === String(Number(listed[0].hash.slice(6)) - 1);
        seen.shaded = player.querySelectorAll('.charts .in').length;
        seen.charts = [...player.querySelectorAll('[data-chart]')].map((chart) => chart.dataset.chart).join(' ');
        seen.focus = player.querySelectorAll('.charts .focus').length;
        seen.chosen = player.querySelector('[data-chosen]').textContent;
        seen.active = document.activeElement === player;
        press('n');
        seen.next = player.dataset.push === String(Number(listed[1].hash.slice(6)) - 1);
        seen.told = player.querySelectorAll('[data-told] a').length;
        press('Escape');
        await wait();
        seen.back = location.hash === '#in/' + link.dataset.in && document.activeElement === panel();
        const finding = [...panel().querySelectorAll('a')].find((one) => one.textContent === 'back to the finding');
        finding.click();
        await wait();
        seen.target = document.querySelector('li:target').contains(link) && isSeen(link);
        history.back();
        await wait();
        seen.history = location.hash === '#in/' + link.dataset.in;
        panel().focus();
        press('Escape');
        await wait();
        seen.closed = !panel() && document.querySelectorAll('.spot.chosen').length === 0;
    ";
    let Some(seen) = after(script) else { return };
    for name in ["hash", "visible", "push", "active", "next", "back", "target", "history", "closed"]
    {
        assert_eq!(seen.attribute(name), "true", "{name}");
    }
    assert!(seen.number("marked") >= 1.0 && seen.number("listed") >= 3.0);
    assert!(seen.number("shaded") >= 1.0 && seen.number("told") >= 1.0);
    assert_eq!(seen.number("focus"), 1.0);
    let charts = "dx dy dtheta force_normal force_tangential gap_start gap_end";
    assert_eq!(seen.attribute("charts"), charts);
    assert!(seen.attribute("chosen").contains("push 1 of"), "{}", seen.attribute("chosen"));
}

#[test]
fn cells_of_maps_lead_to_as_many_steps_as_they_say() {
    let script = "
        let [n, wrong] = [0, []];
        for (const details of document.querySelectorAll('#maps details')) details.open = true;
        for (const map of document.querySelectorAll('.live[data-number]')) {
          for (const spot of map.querySelectorAll('[data-cell]')) {
            n += 1;
            if (n % 13) continue;
            spot.dispatchEvent(new CustomEvent('choose', { bubbles: true }));
            await new Promise((done) => setTimeout(done, 2));
            const [told, found] = [counted(spot.dataset.text), counted(panel()?.textContent ?? '')];
            if (told !== found) wrong.push(`${map.dataset.number} ${map.dataset.over} ${spot.dataset.cell}: ${told}, ${found}`);
          }
        }
        seen.cells = n;
        seen.wrong = wrong.slice(0, 5).join('; ');
    ";
    let Some(seen) = after(script) else { return };
    assert_eq!(seen.attribute("wrong"), "");
    assert!(seen.number("cells") > 100.0, "{}", seen.number("cells"));
}

#[test]
fn maps_are_read_and_followed_by_keys_and_steps_lead_back_to_their_cells() {
    let script = "
        const map = document.querySelector('.live[data-over=\"p beta\"]');
        map.focus();
        press('ArrowRight');
        const text = document.querySelector('.tip.on').textContent;
        press('Enter');
        await wait();
        seen.same = counted(text) !== '' && counted(text) === counted(panel().textContent);
        seen.focused = document.activeElement === panel();
        panel().querySelector('li a').click();
        await wait();
        press('ArrowLeft');
        press('ArrowLeft');
        const before = Number(player.dataset.time);
        press('ArrowRight');
        seen.stepped = Number(player.dataset.time) > before;
        const chart = player.querySelector('[data-chart=dtheta]');
        const { left, top } = chart.getBoundingClientRect();
        chart.dispatchEvent(new PointerEvent('pointerdown', { clientX: left + 1, clientY: top + 1, bubbles: true }));
        seen.sought = player.dataset.time;
        // Cells of few steps are not drawn.
        let cell = player.querySelector('[data-where] a');
        for (let k = 0; k < 12 && !cell; k += 1) {
          press('ArrowRight');
          cell = player.querySelector('[data-where] a');
        }
        seen.where = player.querySelector('[data-where]').textContent;
        cell.click();
        await wait();
        seen.cell = location.hash === cell.hash && panel() !== null;
        press(' ');
        seen.open = document.querySelectorAll('details:not([open])').length;
    ";
    let Some(seen) = after(script) else { return };
    for name in ["same", "focused", "stepped", "cell"] {
        assert_eq!(seen.attribute(name), "true", "{name}");
    }
    assert_eq!(seen.number("sought"), 0.0);
    assert!(seen.attribute("where").starts_with("Step "), "{}", seen.attribute("where"));
}

#[test]
fn two_models_lie_over_each_other_behind_a_slider() {
    let script = "
        const pair = document.querySelector('#maps .pair');
        const [before, after] = pair.querySelectorAll('.stack > .live');
        const slider = pair.querySelector('input');
        const at = (value) => { slider.value = value; slider.dispatchEvent(new Event('input')); return getComputedStyle(after).clipPath; };
        seen.pairs = document.querySelectorAll('.pair.on').length;
        seen.left = at(25);
        seen.right = at(100);
        const [a, b] = [before, after].map((node) => node.getBoundingClientRect());
        seen.over = a.left === b.left && a.top === b.top && a.width === b.width;
        const axis = (node) => [...node.querySelectorAll('text')].map((text) => text.textContent).join();
        seen.same = axis(before) === axis(after);
        seen.models = before.dataset.models + after.dataset.models;
    ";
    let Some(seen) = after(script) else { return };
    assert!(seen.number("pairs") >= 1.0);
    assert!(seen.attribute("left").contains("25%") && seen.attribute("right").contains("100%"));
    assert_eq!((seen.attribute("over"), seen.attribute("same")), ("true", "true"));
    assert_eq!(seen.attribute("models"), "01");
}

#[test]
fn tables_maps_and_pushes_are_saved_as_csv() {
    let script = "
        const table = document.querySelector('#errors table');
        const lines = await saved(document.querySelector('#errors .scroll + .csv'));
        seen.rows = lines.length === table.rows.length;
        seen.head = lines[0];
        seen.minus = lines.some((line) => line.includes('−'));
        const map = await saved(document.querySelector('#maps figcaption .csv'));
        seen.map = map[0];
        seen.cells = map.length - 1;
        const [poses, steps] = player.querySelectorAll('[data-save]');
        const [played, stepped] = [await saved(poses), await saved(steps)];
        seen.poses = played[0];
        seen.times = played.length - 1;
        seen.steps = stepped[0];
        seen.nsteps = stepped.length - 1;
        seen.tables = document.querySelectorAll('section .scroll table').length - 1 - document.querySelectorAll('section .scroll + .csv').length;
    ";
    let Some(seen) = after(script) else { return };
    assert_eq!((seen.attribute("rows"), seen.attribute("minus")), ("true", "false"));
    assert!(
        seen.attribute("head")
            .starts_with("\"error of a step, RMS\",".replace('"', "&quot;").as_str())
    );
    assert!(seen.attribute("map").starts_with("model,"), "{}", seen.attribute("map"));
    assert!(seen.attribute("poses").contains("measured x in mm,measured y in mm"));
    assert!(seen.attribute("steps").contains("less that of A"), "{}", seen.attribute("steps"));
    assert!(seen.number("cells") > 2.0 && seen.number("times") > seen.number("nsteps"));
    assert_eq!(seen.number("tables"), 0.0, "tables without a button");
}

#[test]
fn the_page_is_as_light_as_the_screen_and_has_much_on_it() {
    let Some(browser) = Browser::found() else { return };
    let (set, page) = page();
    let long = "--window-size=900,5000";
    let light = browser.opened(&set, &page, "", &[long]);
    let dark = browser.opened(&set, &page, "", &[long, "--blink-settings=preferredColorScheme=0"]);
    let [(bright, ink), (dim, more)] = [&light, &dark].map(Seen::light_and_ink);
    assert!(bright > 0.8 && dim < 0.4, "mean brightness {bright:.2} and {dim:.2}");
    // The same is drawn on both.
    assert!(ink > 0.05 && (ink / more - 1.0).abs() < 0.5, "{ink:.3} and {more:.3}");
}

#[test]
fn without_scripts_findings_lead_to_maps_that_are_there() {
    let (_, page) = page();
    let anchors = page.split("class=\"steps\" href=\"#").skip(1);
    let anchors: Vec<&str> = anchors.filter_map(|rest| rest.split('"').next()).collect();
    assert!(!anchors.is_empty());
    for anchor in anchors {
        assert_eq!(page.matches(&format!("id=\"{anchor}\"")).count(), 1, "{anchor}");
    }
}

#[test]
fn maps_of_a_model_keep_all_pushes_beside_one_that_was_fitted() {
    let (set, _) = diagnosed();
    set.done(&["report", "pushes", "-o", "alone.html"]);
    set.done(&["report", "pushes", "--model", "model.toml", "--model", "fitted.toml"]);
    let [alone, both] =
        ["alone.html", "report.html"].map(|name| fs::read_to_string(set.path(name)).unwrap());
    // Each cell with its numbers, as files of the map have them.
    let cells = |page: &str| -> Vec<String> {
        let files =
            page.split("<pre hidden data-csv>").skip(1).filter_map(|rest| rest.split('<').next());
        let rows = files.flat_map(str::lines).filter(|line| line.starts_with("A,"));
        rows.map(str::to_owned).collect()
    };
    let (alone, both) = (cells(&alone), cells(&both));
    assert!(alone.len() > 100, "{}", alone.len());
    let lost: Vec<&String> = alone.iter().filter(|row| !both.contains(row)).collect();
    assert!(lost.is_empty(), "{lost:?}");
}

#[test]
fn a_signature_is_drawn_in_the_number_and_over_what_shows_it() {
    let (set, mut diagnosis) = diagnosed();
    let signature = |set: &SmallSet| {
        set.done(&["report", "pushes", "--from", "d.json", "--force"]);
        let page = set.read("report.html");
        let section = page.split("id=\"diagnosis\"").nth(1).unwrap();
        let section = section.split("<section").next().unwrap();
        let of = |rest: &str| {
            let number = rest.split('"').next().unwrap();
            let over = rest.split("data-over=\"").nth(1).unwrap().split('"').next().unwrap();
            format!("{number} over {over}")
        };
        let drawn: Vec<String> = section.split("data-number=\"").skip(1).map(of).collect();
        drawn
    };
    // A table's tilt pulls to one side of the world, whatever is pushed where.
    let drawn = signature(&set);
    assert!(drawn.iter().any(|one| one.ends_with("over direction")), "{drawn:?}");
    // A pusher that is thicker than it is said to be is seen in the gap to it, the same everywhere.
    diagnosis["identified"] = serde_json::json!(["pusher-radius"]);
    diagnosis["ambiguous"] = serde_json::json!([]);
    let parameter = serde_json::json!({ "name": "excess", "unit": "m", "off": 0.0, "estimate": 3e-4, "se": 1e-5,
        "low95": 2.8e-4, "high95": 3.2e-4, "detection_limit": 1e-5 });
    diagnosis["effects"][1]["id"] = "pusher-radius".into();
    diagnosis["effects"][1]["grade"] = "identified".into();
    diagnosis["effects"][1]["parameters"] = serde_json::json!([parameter]);
    set.write("d.json", &diagnosis.to_string());
    let drawn = signature(&set);
    assert!(drawn.iter().all(|one| one.starts_with("gap_")) && !drawn.is_empty(), "{drawn:?}");
}
