// SPDX-License-Identifier: Apache-2.0
#include "io/disk_file.h"
#include "io/npy_header.h"
#include "uwv/core/error.h"

namespace uwv {

void write_npy(const std::string& path, DType type, const std::vector<std::size_t>& shape,
               std::span<const std::byte> bytes) {
  const NpyHeader header{type, ByteOrder::little, false, shape};
  require(bytes.size() == header.values() * size_of(type),
          "{}: {} bytes do not fill an array of shape ({}) and type {}", path, bytes.size(), fmt::join(shape, ", "),
          to_string(type));
  io::OutputFile file(path);
  file.append(io::format_npy_header(type, shape));
  file.append(bytes);
  file.commit();
}

}  // namespace uwv
