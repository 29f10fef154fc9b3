// SPDX-License-Identifier: Apache-2.0
// A run of bytes that readers address by offset, whether it lies in a file as it is or deflated inside a zip.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "io/disk_file.h"

namespace uwv::io {

class ByteStream {
 public:
  virtual ~ByteStream() = default;
  virtual std::uint64_t size() const = 0;
  /// Fills `out` from `offset` on; throws Error(file_damaged) when the bytes end before or cannot be decoded.
  virtual void read_at(std::uint64_t offset, std::span<std::byte> out) = 0;
};

/// `size` bytes of the file from `offset` on. The region must lie inside the file.
std::unique_ptr<ByteStream> open_region(std::shared_ptr<const InputFile> file, std::uint64_t offset,
                                        std::uint64_t size);

/// Raw deflate data: `stored_size` bytes of the file from `offset` on, which give `size` bytes. Reading forwards costs
/// what inflating costs; reading backwards starts over.
std::unique_ptr<ByteStream> open_deflated_region(std::shared_ptr<const InputFile> file, std::uint64_t offset,
                                                 std::uint64_t stored_size, std::uint64_t size);

/// Passes bytes through and compares their CRC-32 once they have been read from start to end; `what` names them.
std::unique_ptr<ByteStream> with_checksum(std::unique_ptr<ByteStream> stream, std::uint32_t crc32, std::string what);

}  // namespace uwv::io
