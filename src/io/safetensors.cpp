// SPDX-License-Identifier: Apache-2.0
#include "uwv/io/safetensors.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>

#include "io/disk_file.h"
#include "io/json_text.h"
#include "io/printable.h"
#include "uwv/core/error.h"

namespace uwv {
namespace {

using nlohmann::json;

/// The format's own limit; no real header comes near it.
constexpr std::uint64_t max_header_bytes = 100'000'000;

/// More than any tensor has; torch refuses more than 64.
constexpr std::size_t max_dimensions = 64;

struct Tensor {
  TensorInfo info;
  std::uint64_t begin = 0, end = 0;  // bytes from the start of the data
};

std::optional<DType> dtype_named(std::string_view name) {
  for (const DType type :
       {DType::boolean, DType::u8, DType::i8, DType::u16, DType::i16, DType::u32, DType::i32, DType::u64, DType::i64,
        DType::f8_e4m3, DType::f8_e5m2, DType::f16, DType::bf16, DType::f32, DType::f64})
    if (to_string(type) == name) return type;
  return std::nullopt;
}

std::uint64_t unsigned_number(const json& value, const std::string& where) {
  if (!value.is_number_unsigned())
    fail(ErrorCode::file_damaged, "{} holds {}; a whole number >= 0 is wanted", where, value.dump().substr(0, 40));
  return value.get<std::uint64_t>();
}

const json& member(const json& object, const char* key, json::value_t type, const std::string& where) {
  const auto found = object.find(key);
  if (found == object.end()) fail(ErrorCode::file_damaged, "{} lacks '{}'", where, key);
  if (found->type() != type) fail(ErrorCode::file_damaged, "{}: '{}' is of the wrong JSON type", where, key);
  return *found;
}

/// Bytes of the tensor by its type and shape. Dimensions of 0 are legal and must not hide an overflow of the others:
/// whoever makes strides of the shape multiplies those.
std::uint64_t bytes_of(const TensorInfo& info, const std::string& where) {
  constexpr std::uint64_t most = std::numeric_limits<std::int64_t>::max();
  std::uint64_t total = size_of(info.dtype);
  bool none = false;
  for (const std::size_t n : info.shape) {
    none = none || n == 0;
    if (__builtin_mul_overflow(total, std::max<std::size_t>(n, 1), &total) || total > most)
      fail(ErrorCode::file_damaged, "{}: the product of its shape overflows 63 bits", where);
  }
  return none ? 0 : total;
}

Tensor parse_tensor(const json& entry, const std::string& where, std::uint64_t data_bytes) {
  if (!entry.is_object()) fail(ErrorCode::file_damaged, "{} is described by a JSON value that is no object", where);
  Tensor tensor;
  const auto& dtype = member(entry, "dtype", json::value_t::string, where).get_ref<const std::string&>();
  const auto known = dtype_named(dtype);
  if (!known) fail(ErrorCode::file_damaged, "{} has the unknown dtype '{}'", where, io::printable(dtype));
  tensor.info.dtype = *known;
  const json& shape = member(entry, "shape", json::value_t::array, where);
  if (shape.size() > max_dimensions)
    fail(ErrorCode::file_damaged, "{} has {} dimensions; at most {} are read", where, shape.size(), max_dimensions);
  for (const json& n : shape)
    tensor.info.shape.push_back(static_cast<std::size_t>(unsigned_number(n, where + "'s shape")));

  const json& offsets = member(entry, "data_offsets", json::value_t::array, where);
  if (offsets.size() != 2) fail(ErrorCode::file_damaged, "{} has {} data_offsets instead of 2", where, offsets.size());
  tensor.begin = unsigned_number(offsets[0], where + "'s data_offsets");
  tensor.end = unsigned_number(offsets[1], where + "'s data_offsets");
  if (tensor.begin > tensor.end || tensor.end > data_bytes)
    fail(ErrorCode::file_damaged, "{} claims bytes {} to {}, but the file has {} bytes of data", where, tensor.begin,
         tensor.end, data_bytes);
  const std::uint64_t wanted = bytes_of(tensor.info, where);
  if (wanted != tensor.end - tensor.begin)
    fail(ErrorCode::file_damaged, "{} has {} bytes, but its type and shape need {}", where, tensor.end - tensor.begin,
         wanted);
  return tensor;
}

/// The format wants the tensors to cover the data without gap or overlap, so that nothing can hide in the file.
void check_coverage(const std::map<std::string, Tensor>& tensors, std::uint64_t data_bytes, const std::string& path) {
  std::vector<const std::pair<const std::string, Tensor>*> by_begin;
  for (const auto& entry : tensors) by_begin.push_back(&entry);
  std::sort(by_begin.begin(), by_begin.end(), [](const auto* a, const auto* b) {
    return std::pair(a->second.begin, a->second.end) < std::pair(b->second.begin, b->second.end);
  });
  std::uint64_t covered = 0;
  for (const auto* entry : by_begin) {
    if (entry->second.begin != covered)
      fail(ErrorCode::file_damaged, "{}: tensor '{}' starts at byte {} where {} is wanted ({})", path,
           io::printable(entry->first), entry->second.begin, covered,
           entry->second.begin < covered ? "tensors overlap" : "there is a gap");
    covered = entry->second.end;
  }
  if (covered != data_bytes)
    fail(ErrorCode::file_damaged, "{}: has {} bytes of data, but its tensors cover {}", path, data_bytes, covered);
}

}  // namespace

struct SafeTensors::Contents {
  explicit Contents(const std::string& file_path) : path(file_path), file(file_path) {}

  const Tensor& at(const std::string& name) const {
    const auto found = tensors.find(name);
    if (found == tensors.end())
      fail(ErrorCode::value_invalid, "{}: holds no tensor named '{}' (it has {} others)", path, name, tensors.size());
    return found->second;
  }
  std::span<const std::byte> bytes(const Tensor& tensor) const {
    return file.bytes().subspan(data_offset + tensor.begin, tensor.end - tensor.begin);
  }
  template <class T>
  std::vector<T> values(const std::string& name) const {
    const Tensor& tensor = at(name);
    std::vector<T> out(tensor.info.values());
    convert(tensor.info.dtype, ByteOrder::little, bytes(tensor), std::span<T>(out));
    return out;
  }

  std::string path;
  io::MappedFile file;
  std::size_t data_offset = 0;
  std::map<std::string, Tensor> tensors;
  std::map<std::string, std::string> metadata;
};

std::size_t TensorInfo::values() const {
  std::size_t product = 1;
  for (const std::size_t n : shape) product *= n;
  return product;
}

SafeTensors SafeTensors::open(const std::string& path) {
  auto contents = std::make_shared<Contents>(path);
  const auto bytes = contents->file.bytes();
  std::uint64_t header_bytes = 0;
  if (bytes.size() < sizeof header_bytes)
    fail(ErrorCode::file_damaged, "{}: {} bytes are too few for a safetensors file", path, bytes.size());
  std::memcpy(&header_bytes, bytes.data(), sizeof header_bytes);
  if (header_bytes > max_header_bytes || header_bytes > bytes.size() - sizeof header_bytes)
    fail(ErrorCode::file_damaged, "{}: claims a header of {} bytes in a file of {}; is it a safetensors file?", path,
         header_bytes, bytes.size());
  contents->data_offset = sizeof header_bytes + static_cast<std::size_t>(header_bytes);
  const std::uint64_t data_bytes = bytes.size() - contents->data_offset;

  const std::string_view text(reinterpret_cast<const char*>(bytes.data()) + sizeof header_bytes, header_bytes);
  const json header = io::parse_json(text, path);
  if (!header.is_object()) fail(ErrorCode::file_damaged, "{}: its header is no JSON object", path);
  for (const auto& [name, entry] : header.items()) {
    if (name != "__metadata__") {
      const std::string where = fmt::format("{}: tensor '{}'", path, io::printable(name));
      contents->tensors.emplace(name, parse_tensor(entry, where, data_bytes));
      continue;
    }
    if (!entry.is_object()) fail(ErrorCode::file_damaged, "{}: its __metadata__ is no JSON object", path);
    for (const auto& [key, value] : entry.items()) {
      if (!value.is_string()) fail(ErrorCode::file_damaged, "{}: metadata '{}' is no string", path, io::printable(key));
      contents->metadata.emplace(key, value.get<std::string>());
    }
  }
  check_coverage(contents->tensors, data_bytes, path);

  SafeTensors result;
  result.contents_ = std::move(contents);
  return result;
}

std::vector<std::string> SafeTensors::names() const {
  std::vector<std::string> names;
  for (const auto& [name, tensor] : contents_->tensors) names.push_back(name);
  return names;
}

bool SafeTensors::has(const std::string& name) const { return contents_->tensors.contains(name); }
const std::map<std::string, std::string>& SafeTensors::metadata() const { return contents_->metadata; }
const TensorInfo& SafeTensors::info(const std::string& name) const { return contents_->at(name).info; }
std::vector<float> SafeTensors::as_float(const std::string& name) const { return contents_->values<float>(name); }
std::vector<double> SafeTensors::as_double(const std::string& name) const { return contents_->values<double>(name); }

std::vector<std::uint8_t> SafeTensors::as_u8(const std::string& name) const {
  const DType dtype = info(name).dtype;
  if (dtype != DType::u8 && dtype != DType::boolean)
    fail(ErrorCode::value_invalid, "{}: tensor '{}' is {}; U8 or BOOL is wanted", contents_->path, name,
         to_string(dtype));
  const auto stored = bytes(name);
  std::vector<std::uint8_t> out(stored.size());
  std::transform(stored.begin(), stored.end(), out.begin(), [](std::byte b) { return static_cast<std::uint8_t>(b); });
  return out;
}

std::vector<std::int64_t> SafeTensors::as_i64(const std::string& name) const {
  if (!is_integer(info(name).dtype))
    fail(ErrorCode::value_invalid, "{}: tensor '{}' is {}; an integer type is wanted", contents_->path, name,
         to_string(info(name).dtype));
  return contents_->values<std::int64_t>(name);
}

std::span<const std::byte> SafeTensors::bytes(const std::string& name) const {
  return contents_->bytes(contents_->at(name));
}

}  // namespace uwv
