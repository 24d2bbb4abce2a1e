//! What has to hold of every report.

use serde_json::{Value, json};

use crate::browser::Browser;
use crate::pages::Page;

/// Each series has its entry in the legend; no series is empty.
pub async fn series_are_all_there(browser: &Browser) {
    let wrong = browser
        .eval(
            "const wrong = [], figures = [...document.querySelectorAll('figure')];
             for (const f of figures) {
               const names = [...f.querySelectorAll('.plot [data-name]')].filter(e => !e.classList.contains('guide')).map(e => e.dataset.name);
               const entries = [...f.querySelectorAll('.legend .entry')].map(e => e.dataset.name);
               const distinct = [...new Set(names.filter(Boolean))];
               if (distinct.some(n => !entries.includes(n)) || entries.length !== distinct.length)
                 wrong.push([f.id, distinct, entries]);
               if (!f.querySelector('.plot')) wrong.push([f.id, 'no plot']);
               for (const s of f.querySelectorAll('.series'))
                 if (!s.querySelector('path, line, .at, rect')) wrong.push([f.id, s.dataset.name, 'empty']);
             }
             return [figures.length, wrong]",
        )
        .await;
    assert_eq!(wrong[1], json!([]));
}

/// Text stays in its drawing, and ticks stay apart.
pub async fn nothing_overlaps(browser: &Browser, width: &str) {
    let wrong = browser
        .eval(
            "const wrong = [], box = e => e.getBoundingClientRect();
             for (const svg of document.querySelectorAll('.drawing > svg')) {
               const all = box(svg), id = svg.closest('figure').id;
               for (const t of svg.querySelectorAll('text')) {
                 const b = box(t);
                 if (!b.width || getComputedStyle(t).visibility === 'hidden' || t.closest('.plot')) continue;
                 if (b.left < all.left - 1 || b.right > all.right + 1 || b.top < all.top - 1 || b.bottom > all.bottom + 1)
                   wrong.push([id, 'outside', t.textContent, b.left - all.left, b.right - all.right, b.top - all.top, b.bottom - all.bottom]);
                 const size = parseFloat(getComputedStyle(t).fontSize) * all.width / svg.viewBox.baseVal.width;
                 if (size < 10.5) wrong.push([id, 'small', t.textContent, size]);
               }
               for (const kind of ['.tx', '.ty']) for (const g of svg.querySelectorAll(kind)) {
                 const ticks = [...g.querySelectorAll('text:not([transform])')].map(t => [t.textContent, box(t)]);
                 for (let i = 1; i < ticks.length; i++) {
                   const [a, b] = [ticks[i - 1][1], ticks[i][1]];
                   const apart = a.right <= b.left || b.right <= a.left || a.bottom <= b.top + 2 || b.bottom <= a.top + 2;
                   if (!apart) wrong.push([id, 'overlap', ticks[i - 1][0], ticks[i][0]]);
                 }
               }
             }
             return wrong",
        )
        .await;
    assert_eq!(wrong, json!([]), "at {width}");
}

const TICKS: &str = "[...f.querySelectorAll('.tx text, .ty text')].map(t => t.textContent).join(' ') + [...f.querySelectorAll('g.data')].map(g => g.getAttribute('transform'))";

/// Where the plot of the first figure in which one reads and zooms lies in the window.
async fn first_plot(browser: &Browser) -> Option<[f64; 4]> {
    let place = browser
        .eval(
            "const p = document.querySelector('.panel[data-view]');
             if (!p) return null;
             const f = p.closest('figure');
             f.scrollIntoView({ block: 'center' });
             window.f = f;
             const b = p.querySelector('.frame').getBoundingClientRect();
             return [b.left, b.top, b.width, b.height]",
        )
        .await;
    let at = |i: usize| place[i].as_f64();
    Some([at(0)?, at(1)?, at(2)?, at(3)?])
}

/// A mouse that is dragged, and a double click, which brings back what was there.
pub async fn an_interval_is_zoomed_into(browser: &Browser) {
    let Some([left, top, width, height]) = first_plot(browser).await else {
        return;
    };
    let ticks = format!("return {TICKS}");
    let click = json!({ "button": "left", "buttons": 1, "clickCount": 2 });
    let y = top + height / 2.0;
    let held = json!({ "button": "left", "buttons": 1, "clickCount": 1 });
    for (kind, share) in [
        ("mousePressed", 0.4),
        ("mouseMoved", 0.6),
        ("mouseReleased", 0.6),
    ] {
        browser
            .mouse(kind, left + share * width, y, held.clone())
            .await;
    }
    let closer = browser.eval(&ticks).await;
    let x = left + 0.5 * width;
    for kind in ["mousePressed", "mouseReleased"] {
        browser.mouse(kind, x, y, click.clone()).await;
    }
    assert_ne!(
        closer,
        browser.eval(&ticks).await,
        "a double click shows all"
    );
}

/// An entry of the legend takes away what it names, and brings it back.
pub async fn toggles_hide(browser: &Browser) {
    let wrong = browser
        .eval(
            "const wrong = [];
             for (const b of document.querySelectorAll('.entry[aria-pressed]')) {
               const f = b.closest('figure'), name = b.dataset.name;
               const seen = () => [...f.querySelectorAll('.plot [data-name]')].filter(e => e.dataset.name === name && getComputedStyle(e).display !== 'none').length;
               const before = seen();
               b.dispatchEvent(new MouseEvent('click', { bubbles: true }));
               if (!before || seen() || b.getAttribute('aria-pressed') !== 'false') wrong.push([f.id, name, before, seen()]);
               b.dispatchEvent(new MouseEvent('click', { bubbles: true }));
               if (seen() !== before || b.getAttribute('aria-pressed') !== 'true') wrong.push([f.id, name, 'back']);
             }
             return wrong",
        )
        .await;
    assert_eq!(wrong, json!([]));
}

/// The output below a figure names each line over the pointer.
pub async fn values_are_read(browser: &Browser) {
    let Some([left, top, width, height]) = first_plot(browser).await else {
        return;
    };
    let (x, y) = (left + 0.5 * width, top + height / 2.0);
    browser.mouse("mouseMoved", x, y, json!({})).await;
    let missing = browser
        .eval(
            "const text = f.querySelector('output').textContent;
             return [...f.querySelectorAll('.panel[data-view] [data-mark=line]:not(.guide)')].map(s => s.dataset.name).filter(n => !text.includes(n))",
        )
        .await;
    assert_eq!(missing, json!([]));
}

/// Landmarks, one h1, no id twice, heads of tables with a scope.
pub async fn structure(browser: &Browser) {
    let wrong = browser
        .eval(
            "const wrong = [], one = s => document.querySelectorAll(s).length;
             for (const s of ['main', 'header', 'nav', 'h1', 'a.skip']) if (one(s) !== 1) wrong.push([s, one(s)]);
             const ids = [...document.querySelectorAll('[id]')].map(e => e.id);
             for (const id of ids) if (ids.indexOf(id) !== ids.lastIndexOf(id)) wrong.push(['twice', id]);
             for (const th of document.querySelectorAll('th')) if (!th.scope) wrong.push(['scope', th.textContent]);
             for (const a of document.querySelectorAll('a[href^=\"#\"]')) if (!document.getElementById(a.hash.slice(1))) wrong.push(['no target', a.hash]);
             for (const s of document.querySelectorAll('[aria-labelledby]')) for (const id of s.getAttribute('aria-labelledby').split(' ')) if (!document.getElementById(id)) wrong.push(['no label', id]);
             return wrong",
        )
        .await;
    assert_eq!(wrong, json!([]));
}

/// A wide page shows every table whole.
pub async fn tables_fit(browser: &Browser) {
    let wide = browser
        .eval(
            "return [...document.querySelectorAll('.scroll')].filter(e => e.scrollWidth > e.clientWidth + 1)
               .map(e => [e.getAttribute('aria-label'), e.scrollWidth, e.clientWidth])",
        )
        .await;
    assert_eq!(wide, json!([]));
}

pub async fn nothing_overflows(browser: &Browser) {
    let wide = browser
        .eval(
            "const w = document.documentElement.clientWidth, wrong = [];
             if (document.documentElement.scrollWidth > w) for (const e of document.body.querySelectorAll('*'))
               if (e.getBoundingClientRect().right > w + 1 && !e.closest('.scroll > *, pre > *, svg')) wrong.push([e.tagName, e.className, e.getBoundingClientRect().right]);
             return [document.documentElement.scrollWidth - w, wrong.slice(0, 5)]",
        )
        .await;
    assert_eq!(wide[0], 0, "{wide}");
}

/// Relative luminance (WCAG 2.2) of the colours of all text against the page.
const CONTRAST: &str = "
    const parse = c => c.match(/[\\d.]+/g).map(Number);
    const light = c => { const [r, g, b] = parse(c).map(v => { v /= 255; return v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4; }); return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
    const behind = e => { for (; e; e = e.parentElement) { const c = getComputedStyle(e).backgroundColor; if (parse(c)[3] !== 0) return c; } return 'rgb(255, 255, 255)'; };
    const wrong = [];
    for (const e of document.querySelectorAll('h1,h2,h3,p,td,th,dt,dd,li,a,caption,code,button,output,.drawing text')) {
      if (!e.textContent.trim() || !e.getClientRects().length) continue;
      const s = getComputedStyle(e), front = light(e.namespaceURI.endsWith('svg') ? s.fill : s.color), back = light(behind(e));
      const ratio = (Math.max(front, back) + 0.05) / (Math.min(front, back) + 0.05);
      if (ratio < 4.5) wrong.push([e.tagName, e.textContent.slice(0, 30), ratio]);
    }
    return [light(getComputedStyle(document.body).backgroundColor), light(getComputedStyle(document.body).color), wrong.slice(0, 5)]";

pub async fn dark_is_dark(browser: &Browser) {
    let dark = browser.eval(CONTRAST).await;
    assert!(
        dark[0].as_f64().unwrap() < 0.1 && dark[1].as_f64().unwrap() > 0.5,
        "{dark}"
    );
    assert_eq!(dark[2], json!([]), "contrast in the dark");
    browser.scheme("light").await;
    let light = browser.eval(CONTRAST).await;
    assert!(light[0].as_f64().unwrap() > 0.9, "{light}");
    assert_eq!(light[2], json!([]), "contrast in the light");
    browser.scheme("dark").await;
}

pub async fn it_prints(browser: &Browser) {
    let pdf = browser.pdf().await;
    let count = |what: &[u8]| pdf.windows(what.len()).filter(|w| *w == what).count();
    let pages = count(b"/Type /Page") - count(b"/Type /Pages");
    assert!(pages > 0, "{pages} pages of {} bytes", pdf.len());
}

/// Without its script the page has the same sections, tables and drawings.
pub async fn without_script(browser: &Browser, page: &Page) {
    let count = "return ['section', 'tr', '.drawing > svg', 'td'].map(s => document.querySelectorAll(s).length)";
    let with: Value = browser.eval(count).await;
    let off = json!({ "value": true });
    browser
        .cdp("Emulation.setScriptExecutionDisabled", off)
        .await;
    browser.cdp("Page.reload", json!({})).await;
    tokio::time::sleep(std::time::Duration::from_millis(500)).await;
    let on = json!({ "value": false });
    browser
        .cdp("Emulation.setScriptExecutionDisabled", on)
        .await;
    assert_eq!(with, browser.eval(count).await, "{}", page.name);
    let plain = browser
        .eval("return [document.querySelectorAll('button').length, [...document.querySelectorAll('.legend')].every(l => getComputedStyle(l).display !== 'none')]")
        .await;
    assert_eq!(plain, json!([0, true]), "{}", page.name);
}
