//! How a process is saved: as its plain data.

/// Implements `Serialize` and `Deserialize` of a process by a model, which `from_model` rebuilds it
/// from.
#[macro_export]
macro_rules! saved_as {
    ($process:ty => $model:ty, $to_model:expr) => {
        impl ::serde::Serialize for $process {
            fn serialize<S: ::serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                let to_model: fn(&$process) -> Result<$model, $crate::GpError> = $to_model;
                let model = to_model(self).map_err(::serde::ser::Error::custom)?;
                ::serde::Serialize::serialize(&model, serializer)
            }
        }

        impl<'de> ::serde::Deserialize<'de> for $process {
            fn deserialize<D: ::serde::Deserializer<'de>>(
                deserializer: D,
            ) -> Result<Self, D::Error> {
                let model = <$model as ::serde::Deserialize>::deserialize(deserializer)?;
                Self::from_model(&model).map_err(::serde::de::Error::custom)
            }
        }
    };
}
