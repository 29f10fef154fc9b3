// SPDX-License-Identifier: Apache-2.0
// The text in front of every NumPy array: {'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }.
#pragma once

#include <string>
#include <string_view>

#include "io/byte_stream.h"
#include "uwv/io/npy.h"

namespace uwv::io {

struct LocatedNpyHeader {
  NpyHeader header;
  std::uint64_t data_offset = 0;  ///< Where the values start.
};

/// Reads and checks the header at the start of the stream; afterwards the values are known to lie inside the stream.
/// `where` begins the sentences of errors.
LocatedNpyHeader read_npy_header(ByteStream& stream, const std::string& where);

/// A version 1 header, padded with spaces to a multiple of 64 bytes and at least `min_bytes`.
std::string format_npy_header(DType type, const std::vector<std::size_t>& shape, std::size_t min_bytes = 0);

}  // namespace uwv::io
