// SPDX-License-Identifier: Apache-2.0
// The table of contents of a zip file (zip64 included) and the streams of its members.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "io/byte_stream.h"
#include "io/disk_file.h"

namespace uwv::io {

enum class ZipMethod : std::uint16_t { stored = 0, deflated = 8 };

struct ZipMember {
  std::string name;
  std::uint16_t method = 0;
  std::uint32_t crc32 = 0;
  std::uint64_t stored_size = 0;  ///< Bytes in the zip.
  std::uint64_t size = 0;         ///< Bytes when unpacked.
  std::uint64_t header_offset = 0;
};

/// All members in directory order. Throws Error(file_damaged), also for two members of one name.
std::vector<ZipMember> read_zip_directory(const InputFile& file);

/// Throws Error(format_unknown) for other methods than stored and deflated, Error(file_damaged) when the member's
/// sizes cannot be true.
std::unique_ptr<ByteStream> open_zip_member(std::shared_ptr<const InputFile> file, const ZipMember& member);

}  // namespace uwv::io
