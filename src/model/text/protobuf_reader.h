// SPDX-License-Identifier: Apache-2.0
// Walks the fields of a protocol buffer message, of which SentencePiece's models are made. Linking libsentencepiece
// instead is no option: it carries and exports a protobuf library of its own version, which clashes with the one that
// OpenCV brings into the same program.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace uwv::model {

/// One field. Of the members that hold its value, the one of its kind is set.
struct ProtobufField {
  enum class Kind { varint, fixed64, bytes, fixed32 };
  std::uint32_t number = 0;
  Kind kind = Kind::varint;
  std::uint64_t whole = 0;  ///< varint, fixed64, fixed32
  std::string_view bytes;   ///< A string or a message.

  float as_float() const;  ///< fixed32 only.
};

class ProtobufReader {
 public:
  /// `where` begins the sentences of errors.
  ProtobufReader(std::string_view message, std::string where) : rest_(message), where_(std::move(where)) {}

  /// Reads the next field; false at the end. Throws Error(file_damaged) for lengths that lie and unknown kinds.
  bool next(ProtobufField& field);

 private:
  std::uint64_t varint();
  std::uint64_t fixed(std::size_t bytes);
  std::string_view take(std::uint64_t bytes);

  std::string_view rest_;
  std::string where_;
};

}  // namespace uwv::model
