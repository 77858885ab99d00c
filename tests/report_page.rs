//! The page, read by a real browser.
//!
//! Without Chromium installed (Debian: `apt-get install chromium`) the test says so and passes, unless `CHROMIUM=require` is
//! set, as in CI.

use std::{
    env, fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

fn texunit(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_texunit")).args(arguments).current_dir(folder).output().unwrap()
}

/// A page of everything the page can show.
fn page() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let sweep = "name = \"it's <small>\"\nscenes = [\"floor\"]\nsizes = [[32, 24]]\nfilters = [\"bilinear\", \"trilinear\"]\n\
                 set.cache.sets = [1, 4, 16]\nset.cache.ways = [1, 2]\nset.lod.bits = [4, 8]\n";
    fs::write(folder.path().join("s.toml"), sweep).unwrap();
    let filters = ["--size", "64x48", "-f", "bilinear,trilinear"];
    let commands: [&[&str]; 5] = [
        &["run", "floor", "magnified", "-o", "run"],
        &["pareto", "floor", "-o", "pareto"],
        &["reuse", "floor", "-o", "reuse"],
        &["frames", "walk", "-o", "frames"],
        &["sweep", "run", "s.toml", "-o", "sweep"],
    ];
    for (number, command) in commands.iter().enumerate() {
        let arguments = if number == 4 { command.to_vec() } else { [command, filters.as_slice()].concat() };
        let output = texunit(folder.path(), &arguments);
        assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    }
    let output = texunit(
        folder.path(),
        &["report", "run", "pareto", "reuse", "frames", "sweep", "-o", "page.html", "--title", "<Test> & more"],
    );
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let path = folder.path().join("page.html");
    (folder, path)
}

#[test]
fn the_page_needs_nothing_but_itself_and_a_browser_finds_every_figure() {
    let (folder, path) = page();
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains("&lt;Test&gt; &amp; more"));
    for foreign in ["src=\"http", "href=\"http", "src=\"/", "@import", "url(http"] {
        assert!(!text.contains(foreign), "the page asks for {foreign}");
    }
    let Some(chromium) = ["chromium", "chromium-browser", "google-chrome"]
        .iter()
        .flat_map(|name| {
            env::split_paths(&env::var_os("PATH").unwrap_or_default())
                .map(|folder| folder.join(name))
                .collect::<Vec<_>>()
        })
        .find(|path| path.is_file())
    else {
        assert_ne!(env::var("CHROMIUM").as_deref(), Ok("require"), "Chromium is not installed");
        eprintln!("SKIPPED: Chromium is not installed (apt-get install chromium)");
        return;
    };
    let output = Command::new(chromium)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run"])
        .args(["--enable-logging=stderr", "--virtual-time-budget=10000", "--window-size=400,800", "--dump-dom"])
        .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
        .arg(format!("file://{}", path.display()))
        .output()
        .unwrap();
    let messages = String::from_utf8_lossy(&output.stderr);
    let complaints: Vec<&str> = messages.lines().filter(|line| line.contains("CONSOLE")).collect();
    assert!(complaints.is_empty(), "{complaints:?}");
    let page = String::from_utf8_lossy(&output.stdout);
    let figures = text.matches("<figure").count();
    assert!(figures > 20, "{figures} figures");
    assert!(page.contains(&format!("data-figures=\"{figures} of {figures}\"")), "{}", &page[..page.len().min(400)]);
    assert!(page.contains("data-overflow=\"false\""), "the page is wider than a phone");
}

#[test]
fn folders_without_results_and_damaged_results_are_refused_and_no_page_is_left() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("empty")).unwrap();
    fs::create_dir(folder.path().join("damaged")).unwrap();
    fs::write(folder.path().join("damaged/report.json"), "{\"scenes\": [").unwrap();
    for (name, expected) in [("empty", "no results"), ("damaged", "report.json"), ("missing", "no results")] {
        let output = texunit(folder.path(), &["report", name, "-o", "page.html"]);
        assert_eq!(output.status.code(), Some(2));
        assert!(String::from_utf8_lossy(&output.stderr).contains(expected), "{name}");
        assert!(!folder.path().join("page.html").exists());
    }
}
