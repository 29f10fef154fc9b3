// SPDX-License-Identifier: Apache-2.0
#include "model/text/protobuf_reader.h"

#include <bit>
#include <cstring>

#include "uwv/core/error.h"

namespace uwv::model {

float ProtobufField::as_float() const { return std::bit_cast<float>(static_cast<std::uint32_t>(whole)); }

bool ProtobufReader::next(ProtobufField& field) {
  if (rest_.empty()) return false;
  const std::uint64_t key = varint();
  field = {};
  field.number = static_cast<std::uint32_t>(key >> 3);
  switch (key & 7) {
    case 0:
      field.kind = ProtobufField::Kind::varint;
      field.whole = varint();
      return true;
    case 1:
      field.kind = ProtobufField::Kind::fixed64;
      field.whole = fixed(8);
      return true;
    case 2:
      field.kind = ProtobufField::Kind::bytes;
      field.bytes = take(varint());
      return true;
    case 5:
      field.kind = ProtobufField::Kind::fixed32;
      field.whole = fixed(4);
      return true;
    default:
      fail(ErrorCode::file_damaged, "{}: a field of kind {} stands where 0, 1, 2 or 5 is wanted", where_, key & 7);
  }
}

std::uint64_t ProtobufReader::varint() {
  std::uint64_t value = 0;
  for (int shift = 0; shift < 70; shift += 7) {
    const auto byte = static_cast<unsigned char>(take(1)[0]);
    if (shift < 64) value |= static_cast<std::uint64_t>(byte & 0x7FU) << shift;
    if (byte < 0x80) return value;
  }
  fail(ErrorCode::file_damaged, "{}: a number is longer than 10 bytes", where_);
}

std::uint64_t ProtobufReader::fixed(std::size_t bytes) {
  std::uint64_t value = 0;
  std::memcpy(&value, take(bytes).data(), bytes);
  return value;
}

std::string_view ProtobufReader::take(std::uint64_t bytes) {
  if (bytes > rest_.size())
    fail(ErrorCode::file_damaged, "{}: {} bytes are wanted where {} are left; it was cut short or is no such file",
         where_, bytes, rest_.size());
  const std::string_view taken = rest_.substr(0, static_cast<std::size_t>(bytes));
  rest_.remove_prefix(taken.size());
  return taken;
}

}  // namespace uwv::model
