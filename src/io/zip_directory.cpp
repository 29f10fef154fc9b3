// SPDX-License-Identifier: Apache-2.0
#include "io/zip_directory.h"

#include <algorithm>
#include <set>

#include "io/little_endian.h"
#include "uwv/core/error.h"

namespace uwv::io {
namespace {

constexpr std::uint32_t end_signature = 0x06054b50, end64_signature = 0x06064b50, locator64_signature = 0x07064b50;
constexpr std::uint32_t entry_signature = 0x02014b50, local_signature = 0x04034b50;
constexpr std::uint64_t end_bytes = 22, end64_bytes = 56, locator64_bytes = 20, entry_bytes = 46, local_bytes = 30;
constexpr std::uint64_t max_comment_bytes = 65535;
constexpr std::uint64_t max_directory_bytes = 1U << 26;
constexpr std::uint32_t in_zip64_field = 0xFFFFFFFF;

using Bytes = std::vector<std::byte>;

struct DirectoryPlace {
  std::uint64_t offset = 0, size = 0;
};

Bytes read_bytes(const InputFile& file, std::uint64_t offset, std::uint64_t size) {
  if (offset > file.size() || size > file.size() - offset)
    fail(ErrorCode::file_damaged, "{}: a zip record of {} bytes at {} is outside the file's {} bytes", file.path(),
         size, offset, file.size());
  Bytes bytes(static_cast<std::size_t>(size));
  file.read_at(offset, bytes);
  return bytes;
}

/// Offset of the end record: the last place whose signature fits and whose comment reaches exactly to the file's end.
std::uint64_t find_end_record(const InputFile& file) {
  const std::uint64_t tail_bytes = std::min(file.size(), end_bytes + max_comment_bytes);
  const Bytes tail = read_bytes(file, file.size() - tail_bytes, tail_bytes);
  for (std::uint64_t at = tail_bytes < end_bytes ? 0 : tail_bytes - end_bytes + 1; at-- > 0;)
    if (load_little<std::uint32_t>(tail, at) == end_signature &&
        load_little<std::uint16_t>(tail, at + 20) == tail_bytes - at - end_bytes)
      return file.size() - tail_bytes + at;
  fail(ErrorCode::file_damaged, "{}: the zip directory at its end is missing; the file was cut short or is no zip",
       file.path());
}

DirectoryPlace find_directory(const InputFile& file) {
  const std::uint64_t end_at = find_end_record(file);
  const Bytes end = read_bytes(file, end_at, end_bytes);
  DirectoryPlace place{load_little<std::uint32_t>(end, 16), load_little<std::uint32_t>(end, 12)};
  if (end_at >= locator64_bytes) {
    const Bytes locator = read_bytes(file, end_at - locator64_bytes, locator64_bytes);
    if (load_little<std::uint32_t>(locator, 0) == locator64_signature) {
      const Bytes end64 = read_bytes(file, load_little<std::uint64_t>(locator, 8), end64_bytes);
      if (load_little<std::uint32_t>(end64, 0) != end64_signature)
        fail(ErrorCode::file_damaged, "{}: its zip64 end record is not where it should be", file.path());
      place = {load_little<std::uint64_t>(end64, 48), load_little<std::uint64_t>(end64, 40)};
    }
  }
  if (place.size > max_directory_bytes)
    fail(ErrorCode::file_damaged, "{}: a zip directory of {} bytes is absurd", file.path(), place.size);
  return place;
}

/// Replaces the sizes that did not fit 32 bits by those of the zip64 extra field, which holds only these, in order.
void apply_zip64(std::span<const std::byte> extra, ZipMember& member, const std::string& path) {
  constexpr std::uint16_t zip64_id = 1;
  while (extra.size() >= 4) {
    const auto id = load_little<std::uint16_t>(extra, 0);
    const std::size_t length = load_little<std::uint16_t>(extra, 2);
    extra = extra.subspan(4);
    if (length > extra.size()) break;
    if (id == zip64_id) {
      std::size_t at = 0;
      for (std::uint64_t* value : {&member.size, &member.stored_size, &member.header_offset}) {
        if (*value != in_zip64_field) continue;
        if (at + 8 > length)
          fail(ErrorCode::file_damaged, "{}: the zip64 field of '{}' is too short", path, member.name);
        *value = load_little<std::uint64_t>(extra, at);
        at += 8;
      }
      return;
    }
    extra = extra.subspan(length);
  }
}

}  // namespace

std::vector<ZipMember> read_zip_directory(const InputFile& file) {
  const DirectoryPlace place = find_directory(file);
  const Bytes directory = read_bytes(file, place.offset, place.size);
  std::vector<ZipMember> members;
  std::set<std::string> names;
  for (std::size_t at = 0; at < directory.size();) {
    const auto rest = std::span(directory).subspan(at);
    if (rest.size() < entry_bytes || load_little<std::uint32_t>(rest, 0) != entry_signature)
      fail(ErrorCode::file_damaged, "{}: its zip directory is broken at entry {}", file.path(), members.size());
    const std::size_t name_length = load_little<std::uint16_t>(rest, 28);
    const std::size_t extra_length = load_little<std::uint16_t>(rest, 30);
    const std::size_t length = entry_bytes + name_length + extra_length + load_little<std::uint16_t>(rest, 32);
    if (length > rest.size())
      fail(ErrorCode::file_damaged, "{}: its zip directory is broken at entry {}", file.path(), members.size());

    ZipMember member;
    member.name.assign(reinterpret_cast<const char*>(rest.data()) + entry_bytes, name_length);
    member.method = load_little<std::uint16_t>(rest, 10);
    member.crc32 = load_little<std::uint32_t>(rest, 16);
    member.stored_size = load_little<std::uint32_t>(rest, 20);
    member.size = load_little<std::uint32_t>(rest, 24);
    member.header_offset = load_little<std::uint32_t>(rest, 42);
    apply_zip64(rest.subspan(entry_bytes + name_length, extra_length), member, file.path());
    if ((load_little<std::uint16_t>(rest, 8) & 1U) != 0)
      fail(ErrorCode::format_unknown, "{}: its member '{}' is encrypted", file.path(), member.name);
    if (!names.insert(member.name).second)
      fail(ErrorCode::file_damaged, "{}: has two members named '{}'", file.path(), member.name);
    members.push_back(std::move(member));
    at += length;
  }
  return members;
}

std::unique_ptr<ByteStream> open_zip_member(std::shared_ptr<const InputFile> file, const ZipMember& member) {
  const std::string what = fmt::format("{}: its member '{}'", file->path(), member.name);
  const Bytes local = read_bytes(*file, member.header_offset, local_bytes);
  if (load_little<std::uint32_t>(local, 0) != local_signature)
    fail(ErrorCode::file_damaged, "{} is not where the zip directory says", what);
  // The local name and extra field may differ in length from those of the directory.
  const std::uint64_t data_offset = member.header_offset + local_bytes + load_little<std::uint16_t>(local, 26) +
                                    load_little<std::uint16_t>(local, 28);
  if (data_offset > file->size() || member.stored_size > file->size() - data_offset)
    fail(ErrorCode::file_damaged, "{} claims {} bytes at {} in a file of {}", what, member.stored_size, data_offset,
         file->size());

  std::unique_ptr<ByteStream> stream;
  if (member.method == static_cast<std::uint16_t>(ZipMethod::stored)) {
    if (member.size != member.stored_size)
      fail(ErrorCode::file_damaged, "{} is stored as it is, yet claims {} bytes in {}", what, member.size,
           member.stored_size);
    stream = open_region(file, data_offset, member.size);
  } else if (member.method == static_cast<std::uint16_t>(ZipMethod::deflated)) {
    constexpr std::uint64_t best_deflate_ratio = 1032;  // two bits for a match of 258 bytes
    if (member.size / best_deflate_ratio > member.stored_size)
      fail(ErrorCode::file_damaged, "{} claims {} bytes from {}, which deflate cannot reach", what, member.size,
           member.stored_size);
    stream = open_deflated_region(file, data_offset, member.stored_size, member.size);
  } else {
    fail(ErrorCode::format_unknown, "{} uses compression method {}; save it stored or deflated", what, member.method);
  }
  return with_checksum(std::move(stream), member.crc32, what);
}

}  // namespace uwv::io
