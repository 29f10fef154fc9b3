// SPDX-License-Identifier: Apache-2.0
#include <zlib.h>

#include <algorithm>
#include <array>
#include <optional>
#include <set>

#include "io/disk_file.h"
#include "io/little_endian.h"
#include "io/npy_header.h"
#include "io/zip_directory.h"
#include "uwv/core/error.h"

namespace uwv {
namespace {

using io::append_little;

// Room for any first dimension, so that the header can be rewritten in place once it is known.
constexpr std::size_t header_bytes = 128;
constexpr std::uint32_t in_zip64_field = 0xFFFFFFFF;
constexpr int version_needed = 45;      // zip64
constexpr int epoch_date = 1 << 5 | 1;  // 1 January 1980: the same input gives the same bytes

std::uint32_t checksum(std::uint32_t start, std::span<const std::byte> bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(start, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<z_size_t>(bytes.size())));
}

/// A raw deflate stream into a file.
class Deflater {
 public:
  Deflater(io::OutputFile& file, int level) : file_(file) {
    constexpr int raw_deflate = -MAX_WBITS, default_memory = 8;
    if (deflateInit2(&stream_, level, Z_DEFLATED, raw_deflate, default_memory, Z_DEFAULT_STRATEGY) != Z_OK)
      fail(ErrorCode::out_of_memory, "{}: no memory for compression", file.path());
  }
  ~Deflater() { deflateEnd(&stream_); }
  Deflater(const Deflater&) = delete;
  Deflater& operator=(const Deflater&) = delete;

  void append(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      const auto part = bytes.first(std::min<std::size_t>(bytes.size(), 1U << 30));  // zlib counts in unsigned int
      stream_.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(part.data()));
      stream_.avail_in = static_cast<uInt>(part.size());
      run(Z_NO_FLUSH);
      bytes = bytes.subspan(part.size());
    }
  }
  void end() { run(Z_FINISH); }

 private:
  void run(int flush) {
    do {
      stream_.next_out = reinterpret_cast<Bytef*>(output_.data());
      stream_.avail_out = static_cast<uInt>(output_.size());
      deflate(&stream_, flush);
      file_.append(std::span(output_).first(output_.size() - stream_.avail_out));
    } while (stream_.avail_out == 0);
  }

  io::OutputFile& file_;
  z_stream stream_{};
  std::array<std::byte, 1U << 16> output_{};
};

/// A member being written, or done.
struct Member {
  io::ZipMember entry;
  DType type = DType::f32;
  std::vector<std::size_t> shape;  ///< The first dimension counts up while slices come in.
  std::size_t slice_bytes = 0;
  std::uint64_t data_offset = 0;    ///< Of the packed bytes in the file.
  std::uint64_t header_offset = 0;  ///< Of the array header in the file.
  std::uint64_t value_bytes = 0;    ///< Appended so far.
  std::uint32_t values_crc32 = 0;
};

}  // namespace

struct NpzWriter::State {
  explicit State(const std::string& path) : file(path) {}

  io::OutputFile file;
  std::vector<Member> members;
  std::set<std::string> names;
  std::optional<Deflater> deflater;
  bool open = false;

  bool deflated(const Member& member) const {
    return member.entry.method == static_cast<std::uint16_t>(io::ZipMethod::deflated);
  }

  /// The local record always carries a zip64 field: sizes are not known yet, and 4 GiB must fit.
  std::string local_record(const io::ZipMember& entry) const {
    std::string record;
    append_little(record, 0x04034b50, 4);
    append_little(record, version_needed, 2);
    append_little(record, 0, 2);  // flags
    append_little(record, entry.method, 2);
    append_little(record, 0, 2);  // time
    append_little(record, epoch_date, 2);
    append_little(record, entry.crc32, 4);
    append_little(record, in_zip64_field, 4);
    append_little(record, in_zip64_field, 4);
    append_little(record, entry.name.size(), 2);
    append_little(record, 20, 2);
    record += entry.name;
    append_little(record, 1, 2);
    append_little(record, 16, 2);
    append_little(record, entry.size, 8);
    append_little(record, entry.stored_size, 8);
    return record;
  }

  std::string directory_record(const io::ZipMember& entry) const {
    std::string zip64;
    const auto narrow = [&](std::uint64_t value) -> std::uint64_t {
      if (value < in_zip64_field) return value;
      append_little(zip64, value, 8);
      return in_zip64_field;
    };
    const std::uint64_t size = narrow(entry.size), stored_size = narrow(entry.stored_size);
    const std::uint64_t header_offset = narrow(entry.header_offset);
    std::string record;
    append_little(record, 0x02014b50, 4);
    append_little(record, version_needed, 2);
    append_little(record, version_needed, 2);
    append_little(record, 0, 2);  // flags
    append_little(record, entry.method, 2);
    append_little(record, 0, 2);  // time
    append_little(record, epoch_date, 2);
    append_little(record, entry.crc32, 4);
    append_little(record, stored_size, 4);
    append_little(record, size, 4);
    append_little(record, entry.name.size(), 2);
    append_little(record, zip64.empty() ? 0 : zip64.size() + 4, 2);
    append_little(record, 0, 2);  // comment
    append_little(record, 0, 2);  // disk
    append_little(record, 0, 2);  // internal attributes
    append_little(record, 0, 4);  // external attributes
    append_little(record, header_offset, 4);
    record += entry.name;
    if (!zip64.empty()) {
      append_little(record, 1, 2);
      append_little(record, zip64.size(), 2);
      record += zip64;
    }
    return record;
  }

  /// Reserves the array header. In a deflated member it goes into an uncompressed block of its own, which ends on a
  /// byte boundary, so that it too can be rewritten in place.
  void append_header(Member& member) {
    if (deflated(member)) {
      std::string block(1, '\0');  // "stored block, not the last"
      append_little(block, header_bytes, 2);
      append_little(block, ~header_bytes, 2);
      file.append(block);
    }
    member.header_offset = file.position();
    file.append(std::string(header_bytes, ' '));
  }

  void patch_header(Member& member) {
    const std::string header = io::format_npy_header(member.type, member.shape, header_bytes);
    require(header.size() == header_bytes, "{}: '{}' has too many dimensions", file.path(), member.entry.name);
    file.patch(member.header_offset, std::as_bytes(std::span(header)));
    member.entry.crc32 = static_cast<std::uint32_t>(crc32_combine(
        checksum(0, std::as_bytes(std::span(header))), member.values_crc32, static_cast<z_off_t>(member.value_bytes)));
    member.entry.size = header_bytes + member.value_bytes;
    member.entry.stored_size = file.position() - member.data_offset;
    const std::string local = local_record(member.entry);
    file.patch(member.entry.header_offset, std::as_bytes(std::span(local)));
  }

  void append_end_records(std::uint64_t directory_offset) {
    const std::uint64_t directory_size = file.position() - directory_offset;
    const bool zip64 =
        directory_offset >= in_zip64_field || directory_size >= in_zip64_field || members.size() >= 0xFFFF;
    std::string record;
    if (zip64) {
      append_little(record, 0x06064b50, 4);
      append_little(record, 44, 8);  // bytes that follow
      append_little(record, version_needed, 2);
      append_little(record, version_needed, 2);
      append_little(record, 0, 8);  // disks
      append_little(record, members.size(), 8);
      append_little(record, members.size(), 8);
      append_little(record, directory_size, 8);
      append_little(record, directory_offset, 8);
      append_little(record, 0x07064b50, 4);
      append_little(record, 0, 4);
      append_little(record, file.position(), 8);
      append_little(record, 1, 4);
    }
    const std::uint64_t count = std::min<std::uint64_t>(members.size(), 0xFFFF);
    append_little(record, 0x06054b50, 4);
    append_little(record, 0, 4);  // disks
    append_little(record, count, 2);
    append_little(record, count, 2);
    append_little(record, std::min<std::uint64_t>(directory_size, in_zip64_field), 4);
    append_little(record, std::min<std::uint64_t>(directory_offset, in_zip64_field), 4);
    append_little(record, 0, 2);  // comment
    file.append(record);
  }
};

NpzWriter::NpzWriter(const std::string& path) : state_(std::make_unique<State>(path)) {}
NpzWriter::~NpzWriter() = default;

void NpzWriter::begin(const std::string& name, DType type, const std::vector<std::size_t>& slice_shape,
                      int deflate_level) {
  State& state = *state_;
  require(!state.open, "{}: a member is already under way", state.file.path());
  require(deflate_level >= 0 && deflate_level <= 9, "a deflate level of {} is outside 0..9", deflate_level);
  require(!name.empty() && name.size() < 1000 && state.names.insert(name).second,
          "{}: '{}' is no usable name or already there", state.file.path(), name);
  Member member;
  member.type = type;
  member.shape = {0};
  member.shape.insert(member.shape.end(), slice_shape.begin(), slice_shape.end());
  member.slice_bytes = size_of(type);
  for (const std::size_t n : slice_shape) member.slice_bytes *= n;
  member.entry.name = name + ".npy";
  const io::ZipMethod method = deflate_level == 0 ? io::ZipMethod::stored : io::ZipMethod::deflated;
  member.entry.method = static_cast<std::uint16_t>(method);
  member.entry.header_offset = state.file.position();
  state.file.append(state.local_record(member.entry));
  member.data_offset = state.file.position();
  state.append_header(member);
  if (deflate_level > 0) state.deflater.emplace(state.file, deflate_level);
  state.members.push_back(std::move(member));
  state.open = true;
}

void NpzWriter::append(std::span<const std::byte> bytes) {
  State& state = *state_;
  require(state.open, "{}: no member is under way", state.file.path());
  Member& member = state.members.back();
  require(bytes.size() == member.slice_bytes, "{}: a slice of '{}' has {} bytes; {} were given", state.file.path(),
          member.entry.name, member.slice_bytes, bytes.size());
  if (state.deflater)
    state.deflater->append(bytes);
  else
    state.file.append(bytes);
  member.values_crc32 = checksum(member.values_crc32, bytes);
  member.value_bytes += bytes.size();
  ++member.shape[0];
}

void NpzWriter::end() {
  State& state = *state_;
  require(state.open, "{}: no member is under way", state.file.path());
  if (state.deflater) state.deflater->end();
  state.deflater.reset();
  state.patch_header(state.members.back());
  state.open = false;
}

void NpzWriter::add(const std::string& name, DType type, const std::vector<std::size_t>& shape,
                    std::span<const std::byte> bytes, int deflate_level) {
  const NpyHeader header{type, ByteOrder::little, false, shape};
  require(bytes.size() == header.values() * size_of(type), "'{}': {} bytes do not fill an array of shape ({})", name,
          bytes.size(), fmt::join(shape, ", "));
  begin(name, type, shape, deflate_level);
  append(bytes);
  Member& member = state_->members.back();
  member.shape.erase(member.shape.begin());  // the whole array was the one slice
  end();
}

void NpzWriter::finish() {
  State& state = *state_;
  require(!state.open, "{}: a member is still under way", state.file.path());
  const std::uint64_t directory_offset = state.file.position();
  for (const Member& member : state.members) state.file.append(state.directory_record(member.entry));
  state.append_end_records(directory_offset);
  state.file.commit();
}

}  // namespace uwv
