//! `texunit verify`.

use texunit_hw::FILTERS;

use crate::{good, texunit};

#[test]
fn chip_and_reference_agree_on_random_requests_of_every_filter() {
    let folder = tempfile::tempdir().unwrap();
    let json = good(&texunit(folder.path(), &["verify", "--no-scenes", "--random", "100", "--json"]));
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["mismatches"], 0);
    let filters = json["filters"].as_array().unwrap();
    assert_eq!(filters.len(), FILTERS.len());
    // Nine textures, four address modes, three roundings.
    assert!(filters.iter().all(|filter| filter["compared"] == 9 * 12 * 100), "{json}");
    let table = good(&texunit(folder.path(), &["verify", "--no-scenes", "--random", "10", "-f", "dipmap"]));
    assert!(table.contains("1080 samples compared") && table.contains("0 mismatches"), "{table}");
}
