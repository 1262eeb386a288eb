//! Structs whose defaults stand beside their fields.

/// A struct with a default for each field, as RFC 3681 of Rust writes it: makes the struct and its `Default`.
///
/// ```
/// visloc_core::with_defaults! {
///     /// What a walk is like.
///     #[derive(Debug, Clone, PartialEq)]
///     pub struct Walk {
///         /// Meters a second.
///         pub speed: f64 = 0.2,
///         /// Seconds.
///         pub pauses: Vec<f64> = vec![1.0, 2.0],
///     }
/// }
/// assert_eq!(Walk::default(), Walk { speed: 0.2, pauses: vec![1.0, 2.0] });
/// ```
#[macro_export]
macro_rules! with_defaults {
    (
        $(#[$of_struct:meta])*
        $vis:vis struct $Struct:ident {
            $($(#[$of_field:meta])* $field_vis:vis $field:ident: $Type:ty = $value:expr,)*
        }
    ) => {
        $(#[$of_struct])*
        $vis struct $Struct { $($(#[$of_field])* $field_vis $field: $Type,)* }

        impl Default for $Struct {
            fn default() -> Self {
                Self { $($field: $value,)* }
            }
        }
    };
}
