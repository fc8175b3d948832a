//! The same logs as other tools may write them: chunks, compressions, filters, without check sums.

use std::io::{Cursor, Write};

use anyhow::{Context, Result};
use mcap::{Compression, MessageStream, WriteOptions};

/// An MCAP file in every container, without the check sums that would hide damage behind them.
pub(super) fn mcap_files(file: &[u8]) -> Result<Vec<Vec<u8>>> {
    let bare = || {
        WriteOptions::new()
            .calculate_chunk_crcs(false)
            .calculate_data_section_crc(false)
            .calculate_summary_section_crc(false)
            .compression(None)
    };
    let options = [
        bare(),
        bare().chunk_size(Some(256)),
        bare().compression(Some(Compression::Zstd)),
        bare().compression(Some(Compression::Lz4)),
        bare().use_chunks(false),
        bare().emit_summary_records(false).emit_summary_offsets(false),
        bare().emit_message_indexes(false).repeat_schemas(false),
    ];
    let mut files = vec![file.to_vec()];
    for option in options {
        let mut bytes = Vec::new();
        let mut writer = option.create(Cursor::new(&mut bytes))?;
        for message in MessageStream::new(file)? {
            writer.write(&message?)?;
        }
        writer.finish()?;
        drop(writer);
        files.push(bytes);
    }
    Ok(files)
}

/// A bag whose one chunk is compressed by bzip2, and the same with the other compressions.
pub(super) fn bags(file: &[u8]) -> Result<Vec<Vec<u8>>> {
    let find = |word: &[u8]| file.windows(word.len()).position(|window| window == word);
    let name = b"compression=";
    let name_at = find(name).context("the bag has no chunk")?;
    let length = |at: usize| -> Result<usize> {
        let bytes = file.get(at..at + 4).context("the bag is short")?;
        Ok(u32::from_le_bytes(bytes.try_into()?) as usize)
    };
    // The chunk's record begins where its header's length stands: behind the bag's own header.
    let start = b"#ROSBAG V2.0\n".len() + 4096;
    let header_end = start + 4 + length(start)?;
    let data = header_end + 4..header_end + 4 + length(header_end)?;
    let mut chunk = Vec::new();
    bzip2::write::BzDecoder::new(&mut chunk).write_all(&file[data.clone()])?;
    let mut lz4 = lz4::EncoderBuilder::new().build(Vec::new())?;
    lz4.write_all(&chunk)?;
    let (lz4, result) = lz4.finish();
    result?;
    let value = name_at + name.len();
    let with = |compression: &[u8], packed: &[u8]| {
        let mut header = file[start + 4..header_end].to_vec();
        let at = value - start - 4;
        header.splice(at..at + 3, compression.iter().copied());
        // The field's own length stands before its name.
        let field = ((name.len() + compression.len()) as u32).to_le_bytes();
        header[at - name.len() - 4..at - name.len()].copy_from_slice(&field);
        let length = |bytes: &[u8]| (bytes.len() as u32).to_le_bytes();
        [&file[..start], &length(&header), &header, &length(packed), packed, &file[data.end..]]
            .concat()
    };
    Ok(vec![file.to_vec(), with(b"none", &chunk), with(b"lz4", &lz4)])
}

/// An HDF5 file, and the same rows in chunks with filters.
pub(super) fn hdf5_files(file: Vec<u8>) -> Result<Vec<Vec<u8>>> {
    let rows: Vec<f64> = (0..24).map(f64::from).collect();
    let mut files = vec![file];
    for filter in 0..4 {
        let mut builder = hdf5_pure::FileBuilder::new();
        for name in ["tip_pose", "object_pose", "ft_wrench"] {
            let set = builder.create_dataset(name);
            set.with_f64_data(&rows).with_shape(&[6, 4]).with_chunks(&[4, 4]);
            match filter {
                0 => {}
                1 => {
                    set.with_deflate(6);
                }
                2 => {
                    set.with_shuffle().with_deflate(6);
                }
                _ => {
                    set.with_fletcher32();
                }
            }
        }
        files.push(builder.finish().map_err(|error| anyhow::anyhow!("{error}"))?);
    }
    Ok(files)
}
