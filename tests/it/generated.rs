//! Committed files that are generated must not be stale.

fn assert_fresh(file: &str, schema: schemars::Schema) {
    let path = format!("{}/schemas/{file}", env!("CARGO_MANIFEST_DIR"));
    let committed: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(path).expect("a file")).expect("JSON");
    let fresh = serde_json::to_value(schema).expect("JSON");
    assert_eq!(committed, fresh, "schemas/{file} is stale: cargo run -- schema ... --output schemas/{file}");
}

#[test]
fn schemas_are_fresh() {
    assert_fresh("robot.schema.json", schemars::schema_for!(elastogeo::description::raw::RawRobot));
    assert_fresh("process.schema.json", schemars::schema_for!(elastogeo::description::process::RawProcess));
    assert_fresh("rules.schema.json", schemars::schema_for!(elastogeo::description::raw::RawFuzzy));
    assert_fresh("campaign.schema.json", schemars::schema_for!(elastogeo::description::campaign::raw::RawCampaign));
}
