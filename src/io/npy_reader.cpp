// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "io/little_endian.h"
#include "io/npy_header.h"
#include "io/printable.h"
#include "io/zip_directory.h"
#include "uwv/core/error.h"
#include "uwv/io/npy.h"

namespace uwv {
namespace {

constexpr std::size_t chunk_bytes = 1U << 18;
constexpr std::string_view suffix = ".npy";

bool starts_like_zip(const io::InputFile& file) {
  std::array<std::byte, 4> start{};
  if (file.size() < start.size()) return false;
  file.read_at(0, start);
  const auto signature = io::load_little<std::uint32_t>(start, 0);
  return signature == 0x04034b50 || signature == 0x06054b50;  // a first member, or an empty directory
}

std::string array_name(const io::ZipMember& member) {
  return member.name.ends_with(suffix) ? member.name.substr(0, member.name.size() - suffix.size()) : member.name;
}

io::ZipMember find_member(const io::InputFile& file, const std::string& name) {
  const auto members = io::read_zip_directory(file);
  std::string others;
  for (const auto& member : members) {
    if (array_name(member) == name || (name.empty() && members.size() == 1)) return member;
    others += (others.empty() ? "" : ", ") + io::printable(array_name(member));
  }
  fail(ErrorCode::value_invalid, "{}: holds no array named '{}'; it has: {}", file.path(), name, io::printable(others));
}

}  // namespace

std::size_t NpyHeader::values() const {
  std::size_t product = 1;
  for (const std::size_t n : shape) product *= n;
  return product;
}

bool is_npz(const std::string& path) { return starts_like_zip(io::InputFile(path)); }

std::vector<std::string> npz_names(const std::string& path) {
  std::vector<std::string> names;
  for (const auto& member : io::read_zip_directory(io::InputFile(path))) names.push_back(array_name(member));
  return names;
}

struct NpyArrayReader::State {
  std::string where;
  std::unique_ptr<io::ByteStream> stream;
  io::LocatedNpyHeader located;
  std::size_t slices = 1, slice_values = 1;
  std::vector<std::byte> chunk;

  const NpyHeader& header() const { return located.header; }

  template <class T>
  void read(std::size_t first, std::span<T> out) {
    const std::size_t count = slice_values == 0 ? 0 : out.size() / slice_values;
    require(count * slice_values == out.size() && first <= slices && count <= slices - first,
            "slices {} to {} of an array of {} slices cannot fill {} values", first, first + count, slices, out.size());
    if (!is_integer(header().dtype) && std::is_integral_v<T>)
      fail(ErrorCode::value_invalid, "{}: holds values of type {}; whole numbers are wanted", where,
           to_string(header().dtype));
    if (header().fortran_order && header().shape.size() > 1)
      gather(first, count, out);
    else
      for_chunks<T>(first * slice_values, out.size(), [&](std::size_t at, std::span<const T> values) {
        std::copy(values.begin(), values.end(), out.begin() + static_cast<std::ptrdiff_t>(at));
      });
  }

  /// Calls body(at, values) for the `total` stored values from value `first` on; `at` counts from 0.
  template <class T, class Body>
  void for_chunks(std::size_t first, std::size_t total, Body body) {
    const std::size_t value_bytes = size_of(header().dtype);
    const std::size_t chunk_values = std::min(total, chunk_bytes / value_bytes);
    chunk.resize(chunk_values * value_bytes);
    std::vector<T> values(chunk_values);
    for (std::size_t at = 0; at < total; at += chunk_values) {
      const std::size_t n = std::min(chunk_values, total - at);
      const auto bytes = std::span(chunk).first(n * value_bytes);
      stream->read_at(located.data_offset + (first + at) * value_bytes, bytes);
      convert(header().dtype, header().byte_order, bytes, std::span(values).first(n));
      body(at, std::span<const T>(values).first(n));
    }
  }

  /// Picks slices out of a Fortran-order array, whose first index varies fastest, in one pass over all of it.
  template <class T>
  void gather(std::size_t first, std::size_t count, std::span<T> out) {
    const auto& shape = header().shape;
    std::vector<std::size_t> stride(shape.size(), 1);  // of the C-order output, in values
    for (std::size_t d = shape.size() - 1; d-- > 0;) stride[d] = stride[d + 1] * shape[d + 1];
    std::vector<std::size_t> index(shape.size(), 0);
    std::size_t place = 0;  // within a slice
    for_chunks<T>(0, header().values(), [&](std::size_t, std::span<const T> values) {
      for (const T value : values) {
        if (index[0] >= first && index[0] - first < count) out[(index[0] - first) * stride[0] + place] = value;
        if (++index[0] < shape[0]) continue;
        index[0] = 0;
        for (std::size_t d = 1; d < shape.size(); ++d) {
          place += stride[d];
          if (++index[d] < shape[d]) break;
          place -= stride[d] * shape[d];
          index[d] = 0;
        }
      }
    });
  }
};

NpyArrayReader::NpyArrayReader(const std::string& path, const std::string& member) : state_(std::make_unique<State>()) {
  const auto file = std::make_shared<const io::InputFile>(path);
  std::string& where = state_->where = path;
  if (starts_like_zip(*file)) {
    const io::ZipMember found = find_member(*file, member);
    state_->stream = io::open_zip_member(file, found);
    where = fmt::format("{}:{}", path, io::printable(array_name(found)));
  } else {
    state_->stream = io::open_region(file, 0, file->size());
  }
  state_->located = io::read_npy_header(*state_->stream, where);
  const auto& shape = header().shape;
  if (!shape.empty()) state_->slices = shape[0];
  for (std::size_t d = 1; d < shape.size(); ++d)
    if (__builtin_mul_overflow(state_->slice_values, shape[d], &state_->slice_values))
      fail(ErrorCode::file_damaged, "{}: its header claims slices of absurd size ({})", where, fmt::join(shape, ", "));
}

NpyArrayReader::~NpyArrayReader() = default;
NpyArrayReader::NpyArrayReader(NpyArrayReader&&) noexcept = default;
NpyArrayReader& NpyArrayReader::operator=(NpyArrayReader&&) noexcept = default;

const NpyHeader& NpyArrayReader::header() const { return state_->header(); }
std::size_t NpyArrayReader::slices() const { return state_->slices; }
std::size_t NpyArrayReader::slice_values() const { return state_->slice_values; }
void NpyArrayReader::read(std::size_t first, std::span<float> out) { state_->read(first, out); }
void NpyArrayReader::read(std::size_t first, std::span<double> out) { state_->read(first, out); }
void NpyArrayReader::read(std::size_t first, std::span<std::int64_t> out) { state_->read(first, out); }

}  // namespace uwv
