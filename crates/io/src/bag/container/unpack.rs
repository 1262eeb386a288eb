//! Packed parts of recordings.

use std::io::{self, BufRead, Read};

/// What is unpacked.
type Unpacked<'a> = io::Result<Box<dyn Read + Send + 'a>>;

/// Zstandard.
#[cfg(feature = "compression")]
pub(in crate::bag) fn zstd<'a>(packed: impl BufRead + Send + 'a) -> Unpacked<'a> {
    Ok(Box::new(zstd::Decoder::with_buffer(packed)?))
}

/// LZ4 in frames.
#[cfg(feature = "compression")]
pub(in crate::bag) fn lz4<'a>(packed: impl Read + Send + 'a) -> Unpacked<'a> {
    Ok(Box::new(lz4::Decoder::new(packed)?))
}

/// bzip2.
#[cfg(feature = "compression")]
pub(in crate::bag) fn bz2<'a>(packed: impl BufRead + Send + 'a) -> Unpacked<'a> {
    Ok(Box::new(bzip2::bufread::MultiBzDecoder::new(packed)))
}

#[cfg(not(feature = "compression"))]
mod absent {
    use super::{BufRead, Read, Unpacked, io};

    fn absent<'a>() -> Unpacked<'a> {
        let reason = "this visloc was built without packed recordings; build with --features compression";
        Err(io::Error::new(io::ErrorKind::Unsupported, reason))
    }

    pub(in crate::bag) fn zstd<'a>(_: impl BufRead + Send + 'a) -> Unpacked<'a> {
        absent()
    }

    pub(in crate::bag) fn lz4<'a>(_: impl Read + Send + 'a) -> Unpacked<'a> {
        absent()
    }

    pub(in crate::bag) fn bz2<'a>(_: impl BufRead + Send + 'a) -> Unpacked<'a> {
        absent()
    }
}
#[cfg(not(feature = "compression"))]
pub(in crate::bag) use absent::{bz2, lz4, zstd};
