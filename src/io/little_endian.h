// SPDX-License-Identifier: Apache-2.0
// Little-endian numbers in byte runs, as zip records use them.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "uwv/core/error.h"

namespace uwv::io {

/// The number of type T at byte `at`, which must lie inside.
template <class T>
T load_little(std::span<const std::byte> bytes, std::size_t at) {
  require(at <= bytes.size() && sizeof(T) <= bytes.size() - at, "byte {} is outside a record of {}", at, bytes.size());
  T value = 0;
  for (std::size_t i = sizeof(T); i-- > 0;) value = static_cast<T>(value << 8 | std::to_integer<T>(bytes[at + i]));
  return value;
}

/// Appends the low `bytes` bytes of `value`.
inline void append_little(std::string& record, unsigned long long value, int bytes) {
  for (int i = 0; i < bytes; ++i) record.push_back(static_cast<char>(value >> (8 * i)));
}

}  // namespace uwv::io
