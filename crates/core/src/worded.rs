//! Plain enums and their words in one table.

/// An enum without data in which each variant has a word: makes the enum, `ALL` in the order of the table, and the function of the words.
///
/// ```
/// visloc_core::worded_enum! {
///     /// What a robot sees.
///     #[derive(Debug, Clone, Copy, PartialEq, Eq)]
///     pub enum Thing {
///         /// Something round.
///         Ball = "ball",
///         /// Something in the way.
///         Robot = "another robot",
///     }
///
///     /// For people.
///     name
/// }
/// assert_eq!(Thing::ALL.map(Thing::name), ["ball", "another robot"]);
/// ```
#[macro_export]
macro_rules! worded_enum {
    (
        $(#[$of_enum:meta])*
        $vis:vis enum $Enum:ident { $($(#[$of_variant:meta])* $Variant:ident = $word:literal,)* }
        $(#[$of_words:meta])*
        $word_of:ident
    ) => {
        $(#[$of_enum])*
        $vis enum $Enum { $($(#[$of_variant])* $Variant,)* }

        impl $Enum {
            /// All, in their order.
            $vis const ALL: [Self; [$($word),*].len()] = [$(Self::$Variant),*];

            $(#[$of_words])*
            $vis const fn $word_of(self) -> &'static str {
                match self { $(Self::$Variant => $word,)* }
            }
        }
    };
}
