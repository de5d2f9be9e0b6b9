//! What a description starts from: files that other programs wrote.

use std::marker::PhantomData;

use indexmap::IndexMap;
#[cfg(feature = "cli")]
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use serde::{Deserialize, Serialize};

use super::absent;

raw! {
    /// A URDF and which chain of it is the robot. A plain text in its place is the file, the whole of which is read.
    pub struct RawUrdf {
        /// The file, relative to this one.
        file: Option<String>,
        /// The link that is frame 0; the one that hangs on no joint where absent.
        from: Option<String>,
        /// The link that carries the tool. Joints off the way to it move nothing and are held; only joints that move
        /// become frames. Where absent, every joint beyond `from` becomes a frame.
        to: Option<String>,
        /// Values at which joints are held, on the chain or off it, by joint. A joint off the chain that is not named is held at
        /// zero, or at the limit nearest to zero where that is outside its limits.
        fixed: IndexMap<String, f64>,
        /// As written with a saved description: `frames` below already hold what the file gave, and the file is opened
        /// only when a URDF is written, for its shapes, inertias, efforts and velocities.
        merged: bool,
    }
}

raw! {
    /// Kinematics of a robot as a driver reads them. A plain text in its place is the file.
    pub struct RawUrKinematics {
        /// The file, relative to this one. Absent in a saved description, whose `frames` hold what it gave.
        file: Option<String>,
        /// By what the driver identifies the robot: the file's `hash`.
        hash: Option<String>,
    }
}

/// What may be written as the name of its file alone.
pub(super) trait OfFile {
    fn of_file(file: String) -> Self;
}

impl OfFile for RawUrdf {
    fn of_file(file: String) -> Self {
        Self { file: Some(file), ..Self::default() }
    }
}

impl OfFile for RawUrKinematics {
    fn of_file(file: String) -> Self {
        Self { file: Some(file), ..Self::default() }
    }
}

/// The mapping, or the file's name alone.
pub(super) fn file_or_mapping<'de, T: OfFile + Deserialize<'de>, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<T>, D::Error> {
    struct TextOrMapping<T>(PhantomData<T>);

    impl<'de, T: OfFile + Deserialize<'de>> Visitor<'de> for TextOrMapping<T> {
        type Value = Option<T>;

        fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
            f.write_str("the name of a file, or a mapping with `file`")
        }

        fn visit_str<E: Error>(self, file: &str) -> Result<Self::Value, E> {
            Ok(Some(T::of_file(file.into())))
        }

        fn visit_unit<E: Error>(self) -> Result<Self::Value, E> {
            Ok(None)
        }

        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
            T::deserialize(MapAccessDeserializer::new(map)).map(Some)
        }
    }

    deserializer.deserialize_any(TextOrMapping(PhantomData))
}

#[cfg(feature = "cli")]
pub(super) fn file_or<T: JsonSchema>(generator: &mut SchemaGenerator) -> Schema {
    let mapping = generator.subschema_for::<T>();
    json_schema!({"anyOf": [{"type": ["string", "null"]}, mapping]})
}
