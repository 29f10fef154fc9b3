// SPDX-License-Identifier: Apache-2.0
#include "io/ply_header.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>

#include "io/printable.h"
#include "uwv/core/error.h"

namespace uwv::io {
namespace {

constexpr std::size_t max_header_bytes = 1 << 16;
constexpr std::size_t max_properties = 256;

std::optional<DType> type_named(std::string_view name) {
  struct Known {
    std::string_view old_name, new_name;
    DType type;
  };
  constexpr std::array known = {Known{"char", "int8", DType::i8},      Known{"uchar", "uint8", DType::u8},
                                Known{"short", "int16", DType::i16},   Known{"int", "int32", DType::i32},
                                Known{"uint", "uint32", DType::u32},   Known{"ushort", "uint16", DType::u16},
                                Known{"float", "float32", DType::f32}, Known{"double", "float64", DType::f64}};
  for (const Known& k : known)
    if (name == k.old_name || name == k.new_name) return k.type;
  return std::nullopt;
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> words;
  constexpr std::string_view blanks = " \t\r";
  for (auto first = line.find_first_not_of(blanks); first != std::string_view::npos;
       first = line.find_first_not_of(blanks)) {
    line.remove_prefix(first);
    words.push_back(line.substr(0, line.find_first_of(blanks)));
    line.remove_prefix(words.back().size());
  }
  return words;
}

template <class T>
std::optional<T> number(std::string_view word) {
  T value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  return value;
}

/// Takes the header line by line.
class HeaderParser {
 public:
  HeaderParser(std::string_view text, const std::string& path) : text_(text.substr(0, max_header_bytes)), path_(path) {}

  PlyHeader parse() {
    if (next_line() != "ply")
      fail(ErrorCode::format_unknown, "{}: is no PLY file (its first line is not 'ply')", path_);
    while (true) {
      line_ = next_line();
      const auto words = split(line_);
      if (words.empty()) continue;
      if (words[0] == "end_header") break;
      take(words);
    }
    if (!has_format_) broken("has no format line");
    if (!has_vertex_) fail(ErrorCode::format_unknown, "{}: has no element 'vertex'", path_);
    for (const char* axis : {"x", "y", "z"})
      if (header_.find(axis) < 0)
        fail(ErrorCode::format_unknown, "{}: its vertices have no property '{}'", path_, axis);
    header_.data_offset = at_;
    return header_;
  }

 private:
  [[noreturn]] void broken(std::string_view why) const {
    fail(ErrorCode::file_damaged, "{}: its header {} at '{}'", path_, why, printable(line_.substr(0, 60)));
  }

  std::string_view next_line() {
    const auto end = text_.find('\n', at_);
    if (end == std::string_view::npos)
      fail(at_ == 0 ? ErrorCode::format_unknown : ErrorCode::file_damaged, "{}: its PLY header does not end", path_);
    std::string_view line = text_.substr(at_, end - at_);
    at_ = end + 1;
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }

  void take(const std::vector<std::string_view>& words) {
    if (words[0] == "format") return take_format(words);
    if (words[0] == "element") return take_element(words);
    if (words[0] == "property") return take_property(words);
    if (words[0] == "comment" && words.size() == 5 && words[1] == "uwv_offset") return take_offset(words);
    if (words[0] != "comment" && words[0] != "obj_info") broken("cannot be understood");
  }

  void take_format(const std::vector<std::string_view>& words) {
    if (words.size() != 3 || words[2] != "1.0" || has_format_) broken("cannot be understood");
    has_format_ = true;
    if (words[1] == "ascii")
      header_.format = PlyFormat::ascii;
    else if (words[1] == "binary_little_endian")
      header_.format = PlyFormat::binary_little;
    else if (words[1] == "binary_big_endian")
      header_.format = PlyFormat::binary_big;
    else
      broken("names an unknown format");
  }

  void take_element(const std::vector<std::string_view>& words) {
    const auto count = words.size() == 3 ? number<std::uint64_t>(words[2]) : std::nullopt;
    if (!count) broken("cannot be understood");
    in_vertex_ = words[1] == "vertex";
    if (in_vertex_ && has_vertex_) broken("has two vertex elements");
    if (!in_vertex_ && !has_vertex_)
      fail(ErrorCode::format_unknown, "{}: its element '{}' precedes the vertices; vertices are wanted first", path_,
           printable(words[1]));
    if (!in_vertex_) return;
    has_vertex_ = true;
    header_.vertices = *count;
  }

  void take_property(const std::vector<std::string_view>& words) {
    if (!has_vertex_) broken("has a property outside an element");
    if (!in_vertex_) return;  // of faces and the like, which come later in the file
    if (words.size() == 5 && words[1] == "list")
      fail(ErrorCode::format_unknown, "{}: its vertices have a list property '{}'", path_, printable(words[4]));
    const auto type = words.size() == 3 ? type_named(words[1]) : std::nullopt;
    if (!type) broken("has a property that cannot be understood");
    if (header_.find(words[2]) >= 0) broken("names a property twice");
    if (header_.properties.size() >= max_properties) broken("has too many properties");
    header_.properties.push_back({std::string(words[2]), *type, header_.vertex_bytes});
    header_.vertex_bytes += size_of(*type);
  }

  void take_offset(const std::vector<std::string_view>& words) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto value = number<double>(words[static_cast<std::size_t>(axis) + 2]);
      if (!value || !std::isfinite(*value)) broken("has an offset that cannot be understood");
      header_.offset[axis] = *value;
    }
  }

  std::string_view text_;
  const std::string& path_;
  std::size_t at_ = 0;
  std::string_view line_;
  PlyHeader header_;
  bool has_format_ = false, has_vertex_ = false, in_vertex_ = false;
};

}  // namespace

int PlyHeader::find(std::string_view name) const {
  const auto found =
      std::find_if(properties.begin(), properties.end(), [&](const PlyProperty& p) { return p.name == name; });
  return found == properties.end() ? -1 : static_cast<int>(found - properties.begin());
}

PlyHeader parse_ply_header(std::string_view text, const std::string& path) { return HeaderParser(text, path).parse(); }

}  // namespace uwv::io
