//! What is read of a model file before a runtime sees it: its metadata, its operators, and whether
//! its weights lie elsewhere.
//!
//! An ONNX file is one message of protocol buffers (<https://protobuf.dev/programming-guides/encoding>):
//! fields of a number, a wire type and content, messages nested as runs of bytes. Walking it takes a
//! few lines; the numbers are those of `onnx.proto` (ONNX 1.18, Apache-2.0).

/// Why a file is not read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ProtoError {
    /// It is no message.
    #[error("not an ONNX model")]
    NotOnnx,
    /// It says a part of it lies in another file.
    #[error("its weights lie in another file; they must be in the model itself")]
    External,
    /// It has an operator that no segmenter needs.
    #[error(
        "it uses the operator {0}, which a segmenter may not: its work would depend on the picture"
    )]
    Operator(String),
}

/// Operators that repeat or skip work, or give something else each time. Without them a model of fixed
/// size does the same work for every picture, so that one trial tells whether it ends.
const REFUSED: [&str; 9] = [
    "Loop",
    "Scan",
    "If",
    "SequenceMap",
    "RandomNormal",
    "RandomNormalLike",
    "RandomUniform",
    "RandomUniformLike",
    "Multinomial",
];

/// The field numbers that are looked at, as `message_field`.
const MODEL_GRAPH: u64 = 7;
const MODEL_METADATA: u64 = 14;
const MODEL_FUNCTION: u64 = 25;
const FUNCTION_NODE: u64 = 7;
const GRAPH_NODE: u64 = 1;
const GRAPH_INITIALIZER: u64 = 5;
const NODE_OPERATOR: u64 = 4;
const NODE_ATTRIBUTE: u64 = 5;
const ATTRIBUTE_TENSOR: u64 = 5;
const TENSOR_EXTERNAL: u64 = 13;
const ENTRY_KEY: u64 = 1;
const ENTRY_VALUE: u64 = 2;

/// What the model's metadata says under `key`, once the file has been looked through.
///
/// # Errors
/// [`ProtoError`].
pub(super) fn metadata<'a>(model: &'a [u8], key: &str) -> Result<Option<&'a [u8]>, ProtoError> {
    let mut found = None;
    let mut has_graph = false;
    for field in fields(model) {
        match field? {
            (MODEL_GRAPH, Content::Bytes(graph)) => {
                has_graph = true;
                check_graph(graph)?;
            }
            (MODEL_FUNCTION, Content::Bytes(function)) => {
                each(function, FUNCTION_NODE, check_node)?;
            }
            (MODEL_METADATA, Content::Bytes(entry))
                if bytes_of(entry, ENTRY_KEY)? == Some(key.as_bytes()) =>
            {
                found = bytes_of(entry, ENTRY_VALUE)?;
            }
            _ => {}
        }
    }
    if has_graph {
        Ok(found)
    } else {
        Err(ProtoError::NotOnnx)
    }
}

fn check_graph(graph: &[u8]) -> Result<(), ProtoError> {
    each(graph, GRAPH_NODE, check_node)?;
    each(graph, GRAPH_INITIALIZER, check_tensor)
}

fn check_node(node: &[u8]) -> Result<(), ProtoError> {
    let operator = bytes_of(node, NODE_OPERATOR)?.unwrap_or_default();
    let refused = |name: &&&str| name.as_bytes() == operator;
    if let Some(name) = REFUSED.iter().find(refused) {
        return Err(ProtoError::Operator((*name).to_owned()));
    }
    each(node, NODE_ATTRIBUTE, |attribute| {
        each(attribute, ATTRIBUTE_TENSOR, check_tensor)
    })
}

fn check_tensor(tensor: &[u8]) -> Result<(), ProtoError> {
    match bytes_of(tensor, TENSOR_EXTERNAL)? {
        Some(_) => Err(ProtoError::External),
        None => Ok(()),
    }
}

/// Does `check` for each of the fields `number` of `message` that hold bytes.
fn each(
    message: &[u8],
    number: u64,
    check: impl Fn(&[u8]) -> Result<(), ProtoError>,
) -> Result<(), ProtoError> {
    for field in fields(message) {
        match field? {
            (own, Content::Bytes(bytes)) if own == number => check(bytes)?,
            _ => {}
        }
    }
    Ok(())
}

/// The last of the fields `number` of `message` that hold bytes.
fn bytes_of(message: &[u8], number: u64) -> Result<Option<&[u8]>, ProtoError> {
    let mut found = None;
    for field in fields(message) {
        match field? {
            (own, Content::Bytes(bytes)) if own == number => found = Some(bytes),
            _ => {}
        }
    }
    Ok(found)
}

/// What a field holds.
enum Content<'a> {
    Bytes(&'a [u8]),
    /// A number, which nothing here asks for.
    Number,
}

/// The fields of a message, in their order; an error ends them.
fn fields(message: &[u8]) -> impl Iterator<Item = Result<(u64, Content<'_>), ProtoError>> {
    let mut rest = message;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let field = next_field(&mut rest);
        if field.is_none() {
            rest = &[];
        }
        Some(field.ok_or(ProtoError::NotOnnx))
    })
}

fn next_field<'a>(rest: &mut &'a [u8]) -> Option<(u64, Content<'a>)> {
    let tag = varint(rest)?;
    let content = match tag & 7 {
        0 => varint(rest).map(|_| Content::Number)?,
        1 => taken(rest, 8).map(|_| Content::Number)?,
        5 => taken(rest, 4).map(|_| Content::Number)?,
        2 => {
            let length = usize::try_from(varint(rest)?).ok()?;
            Content::Bytes(taken(rest, length)?)
        }
        _ => return None,
    };
    Some((tag >> 3, content)).filter(|(number, _)| *number > 0)
}

/// The next `count` bytes, taken off `rest`.
fn taken<'a>(rest: &mut &'a [u8], count: usize) -> Option<&'a [u8]> {
    let (bytes, after) = rest.split_at_checked(count)?;
    *rest = after;
    Some(bytes)
}

/// A number of seven bits a byte, the lowest first.
fn varint(rest: &mut &[u8]) -> Option<u64> {
    let mut value = 0;
    for shift in (0..64).step_by(7) {
        let (&byte, after) = rest.split_first()?;
        *rest = after;
        value |= u64::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            return Some(value);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn message(number: u8, content: &[u8]) -> Vec<u8> {
        let mut bytes = vec![number << 3 | 2, content.len() as u8];
        bytes.extend(content);
        bytes
    }

    fn model(node: &[u8], rest: &[u8]) -> Vec<u8> {
        let mut bytes = vec![8, 10];
        bytes.extend(message(7, &message(1, node)));
        bytes.extend(rest);
        bytes
    }

    #[test]
    fn metadata_is_found_by_its_key() {
        let entry = |key: &[u8], value: &[u8]| {
            let pair = [message(1, key), message(2, value)].concat();
            message(14, &pair)
        };
        let entries = [entry(b"author", b"me"), entry(b"boscage", b"{}")].concat();
        let model = model(&message(4, b"Conv"), &entries);
        assert_eq!(metadata(&model, "boscage"), Ok(Some(&b"{}"[..])));
        assert_eq!(metadata(&model, "other"), Ok(None));
    }

    #[test]
    fn loops_chance_and_files_elsewhere_are_refused() {
        let looping = model(&message(4, b"Loop"), &[]);
        let error = metadata(&looping, "boscage").unwrap_err();
        assert!(error.to_string().contains("Loop"), "{error}");
        let tensor = message(13, &[message(1, b"location"), message(2, b"/x")].concat());
        let graph = message(7, &message(5, &tensor));
        assert_eq!(metadata(&graph, "boscage"), Err(ProtoError::External));
    }

    #[test]
    fn what_is_no_model_is_refused() {
        for bytes in [
            &b""[..],
            b"\x89PNG\r\n\x1a\n",
            b"version https://git-lfs",
            &[0xff; 40],
        ] {
            assert_eq!(metadata(bytes, "boscage"), Err(ProtoError::NotOnnx));
        }
        let whole = model(&message(4, b"Conv"), &[]);
        assert_eq!(
            metadata(&whole[..whole.len() - 1], "boscage"),
            Err(ProtoError::NotOnnx)
        );
    }

    proptest! {
        #[test]
        fn any_bytes_are_read_without_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            let _ = metadata(&bytes, "boscage");
        }
    }
}
