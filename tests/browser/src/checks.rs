//! What has to hold of every report.

use serde_json::{Value, json};

use crate::browser::Browser;
use crate::pages::Page;

/// Each name of a legend has its button and its drawing; no series is empty.
pub async fn series_are_all_there(browser: &Browser) {
    let wrong = browser
        .eval(
            "const wrong = [], figures = [...document.querySelectorAll('figure')];
             for (const f of figures) {
               const names = [...f.querySelectorAll('.plot [data-name]')].filter(e => !e.classList.contains('guide')).map(e => e.dataset.name);
               const buttons = [...f.querySelectorAll('button[aria-pressed]')].map(b => b.textContent.trim());
               const distinct = [...new Set(names.filter(Boolean))];
               if (distinct.some(n => !buttons.includes(n.trim())) || buttons.length !== distinct.length)
                 wrong.push([f.id, distinct, buttons]);
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

/// The buttons zoom, and 0 brings back what was there, to the letter.
pub async fn zoom_and_reset(browser: &Browser) {
    let wrong = browser
        .eval(&format!(
            "const wrong = [];
             for (const f of document.querySelectorAll('figure')) {{
               const zoom = [...f.querySelectorAll('button.zoom')];
               if (!zoom.length) continue;
               const before = {TICKS};
               zoom[0].click(); zoom[0].click();
               const closer = {TICKS};
               zoom[1].click();
               zoom[2].click();
               const after = {TICKS};
               if (closer === before) wrong.push([f.id, 'does not zoom', before]);
               if (after !== before) wrong.push([f.id, 'does not come back', before, after]);
             }}
             return wrong"
        ))
        .await;
    assert_eq!(wrong, json!([]));
}

/// Where the plot of the first figure over time (or over names) lies in the window.
async fn first_plot(browser: &Browser) -> Option<[f64; 4]> {
    let place = browser
        .eval(
            "const p = [...document.querySelectorAll('.panel')].find(p => !p.dataset.equal && !p.dataset.xhidden);
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

/// A mouse that is dragged, a wheel with ctrl, a double click.
pub async fn a_box_is_zoomed_into(browser: &Browser) {
    let Some([left, top, width, height]) = first_plot(browser).await else {
        return;
    };
    let ticks = format!("return {TICKS}");
    let before = browser.eval(&ticks).await;
    let y = top + height / 2.0;
    let held = json!({ "button": "left", "buttons": 1, "clickCount": 1 });
    browser
        .mouse("mousePressed", left + 0.4 * width, y, held.clone())
        .await;
    browser
        .mouse("mouseMoved", left + 0.5 * width, y, held.clone())
        .await;
    browser
        .mouse("mouseMoved", left + 0.6 * width, y, held.clone())
        .await;
    browser
        .mouse("mouseReleased", left + 0.6 * width, y, held.clone())
        .await;
    let boxed = browser.eval(&ticks).await;
    assert_ne!(before, boxed, "a drag zooms");
    for count in [1, 2] {
        let click = json!({ "button": "left", "buttons": 1, "clickCount": count });
        browser
            .mouse("mousePressed", left + 0.5 * width, y, click.clone())
            .await;
        browser
            .mouse("mouseReleased", left + 0.5 * width, y, click)
            .await;
    }
    assert_eq!(
        before,
        browser.eval(&ticks).await,
        "a double click shows all"
    );
    let wheel = json!({ "deltaX": 0, "deltaY": -400, "modifiers": 2 });
    browser
        .mouse("mouseWheel", left + 0.5 * width, y, wheel)
        .await;
    browser.settle().await;
    assert_ne!(
        before,
        browser.eval(&ticks).await,
        "ctrl and the wheel zoom"
    );
    browser
        .eval("f.querySelectorAll('button.zoom')[2].click()")
        .await;
}

/// A button takes away what it names, and brings it back.
pub async fn toggles_hide(browser: &Browser) {
    let wrong = browser
        .eval(
            "const wrong = [];
             for (const b of document.querySelectorAll('button[aria-pressed]')) {
               const f = b.closest('figure'), name = b.textContent.trim();
               const seen = () => [...f.querySelectorAll('.plot [data-name]')].filter(e => e.dataset.name.trim() === name && getComputedStyle(e).display !== 'none').length;
               const before = seen();
               b.click();
               if (!before || seen() || b.getAttribute('aria-pressed') !== 'false') wrong.push([f.id, name, before, seen()]);
               b.click();
               if (seen() !== before || b.getAttribute('aria-pressed') !== 'true') wrong.push([f.id, name, 'back']);
             }
             return wrong",
        )
        .await;
    assert_eq!(wrong, json!([]));
}

/// The first number in a text, with the minus sign of print.
fn number_in(text: &str) -> Option<f64> {
    let text = text.replace('−', "-");
    text.split_whitespace().find_map(|w| w.parse().ok())
}

/// What the cursor says is what the drawing shows: the point of each line is looked
/// up by the browser's own geometry, apart from the page's script.
pub async fn the_cursor_tells_what_is_drawn(browser: &Browser) {
    let Some([left, top, width, height]) = first_plot(browser).await else {
        return;
    };
    let mut checked = 0;
    for share in [0.13, 0.5, 0.77] {
        let (x, y) = (left + share * width, top + height / 2.0);
        browser.mouse("mouseMoved", x, y, json!({})).await;
        let described = browser
            .eval("return [...f.querySelectorAll('output b, output span')].map(e => e.textContent)")
            .await;
        let described: Vec<String> = serde_json::from_value(described).unwrap();
        assert!(described.len() > 1, "no description: {described:?}");
        let truth = browser
            .eval(
                "const c = f.querySelector('.cursor').getBoundingClientRect(), at = c.left + c.width / 2;
                 const out = [];
                 for (const p of f.querySelectorAll('.panel')) {
                   const [x0, x1, y0, y1] = p.dataset.view.split(' ').map(Number);
                   const frame = p.querySelector('.frame').getBoundingClientRect();
                   for (const s of p.querySelectorAll('.series')) {
                     const name = (p.dataset.title + ' ' + s.dataset.name).trim();
                     if (s.dataset.mark === 'line') {
                       const path = s.querySelector('path'), m = path.getScreenCTM(), n = path.getTotalLength();
                       let lo = 0, hi = n;
                       for (let k = 0; k < 60; k++) {
                         const mid = (lo + hi) / 2;
                         if (path.getPointAtLength(mid).matrixTransform(m).x < at) lo = mid; else hi = mid;
                       }
                       // All that the line does within a dot and a half of the cursor.
                       let low = Infinity, high = -Infinity, near = Infinity;
                       for (const way of [-0.25, 0.25]) for (let l = lo, k = 0; k < 8000 && l >= 0 && l <= n; k++, l += way) {
                         const q = path.getPointAtLength(l).matrixTransform(m), off = Math.abs(q.x - at);
                         near = Math.min(near, off);
                         if (off > 1.5) break;
                         const y = y1 - (q.y - frame.top) / frame.height * (y1 - y0);
                         low = Math.min(low, y); high = Math.max(high, y);
                       }
                       out.push([name, low, high, y1 - y0, near]);
                     } else if (s.dataset.mark === 'points') {
                       for (const e of s.querySelectorAll('.at')) {
                         const m = e.getScreenCTM();
                         const y = y1 - (m.f - frame.top) / frame.height * (y1 - y0);
                         if (Math.abs(m.e - at) < 3) out.push([name, y, y, y1 - y0, 0]);
                       }
                     }
                   }
                 }
                 return out",
            )
            .await;
        for line in truth.as_array().unwrap() {
            let name = line[0].as_str().unwrap();
            let number = |i: usize| line[i].as_f64();
            let (Some(low), Some(high), Some(span)) = (number(1), number(2), number(3)) else {
                continue;
            };
            if number(4).is_none_or(|near| near > 1.0) {
                continue;
            }
            let said = described
                .iter()
                .filter_map(|t| number_in(t.strip_prefix(name)?.rsplit(':').next()?))
                .map(|said| (low - said).max(said - high))
                .fold(f64::INFINITY, f64::min);
            if said.is_finite() {
                assert!(
                    said < 0.01 * span,
                    "{name}: {said} off {low} to {high}; {described:?}"
                );
                checked += 1;
            }
        }
    }
    assert!(checked > 0, "no value was held against the drawing");
}

/// Focus, arrows, plus, minus, zero.
pub async fn keys_work(browser: &Browser) {
    if first_plot(browser).await.is_none() {
        return;
    }
    browser.eval("f.querySelector('.drawing').focus()").await;
    let read = "return [f.querySelector('output').textContent, f.querySelector('output').getAttribute('aria-live')]";
    browser.key("Escape").await;
    browser.key("ArrowRight").await;
    let first = browser.eval(read).await;
    assert_eq!(first[1], "polite");
    assert!(!first[0].as_str().unwrap().is_empty());
    for _ in 0..3 {
        browser.key("ArrowRight").await;
    }
    assert_ne!(first, browser.eval(read).await, "the cursor moves");
    let ticks = format!("return {TICKS}");
    let before = browser.eval(&ticks).await;
    browser.key("+").await;
    browser.key("+").await;
    assert_ne!(before, browser.eval(&ticks).await, "+ zooms");
    browser.key("-").await;
    browser.key("0").await;
    assert_eq!(before, browser.eval(&ticks).await, "0 shows all");
    browser.key("Escape").await;
    assert_eq!(browser.eval(read).await[0], "");
    let outlined = browser
        .eval("return getComputedStyle(document.activeElement).outlineStyle")
        .await;
    assert_ne!(outlined, "none", "the focus is seen");
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
