//! Keys that may be written in several forms: as a text, a number, a list or a mapping.

/// Reads a type of what is expected, in words, and what each form makes of it: `text name => ..`, `number value => ..`,
/// `list all: Vec<..> => ..`, `map own: Own => ..`. What is wrong within a list or a mapping is said of its own key.
macro_rules! forms {
    (
        $of:ty: $expected:literal
        $(, text $text:ident => $of_text:expr)?
        $(, number $number:ident => $of_number:expr)?
        $(, list $list:ident: $list_type:ty => $of_list:expr)?
        $(, map $map:ident: $map_type:ty => $of_map:expr)?
    ) => {
        impl<'de> serde::Deserialize<'de> for $of {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                struct Form;
                impl<'de> serde::de::Visitor<'de> for Form {
                    type Value = $of;
                    fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                        f.write_str($expected)
                    }
                    $(fn visit_str<E: serde::de::Error>(self, $text: &str) -> Result<$of, E> {
                        Ok($of_text)
                    })?
                    $(fn visit_f64<E: serde::de::Error>(self, $number: f64) -> Result<$of, E> {
                        Ok($of_number)
                    }
                    fn visit_i64<E: serde::de::Error>(self, $number: i64) -> Result<$of, E> {
                        self.visit_f64($number as f64)
                    }
                    fn visit_u64<E: serde::de::Error>(self, $number: u64) -> Result<$of, E> {
                        self.visit_f64($number as f64)
                    })?
                    $(fn visit_seq<A: serde::de::SeqAccess<'de>>(self, seq: A) -> Result<$of, A::Error> {
                        let seq = serde::de::value::SeqAccessDeserializer::new(seq);
                        <$list_type as serde::Deserialize>::deserialize(seq).map(|$list| $of_list)
                    })?
                    $(fn visit_map<A: serde::de::MapAccess<'de>>(self, map: A) -> Result<$of, A::Error> {
                        let map = serde::de::value::MapAccessDeserializer::new(map);
                        <$map_type as serde::Deserialize>::deserialize(map).map(|$map| $of_map)
                    })?
                }
                deserializer.deserialize_any(Form)
            }
        }
    };
}

pub(super) use forms;
