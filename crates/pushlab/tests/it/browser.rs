//! Pages in a real browser, where this machine has one.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use tiny_skia::Pixmap;

use crate::small_set::SmallSet;

/// A browser to open pages with.
pub(crate) struct Browser(PathBuf);

/// What a page was seen to do, and what it wrote to the console.
pub(crate) struct Seen {
    /// The outermost element.
    dom: String,
    pub(crate) console: Vec<String>,
    pub(crate) picture: Pixmap,
}

impl Seen {
    /// What the script of a test left at the outermost element.
    pub(crate) fn attribute(&self, name: &str) -> &str {
        let start = format!("data-{name}=\"");
        let rest = self.dom.split(&start).nth(1);
        let rest = rest.unwrap_or_else(|| panic!("no {name} in {}", self.dom));
        rest.split('"').next().unwrap()
    }

    pub(crate) fn number(&self, name: &str) -> f64 {
        let text = self.attribute(name);
        text.parse().unwrap_or_else(|_| panic!("{name} is `{text}`"))
    }

    /// The error that ended a script, or what the page's policy forbade.
    pub(crate) fn failure(&self) -> Option<&str> {
        self.dom.contains("data-failed=").then(|| self.attribute("failed"))
    }

    /// Mean brightness of the picture, 0 to 1, and the share of its pixels that are not of the most
    /// frequent brightness.
    pub(crate) fn light_and_ink(&self) -> (f64, f64) {
        let gray = |p: &tiny_skia::PremultipliedColorU8| {
            (u32::from(p.red()) + u32::from(p.green()) + u32::from(p.blue())) / 3
        };
        let grays: Vec<u32> = self.picture.pixels().iter().map(gray).collect();
        let mut counts = [0_usize; 256];
        grays.iter().for_each(|gray| counts[*gray as usize] += 1);
        let n = grays.len() as f64;
        let ground = counts.iter().max().copied().unwrap_or_default() as f64;
        (f64::from(grays.iter().sum::<u32>()) / 255.0 / n, 1.0 - ground / n)
    }
}

/// Before all scripts of a page: frames by the clock, which runs at once in a browser without
/// window, and every error where the test finds it.
const BEFORE: &str = "<script>
window.requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), 16);
window.cancelAnimationFrame = clearTimeout;
const fail = (text) => (document.documentElement.dataset.failed ??= text);
window.addEventListener('error', (event) => fail(event.message));
window.addEventListener('unhandledrejection', (event) => fail(String(event.reason)));
window.addEventListener('securitypolicyviolation', (event) => fail(event.blockedURI));
</script>";

impl Browser {
    /// None, and a line that says so, where there is no browser.
    pub(crate) fn found() -> Option<Self> {
        let path = std::env::var_os("PATH")?;
        let places = || std::env::split_paths(&path);
        let names = ["chromium", "chromium-browser", "google-chrome"];
        let mut files = names.iter().flat_map(|name| places().map(move |place| place.join(name)));
        let found = files.find(|file| file.exists()).map(Self);
        if found.is_none() {
            eprintln!("not checked: this machine has none of {}", names.join(", "));
        }
        found
    }

    /// Opens a page with a script at its end that does what a reader does.
    pub(crate) fn opened(&self, set: &SmallSet, page: &str, script: &str, more: &[&str]) -> Seen {
        let page = page.replacen("<meta http-equiv", &format!("{BEFORE}<meta http-equiv"), 1);
        let page = page.replacen("</body>", &format!("<script>{script}</script></body>"), 1);
        set.write("page.html", &page);
        self.shown(set, "page.html", more)
    }

    /// The same in a frame as wide as a phone; its outermost element is copied to that of the frame's page.
    pub(crate) fn opened_on_phone(&self, set: &SmallSet, page: &str, script: &str) -> Seen {
        let page = page.replacen("<meta http-equiv", &format!("{BEFORE}<meta http-equiv"), 1);
        let page = page.replacen("</body>", &format!("<script>{script}</script></body>"), 1);
        let source = page.replace('&', "&amp;").replace('"', "&quot;");
        let frame = format!(
            "<!DOCTYPE html><body><iframe style=\"width:390px;height:840px\" srcdoc=\"{source}\"></iframe>"
        );
        set.write("frame.html", &frame);
        let seen = self.shown(set, "frame.html", &[]);
        let dom = seen.dom.split("srcdoc=").next().unwrap_or_default().to_owned();
        Seen { dom, ..seen }
    }

    fn shown(&self, set: &SmallSet, page: &str, more: &[&str]) -> Seen {
        let picture = set.path("page.png");
        let output = Command::new(&self.0)
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic"])
            .args(["--no-first-run", "--disable-background-networking", "--disable-sync"])
            .args(["--disable-component-update", "--enable-logging=stderr", "--dump-dom"])
            .args(["--virtual-time-budget=12000", "--window-size=900,1000"])
            .args(more)
            .arg(format!("--user-data-dir={}", set.path("profile").display()))
            .arg(format!("--screenshot={}", picture.display()))
            .arg(format!("file://{}", set.path(page).display()))
            .output()
            .unwrap();
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        let console =
            errors.lines().filter(|line| line.contains("CONSOLE")).map(str::to_owned).collect();
        let dom = String::from_utf8_lossy(&output.stdout);
        let dom = dom.split("<head>").next().unwrap_or_default().to_owned();
        let picture = Pixmap::decode_png(&fs::read(picture).unwrap()).unwrap();
        Seen { dom, console, picture }
    }
}
