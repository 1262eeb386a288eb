//! `Debug` of types that hold what has none, or too much.

/// `Debug` that shows some fields of a type, behind its generic parameters in brackets.
///
/// ```
/// pub struct Walk<F> {
///     name: String,
///     next: F,
/// }
/// visloc_core::debug_shows!([F] Walk<F> { name });
/// assert_eq!(format!("{:?}", Walk { name: "tour".into(), next: || 1 }), r#"Walk { name: "tour", .. }"#);
/// # let walk = Walk { name: String::new(), next: || 1 };
/// # (walk.next)();
/// ```
#[macro_export]
macro_rules! debug_shows {
    ([$($of:tt)*] $Type:ident $(<$($with:tt),*>)? { $($field:ident),* $(,)? }) => {
        impl<$($of)*> ::std::fmt::Debug for $Type $(<$($with),*>)? {
            fn fmt(&self, f: &mut ::std::fmt::Formatter<'_>) -> ::std::fmt::Result {
                let mut shown = f.debug_struct(stringify!($Type));
                $(shown.field(stringify!($field), &self.$field);)*
                shown.finish_non_exhaustive()
            }
        }
    };
}
