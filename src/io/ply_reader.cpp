// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "io/disk_file.h"
#include "io/ply_header.h"
#include "io/printable.h"
#include "uwv/io/ply_file.h"

namespace uwv {
namespace {

using io::PlyFormat;
using io::PlyHeader;

/// Indices of three properties that belong together; absent unless all are there.
struct Triple {
  std::array<int, 3> index{-1, -1, -1};
  bool present() const { return index[0] >= 0 && index[1] >= 0 && index[2] >= 0; }
};

Triple find_triple(const PlyHeader& header, const std::array<const char*, 3>& names) {
  return {{header.find(names[0]), header.find(names[1]), header.find(names[2])}};
}

/// Turns vertices, given as one number per property, into points.
class CloudBuilder {
 public:
  explicit CloudBuilder(const PlyHeader& header)
      : offset_(header.offset),
        position_(find_triple(header, {"x", "y", "z"})),
        normal_(find_triple(header, {"nx", "ny", "nz"})),
        colour_(find_triple(header, {"red", "green", "blue"})) {
    if (!colour_.present()) colour_ = find_triple(header, {"r", "g", "b"});
    // Colours as floats are in 0..1, as 16-bit numbers in 0..65535.
    if (!colour_.present()) return;
    const DType type = header.properties[static_cast<std::size_t>(colour_.index[0])].type;
    if (!is_integer(type)) colour_scale_ = 255;
    if (type == DType::u16) colour_scale_ = 255. / 65535;
  }

  void reserve(std::size_t count) {
    cloud_.points.reserve(count);
    if (normal_.present()) cloud_.normals.reserve(count);
    if (colour_.present()) cloud_.colours.reserve(count);
  }

  void add(const std::vector<double>& vertex) {
    const Eigen::Vector3d point = take(vertex, position_) + offset_;
    if (!point.allFinite()) return;
    cloud_.points.push_back(point);
    if (normal_.present()) {
      const Eigen::Vector3f normal = take(vertex, normal_).cast<float>();
      cloud_.normals.push_back(normal.allFinite() ? normal : Eigen::Vector3f(0, 0, 0));
    }
    if (colour_.present()) {
      const Eigen::Vector3d colour = take(vertex, colour_) * colour_scale_;
      cloud_.colours.push_back({level(colour[0]), level(colour[1]), level(colour[2])});
    }
  }

  PlyCloud take_cloud() { return std::move(cloud_); }

 private:
  static Eigen::Vector3d take(const std::vector<double>& vertex, const Triple& triple) {
    return {vertex[static_cast<std::size_t>(triple.index[0])], vertex[static_cast<std::size_t>(triple.index[1])],
            vertex[static_cast<std::size_t>(triple.index[2])]};
  }
  static std::uint8_t level(double value) {
    return value >= 0 ? static_cast<std::uint8_t>(std::min(value + 0.5, 255.)) : std::uint8_t{0};  // NaN gives 0
  }

  Eigen::Vector3d offset_;
  Triple position_, normal_, colour_;
  double colour_scale_ = 1;
  PlyCloud cloud_;
};

PlyCloud read_binary(const PlyHeader& header, std::span<const std::byte> data, const std::string& path) {
  if (header.vertices > data.size() / header.vertex_bytes)
    fail(ErrorCode::file_damaged, "{}: claims {} vertices of {} bytes, but {} bytes follow its header", path,
         header.vertices, header.vertex_bytes, data.size());
  const ByteOrder order = header.format == PlyFormat::binary_big ? ByteOrder::big : ByteOrder::little;
  CloudBuilder builder(header);
  builder.reserve(static_cast<std::size_t>(header.vertices));
  std::vector<double> vertex(header.properties.size());
  for (std::uint64_t i = 0; i < header.vertices; ++i) {
    for (std::size_t p = 0; p < vertex.size(); ++p) {
      const io::PlyProperty& property = header.properties[p];
      const std::size_t at = static_cast<std::size_t>(i) * header.vertex_bytes + property.offset;
      convert(property.type, order, data.subspan(at, size_of(property.type)), std::span(&vertex[p], 1));
    }
    builder.add(vertex);
  }
  return builder.take_cloud();
}

PlyCloud read_ascii(const PlyHeader& header, std::string_view text, const std::string& path) {
  // Each number needs a digit and a separator (the last one may end the file).
  if (header.vertices > (text.size() + 1) / (2 * header.properties.size()))
    fail(ErrorCode::file_damaged, "{}: claims {} vertices of {} numbers, but {} bytes follow its header", path,
         header.vertices, header.properties.size(), text.size());
  CloudBuilder builder(header);
  builder.reserve(static_cast<std::size_t>(header.vertices));
  std::vector<double> vertex(header.properties.size());
  for (std::uint64_t i = 0; i < header.vertices; ++i) {
    for (double& value : vertex) {
      text.remove_prefix(std::min(text.size(), text.find_first_not_of(" \t\r\n")));
      const std::string_view word = text.substr(0, text.find_first_of(" \t\r\n"));
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
      if (error != std::errc{} || end != word.data() + word.size())
        fail(ErrorCode::file_damaged, "{}: vertex {} holds '{}' where a number is wanted", path, i,
             io::printable(word));
      text.remove_prefix(word.size());
    }
    builder.add(vertex);
  }
  return builder.take_cloud();
}

}  // namespace

PlyCloud read_ply(const std::string& path) {
  const io::MappedFile file(path);
  const std::string_view text(reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size());
  const PlyHeader header = io::parse_ply_header(text, path);
  if (header.format == PlyFormat::ascii) return read_ascii(header, text.substr(header.data_offset), path);
  return read_binary(header, file.bytes().subspan(header.data_offset), path);
}

}  // namespace uwv
