//! Without a network, on other screens, by keyboard.

use crate::chromium::Microphone;
use crate::page::Page;
use crate::{demonstration, told};
use serde_json::json;

#[test]
fn it_works_offline_on_a_narrow_screen_in_the_dark_and_by_keyboard() {
    let folder = tempfile::tempdir().expect("a folder");
    let (_, file) = demonstration(&folder);
    let test = "it_works_offline";
    let Some(mut page) = Page::open(test, Microphone::Forbidden) else {
        return;
    };
    // Every request so far went to the page's own address.
    let requests: Vec<String> = page.requests();
    assert!(requests.len() > 8, "{requests:?}");
    // It can be installed.
    let odd = page
        .browser
        .call("Page.getInstallabilityErrors", &json!({}));
    assert_eq!(odd["installabilityErrors"], json!([]), "{odd}");
    // Without a server, all of it comes from what was kept, and a file can be heard.
    page.server = None;
    page.reload();
    told(&mut page);
    page.choose(&file);
    let summary = page.ended(60.0);
    assert_eq!(
        summary["alarms"].as_array().map(Vec::len),
        Some(1),
        "{summary}"
    );
    let elsewhere: Vec<String> = page.requests();
    assert!(
        elsewhere.iter().all(|url| page.is_own(url)),
        "{elsewhere:?}"
    );
    // The policy forbids requests elsewhere, whoever asks.
    let asked = page
        .browser
        .value("fetch('https://example.org/').then(() => 'sent', () => 'forbidden')");
    assert_eq!(asked, "forbidden");

    for (width, scheme) in [(1200, "light"), (400, "light"), (400, "dark")] {
        page.screen(width, scheme);
        let wide = page.browser.value("document.documentElement.scrollWidth");
        assert!(wide.as_i64() <= Some(i64::from(width)), "{width}: {wide}");
        page.picture(&format!("{width}-{scheme}"));
    }
    let dark = page
        .browser
        .value("getComputedStyle(document.body).backgroundColor");
    assert_eq!(dark, "rgb(21, 24, 27)");

    // From the top, the tabulator reaches everything, and what is reached can be pressed.
    page.browser.value("document.activeElement.blur()");
    let mut reached = Vec::new();
    for _ in 0..14 {
        page.key("Tab");
        let id = page
            .browser
            .value("document.activeElement.id || document.activeElement.tagName");
        reached.push(id.as_str().unwrap_or_default().to_owned());
    }
    for id in ["listen", "file", "speed", "teeth", "SUMMARY", "gain"] {
        assert!(reached.iter().any(|r| r == id), "{id}: {reached:?}");
    }
    page.browser
        .value("document.getElementById('gain').focus()");
    page.key("Enter");
    assert_eq!(
        page.browser
            .value("document.getElementById('gain-help').open"),
        true
    );
    page.picture("gain");
    page.key("Escape");
    assert_eq!(
        page.browser
            .value("document.getElementById('gain-help').open"),
        false
    );
    // Every field and button has a name for those who do not see it.
    let nameless = page.browser.value(
        "[...document.querySelectorAll('input, select, button, meter')].filter((e) => !(e.labels?.length || e.textContent.trim() || e.ariaLabel)).map((e) => e.id).join()",
    );
    assert_eq!(nameless, "");
    assert!(
        page.browser
            .complaints()
            .iter()
            .all(|c| c.contains("example.org")),
        "{:?}",
        page.browser.complaints()
    );
}
