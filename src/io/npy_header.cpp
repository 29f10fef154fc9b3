// SPDX-License-Identifier: Apache-2.0
#include "io/npy_header.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>

#include "io/little_endian.h"
#include "io/printable.h"
#include "uwv/core/error.h"

namespace uwv::io {
namespace {

constexpr std::string_view magic = "\x93NUMPY";
constexpr std::size_t preamble_bytes = 8;            // magic and version
constexpr std::uint64_t max_header_bytes = 1 << 16;  // plain arrays need some hundred bytes

/// Reads the dictionary literal. Python's full syntax is not needed: NumPy writes strings, booleans, whole numbers and
/// tuples, and everything else means an array we could not use.
class HeaderParser {
 public:
  HeaderParser(std::string_view text, const std::string& where) : rest_(text), where_(where) {}

  NpyHeader parse() {
    expect('{');
    while (!accept('}')) {
      const std::string_view key = quoted();
      expect(':');
      if (key == "descr")
        parse_descr();
      else if (key == "fortran_order")
        header_.fortran_order = boolean();
      else if (key == "shape")
        header_.shape = tuple();
      else
        broken();
      if (std::find(seen_.begin(), seen_.end(), key) != seen_.end()) broken();
      seen_.push_back(key);
      if (!accept(',')) {
        expect('}');
        break;
      }
    }
    skip_space();
    if (!rest_.empty() || seen_.size() != 3) broken();
    return header_;
  }

 private:
  [[noreturn]] void broken() const {
    fail(ErrorCode::file_damaged, "{}: its array header cannot be understood near '{}'", where_,
         printable(rest_.substr(0, 40)));
  }
  void skip_space() {
    while (!rest_.empty() && (rest_[0] == ' ' || rest_[0] == '\n' || rest_[0] == '\t')) rest_.remove_prefix(1);
  }
  bool accept(char c) {
    skip_space();
    if (rest_.empty() || rest_[0] != c) return false;
    rest_.remove_prefix(1);
    return true;
  }
  void expect(char c) {
    if (!accept(c)) broken();
  }

  std::string_view quoted() {
    const char quote = accept('\'') ? '\'' : '"';
    if (quote == '"') expect('"');
    const auto end = rest_.find(quote);
    if (end == std::string_view::npos) broken();
    const std::string_view text = rest_.substr(0, end);
    rest_.remove_prefix(end + 1);
    return text;
  }

  bool boolean() {
    skip_space();
    for (const auto& [word, value] : {std::pair<std::string_view, bool>("True", true), {"False", false}})
      if (rest_.starts_with(word)) {
        rest_.remove_prefix(word.size());
        return value;
      }
    broken();
  }

  std::vector<std::size_t> tuple() {
    std::vector<std::size_t> values;
    expect('(');
    while (!accept(')')) {
      values.push_back(number());
      (void)accept('L');  // Python 2 marked its long integers
      if (!accept(',')) {
        expect(')');
        break;
      }
    }
    constexpr std::size_t max_dimensions = 64;  // NumPy's own limit
    if (values.size() > max_dimensions) broken();
    return values;
  }

  std::size_t number() {
    skip_space();
    std::size_t value = 0;
    const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
    if (error != std::errc{}) broken();
    rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
    return value;
  }

  void parse_descr() {
    skip_space();
    if (rest_.starts_with('['))
      fail(ErrorCode::format_unknown, "{}: holds a structured array; plain numbers are wanted", where_);
    const std::string_view descr = quoted();
    struct Known {
      std::string_view name;
      DType type;
    };
    constexpr std::array known = {Known{"b1", DType::boolean}, Known{"u1", DType::u8},  Known{"i1", DType::i8},
                                  Known{"u2", DType::u16},     Known{"i2", DType::i16}, Known{"u4", DType::u32},
                                  Known{"i4", DType::i32},     Known{"u8", DType::u64}, Known{"i8", DType::i64},
                                  Known{"f2", DType::f16},     Known{"f4", DType::f32}, Known{"f8", DType::f64}};
    const char order = descr.empty() ? '?' : descr[0];
    const std::string_view kind = descr.substr(descr.empty() ? 0 : 1);
    const auto match = std::find_if(known.begin(), known.end(), [&](const Known& k) { return k.name == kind; });
    if (std::string_view("<>|=").find(order) == std::string_view::npos || match == known.end())
      fail(ErrorCode::format_unknown, "{}: holds values of type '{}'; b1, i1-i8, u1-u8, f2, f4 or f8 is wanted", where_,
           printable(descr.substr(0, 40)));
    header_.dtype = match->type;
    header_.byte_order = order == '>' ? ByteOrder::big : ByteOrder::little;
  }

  std::string_view rest_;
  const std::string& where_;
  std::vector<std::string_view> seen_;
  NpyHeader header_;
};

std::string_view descr_of(DType type) {
  switch (type) {
    case DType::boolean: return "|b1";
    case DType::u8: return "|u1";
    case DType::i8: return "|i1";
    case DType::u16: return "<u2";
    case DType::i16: return "<i2";
    case DType::u32: return "<u4";
    case DType::i32: return "<i4";
    case DType::u64: return "<u8";
    case DType::i64: return "<i8";
    case DType::f16: return "<f2";
    case DType::f32: return "<f4";
    case DType::f64: return "<f8";
    default: break;
  }
  require(false, "NumPy has no type for {}", to_string(type));
  return {};
}

void check_size(const LocatedNpyHeader& located, std::uint64_t stream_bytes, const std::string& where) {
  std::uint64_t bytes = size_of(located.header.dtype);
  bool overflow = false;
  for (const std::size_t n : located.header.shape) overflow |= __builtin_mul_overflow(bytes, n, &bytes);
  const std::uint64_t available = stream_bytes - located.data_offset;
  if (overflow || bytes > available)
    fail(ErrorCode::file_damaged, "{}: its header claims an array of shape ({}) and type {}, but only {} bytes follow",
         where, fmt::join(located.header.shape, ", "), to_string(located.header.dtype), available);
}

}  // namespace

LocatedNpyHeader read_npy_header(ByteStream& stream, const std::string& where) {
  std::array<std::byte, preamble_bytes> preamble{};
  if (stream.size() < preamble_bytes + 4)
    fail(ErrorCode::file_damaged, "{}: {} bytes are too few for a NumPy array", where, stream.size());
  stream.read_at(0, preamble);
  if (std::string_view(reinterpret_cast<const char*>(preamble.data()), magic.size()) != magic)
    fail(ErrorCode::format_unknown, "{}: is no NumPy array (its first bytes are not \\x93NUMPY)", where);
  const int version = std::to_integer<int>(preamble[6]);
  if (version < 1 || version > 3)
    fail(ErrorCode::format_unknown, "{}: is NumPy format version {}; 1, 2 or 3 is wanted", where, version);

  std::array<std::byte, 4> length_field{};
  const auto length_bytes = std::span(length_field).first(version == 1 ? 2 : 4);
  stream.read_at(preamble_bytes, length_bytes);
  const std::uint64_t length =
      version == 1 ? load_little<std::uint16_t>(length_bytes, 0) : load_little<std::uint32_t>(length_bytes, 0);
  LocatedNpyHeader located;
  located.data_offset = preamble_bytes + length_bytes.size() + length;
  if (length > max_header_bytes || located.data_offset > stream.size())
    fail(ErrorCode::file_damaged, "{}: claims a header of {} bytes in {} bytes of data", where, length, stream.size());

  std::string text(static_cast<std::size_t>(length), ' ');
  stream.read_at(preamble_bytes + length_bytes.size(), std::as_writable_bytes(std::span(text)));
  located.header = HeaderParser(text, where).parse();
  check_size(located, stream.size(), where);
  return located;
}

std::string format_npy_header(DType type, const std::vector<std::size_t>& shape, std::size_t min_bytes) {
  std::string text = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}{}), }}", descr_of(type),
                                 fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
  constexpr std::size_t alignment = 64, fixed_bytes = preamble_bytes + 2;
  const std::size_t wanted = std::max(min_bytes, fixed_bytes + text.size() + 1);
  const std::size_t total = (wanted + alignment - 1) / alignment * alignment;
  text.append(total - fixed_bytes - text.size() - 1, ' ').push_back('\n');
  std::string header(magic);
  header += std::string_view("\x01\x00", 2);
  append_little(header, text.size(), 2);
  return header + text;
}

}  // namespace uwv::io
