// SPDX-License-Identifier: Apache-2.0
#include <charconv>
#include <cmath>
#include <optional>

#include "io/depth_codecs.h"
#include "io/disk_file.h"
#include "io/printable.h"
#include "uwv/io/dtype.h"

namespace uwv::io {
namespace {

struct PfmHeader {
  Size size;
  ByteOrder order = ByteOrder::little;
  std::size_t data_offset = 0;
};

/// Takes the next word of the header and the one white-space character behind it.
std::string_view next_word(std::string_view text, std::size_t& at) {
  const auto is_space = [](char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; };
  while (at < text.size() && is_space(text[at])) ++at;
  const std::size_t begin = at;
  while (at < text.size() && !is_space(text[at])) ++at;
  const std::string_view word = text.substr(begin, at - begin);
  if (at < text.size()) ++at;
  return word;
}

template <class T>
std::optional<T> number(std::string_view word) {
  T value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  return value;
}

PfmHeader parse_header(std::string_view text, const std::string& path) {
  PfmHeader header;
  std::size_t& at = header.data_offset;
  const std::string_view kind = next_word(text, at);
  if (kind == "PF") fail(ErrorCode::format_unknown, "{}: is a colour PFM; a grey one (Pf) is wanted", path);
  const auto width = number<std::uint64_t>(next_word(text, at));
  const auto height = number<std::uint64_t>(next_word(text, at));
  const auto scale = number<double>(next_word(text, at));
  if (kind != "Pf" || !width || !height || !scale || !std::isfinite(*scale) || *scale == 0)
    fail(ErrorCode::file_damaged, "{}: its PFM header '{}' is not 'Pf width height scale'", path,
         printable(text.substr(0, 40)));
  header.size = checked_size(*width, *height, path);
  header.order = *scale < 0 ? ByteOrder::little : ByteOrder::big;
  return header;
}

}  // namespace

DepthMap read_pfm_depth(const std::string& path, double scale) {
  constexpr std::size_t max_header_bytes = 256;
  const InputFile file(path);
  std::string start(std::min<std::uint64_t>(file.size(), max_header_bytes), '\0');
  file.read_at(0, std::as_writable_bytes(std::span(start)));
  const PfmHeader header = parse_header(start, path);
  const std::uint64_t wanted = header.size.pixels() * sizeof(float);
  if (file.size() - header.data_offset < wanted)
    fail(ErrorCode::file_damaged, "{}: {}x{} pixels need {} bytes, but {} follow the header", path, header.size.width,
         header.size.height, wanted, file.size() - header.data_offset);
  DepthMap depth(header.size);
  std::vector<std::byte> row(static_cast<std::size_t>(header.size.width) * sizeof(float));
  for (int y = 0; y < depth.height(); ++y) {
    const auto from_bottom = static_cast<std::uint64_t>(depth.height() - 1 - y);
    file.read_at(header.data_offset + from_bottom * row.size(), row);
    convert(DType::f32, header.order, row, std::span(depth.row(y), static_cast<std::size_t>(depth.width())));
  }
  if (scale != 1)
    for (float& z : depth.pixels()) z = static_cast<float>(z * scale);
  return depth;
}

void write_pfm_depth(const std::string& path, const DepthMap& depth, double scale) {
  require(!depth.empty(), "{}: an empty depth map cannot be written", path);
  OutputFile file(path);
  file.append(fmt::format("Pf\n{} {}\n-1.0\n", depth.width(), depth.height()));
  std::vector<float> row(static_cast<std::size_t>(depth.width()));
  for (int y = depth.height() - 1; y >= 0; --y) {
    for (int x = 0; x < depth.width(); ++x) row[static_cast<std::size_t>(x)] = static_cast<float>(depth(x, y) / scale);
    file.append(std::as_bytes(std::span(row)));
  }
  file.commit();
}

}  // namespace uwv::io
