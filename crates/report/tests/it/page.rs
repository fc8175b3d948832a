//! Laws of the page: escaping, structure, links and nothing from the network.

use std::path::Path;

use report::{
    Claim, Data, Drawing, Drawn, Figure, Line, Page, Panel, Plate, Provenance, ReportError,
    Section, Table, Verdict,
};

const NASTY: &str = "<script>alert('1')</script> & \"2\"";

fn drawn(folder: &Path, name: &str) -> Drawn {
    let panel =
        Panel::new("x in m", "y in m").title(NASTY).with(Line::new(&[0.0, 1.0], &[0.0, 1.0]));
    let data: Data = Table::new().column("x in m", &[0.0, 1.0]).into();
    Figure::single(panel).write(folder, name, &data).expect("the figure is sound")
}

fn page(folder: &Path) -> Page {
    let claim = |verdict| Claim {
        claim: NASTY.to_owned(),
        value: "2.05 N".to_owned(),
        verdict,
        reason: NASTY.to_owned(),
    };
    let provenance = Provenance {
        tool: NASTY.to_owned(),
        arguments: NASTY.to_owned(),
        seed: Some(7),
        inputs: vec![(NASTY.to_owned(), "abc123".to_owned())],
    };
    Page::new(NASTY, NASTY, provenance)
        .with(
            Section::new("chapter-2", NASTY)
                .text(NASTY)
                .figure(Plate::new(drawn(folder, "figure-2.1"), NASTY, NASTY).alt(NASTY))
                .figure(Plate::new(drawn(&folder.join("more data"), "figure-2.2"), NASTY, NASTY)),
        )
        .with(
            Section::new("claims", "Claims")
                .claims(vec![
                    claim(Verdict::Holds),
                    claim(Verdict::DoesNotHold),
                    claim(Verdict::NotTestable),
                ])
                .table(&[NASTY], vec![vec![NASTY.to_owned()]]),
        )
}

#[test]
fn text_from_outside_never_becomes_markup() {
    let folder = tempfile::tempdir().unwrap();
    let html = page(folder.path()).html(folder.path()).unwrap();
    // The one script is the page's own, that saves its tables.
    assert_eq!(html.matches("<script").count(), 1);
    assert!(!html.contains("<script>alert"));
    assert!(html.contains("&lt;script&gt;alert(&#39;1&#39;)&lt;/script&gt; &amp; &quot;2&quot;"));
}

#[test]
fn page_asks_for_nothing_from_outside() {
    let folder = tempfile::tempdir().unwrap();
    let html = page(folder.path()).html(folder.path()).unwrap();
    let without_namespace = html.replace("http://www.w3.org/2000/svg", "");
    for outside in ["http:", "https:", "//cdn", "@import", "url("] {
        assert!(!without_namespace.contains(outside), "{outside}");
    }
}

#[test]
fn every_link_leads_somewhere() {
    let folder = tempfile::tempdir().unwrap();
    page(folder.path()).write(folder.path()).unwrap();
    let html = std::fs::read_to_string(folder.path().join("index.html")).unwrap();
    let links: Vec<&str> =
        html.split("<a href=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    assert_eq!(links.iter().filter(|link| !link.starts_with('#')).count(), 6);
    for link in links {
        match link.strip_prefix('#') {
            Some(anchor) => assert_eq!(html.matches(&format!("id=\"{anchor}\"")).count(), 1),
            None => assert!(folder.path().join(link.replace("%20", " ")).exists(), "{link}"),
        }
    }
}

#[test]
fn claims_and_provenance_are_on_the_page() {
    let folder = tempfile::tempdir().unwrap();
    let html = page(folder.path()).html(folder.path()).unwrap();
    for text in [">holds<", ">does not hold here<", ">not testable<", "2.05 N", "abc123", ">7<"] {
        assert!(html.contains(text), "{text}");
    }
}

#[test]
fn figures_outside_the_folder_and_names_twice_are_refused() {
    let (folder, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let outside = page(folder.path()).write(other.path());
    assert!(matches!(outside, Err(ReportError::Outside { .. })));
    let twice = Page::new("t", "", Provenance::default())
        .with(Section::new("a", "A"))
        .with(Section::new("a", "B"));
    assert!(matches!(twice.html(folder.path()), Err(ReportError::Duplicate { .. })));
    let bad = Page::new("t", "", Provenance::default()).with(Section::new("a b", "A"));
    assert!(matches!(bad.html(folder.path()), Err(ReportError::Name { .. })));
}

#[test]
fn a_film_has_its_pictures_one_below_the_other_and_the_script_that_plays_them() {
    let picture = |k: usize| {
        let panel = Panel::new("x in m", "y in m").with(Line::new(&[0.0, 1.0], &[0.0, k as f64]));
        Drawing::new(&Figure::single(panel), &format!("picture {k} {NASTY}")).unwrap()
    };
    let section = Section::new("film", "Film").film((0..3).map(picture).collect());
    let page = Page::new("A film", "", Provenance::default()).with(section);
    let html = page.single_file().unwrap();
    let film = html.split("data-film>").nth(1).unwrap().split("</section>").next().unwrap();
    assert_eq!(film.matches("<figure").count(), 3);
    assert!(film.find("picture 0").unwrap() < film.find("picture 2").unwrap());
    assert!(!film.contains("<script>alert"));
    assert_eq!(html.matches("querySelectorAll(\"[data-film]\")").count(), 1);
    let without = Page::new("No film", "", Provenance::default()).single_file().unwrap();
    assert!(!without.contains("[data-film]"));
}
