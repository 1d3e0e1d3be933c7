//! The adapters, one file an area.

mod figures;

use serde_json::Value;

type Adapter = fn(&str, &Value, &Value, &Value) -> Option<Result<Value, String>>;

pub const ADAPTERS: &[Adapter] = &[figures::run];
