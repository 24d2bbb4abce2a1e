//! Chromium behind chromedriver.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use serde_json::{Value, json};
use thirtyfour::{CapabilitiesHelper, DesiredCapabilities, WebDriver};

use crate::pages::Page;

pub struct Browser {
    driver: WebDriver,
    service: Child,
    pictures: Option<PathBuf>,
}

/// Ends the service whatever happens to the test.
impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.service.kill();
        let _ = self.service.wait();
    }
}

impl Browser {
    /// Starts chromedriver on a free port, and a browser with a profile in
    /// `folder`.
    pub async fn start(folder: &Path, pictures: Option<PathBuf>) -> Self {
        let mut service = Command::new("chromedriver")
            .arg("--port=0")
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("chromedriver is not there; chromium is needed, too");
        let out = service.stdout.take().unwrap();
        let port = BufReader::new(out)
            .lines()
            .map_while(Result::ok)
            .find_map(|line| {
                let (_, port) = line.split_once("successfully on port ")?;
                Some(port.trim_end_matches('.').to_owned())
            })
            .expect("chromedriver did not say its port");
        let profile = format!("--user-data-dir={}", folder.join("profile").display());
        let mut wanted = DesiredCapabilities::chrome();
        let options = json!({
            "args": ["--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
                     "--disable-dev-shm-usage", "--no-first-run", profile],
            "perfLoggingPrefs": { "enableNetwork": true },
        });
        wanted.set("goog:chromeOptions", options).unwrap();
        let logs = json!({ "browser": "ALL", "performance": "ALL" });
        wanted.set("goog:loggingPrefs", logs).unwrap();
        let driver = WebDriver::new(format!("http://127.0.0.1:{port}"), wanted)
            .await
            .expect("chromium does not start");
        Browser {
            driver,
            service,
            pictures,
        }
    }

    pub async fn stop(&self) {
        self.driver.clone().quit().await.unwrap();
    }

    /// Width and height of the page's window.
    pub async fn size(&self, width: u32, height: u32) {
        let size =
            json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.cdp("Emulation.setDeviceMetricsOverride", size).await;
        self.settle().await;
    }

    pub async fn scheme(&self, name: &str) {
        let feature = json!({ "features": [{ "name": "prefers-color-scheme", "value": name }] });
        self.cdp("Emulation.setEmulatedMedia", feature).await;
        self.settle().await;
    }

    pub async fn open(&self, path: &Path) {
        // What was logged before is another page's.
        self.logs("browser").await;
        self.logs("performance").await;
        self.scheme("light").await;
        let url = format!("file://{}", path.display());
        self.driver.goto(url).await.unwrap();
        self.settle().await;
    }

    /// Until what was asked for has been laid out and drawn.
    pub async fn settle(&self) {
        let script = "const done = arguments[arguments.length - 1];
            requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(() => done(1))));";
        self.driver.execute_async(script, Vec::new()).await.unwrap();
    }

    /// The value of a script.
    pub async fn eval(&self, script: &str) -> Value {
        let result = self.driver.execute(script, Vec::new()).await;
        result
            .unwrap_or_else(|e| panic!("{e}\n{script}"))
            .json()
            .clone()
    }

    pub async fn cdp(&self, method: &str, parameters: Value) -> Value {
        self.driver
            .cdp()
            .send_raw(method, parameters)
            .await
            .unwrap_or_else(|e| panic!("{method}: {e}"))
    }

    /// A mouse event at a place of the window.
    pub async fn mouse(&self, kind: &str, x: f64, y: f64, more: Value) {
        let mut event = json!({ "type": kind, "x": x, "y": y });
        if let (Some(event), Some(more)) = (event.as_object_mut(), more.as_object()) {
            event.extend(more.clone());
        }
        self.cdp("Input.dispatchMouseEvent", event).await;
    }

    pub async fn pdf(&self) -> Vec<u8> {
        self.driver.print_page(Default::default()).await.unwrap()
    }

    async fn logs(&self, kind: &str) -> Vec<thirtyfour::BrowserLogEntry> {
        self.driver.get_log(kind).await.unwrap()
    }

    /// Nothing was complained of, and nothing but the page was asked for.
    pub async fn quiet(&self, page: &Page) {
        let loud: Vec<_> = self
            .logs("browser")
            .await
            .into_iter()
            .filter(|e| matches!(e.level.as_str(), "WARNING" | "SEVERE" | "ERROR"))
            .collect();
        assert!(loud.is_empty(), "{}: {loud:?}", page.name);
        let mut asked = 0;
        for entry in self.logs("performance").await {
            let event: Value = serde_json::from_str(&entry.message).unwrap();
            let event = &event["message"];
            if event["method"] != "Network.requestWillBeSent" {
                continue;
            }
            let url = event["params"]["request"]["url"].as_str().unwrap();
            // The browser's own start page may still be loading; a page in a file cannot
            // ask for its parts.
            if url.starts_with("data:") || url.starts_with("chrome") {
                continue;
            }
            assert!(url.starts_with("file://"), "{}: {url}", page.name);
            assert!(url.contains(&page.name), "{}: {url}", page.name);
            asked += 1;
        }
        assert!(asked > 0, "{}: nothing was logged", page.name);
    }

    /// A picture of the whole page, where pictures are wanted.
    pub async fn shoot(&self, page: &Page, how: &str) {
        let Some(folder) = &self.pictures else {
            return;
        };
        std::fs::create_dir_all(folder).unwrap();
        let size = self
            .eval("return [innerWidth, document.documentElement.scrollHeight, innerHeight]")
            .await;
        let number = |i: usize| size[i].as_u64().unwrap() as u32;
        self.size(number(0), number(1).min(16_000)).await;
        let path = folder.join(format!("{}-{how}.png", page.name));
        self.driver.screenshot(&path).await.unwrap();
        self.size(number(0), number(2)).await;
    }
}
