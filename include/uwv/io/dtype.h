// SPDX-License-Identifier: Apache-2.0
// Number types that array files (.npy, .npz, .safetensors) store, and their conversion to the types we compute with.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace uwv {

/// How one value is stored. `boolean` is one byte, 0 or 1. bf16 and the two f8 kinds occur in .safetensors only.
enum class DType { boolean, u8, i8, u16, i16, u32, i32, u64, i64, f8_e4m3, f8_e5m2, f16, bf16, f32, f64 };

/// Bytes of one value.
std::size_t size_of(DType type);
/// The name safetensors gives it: "BOOL", "U8", ... "BF16", "F32".
std::string_view to_string(DType type);
/// False for floating-point types.
bool is_integer(DType type);

enum class ByteOrder { little, big };

/// Reads out.size() values stored as `type` from `bytes`, which needs no alignment and holds exactly
/// out.size() * size_of(type) bytes (std::invalid_argument otherwise). Values are rounded to nearest where `out` is
/// narrower; NaN and Inf are kept.
void convert(DType type, ByteOrder order, std::span<const std::byte> bytes, std::span<float> out);
void convert(DType type, ByteOrder order, std::span<const std::byte> bytes, std::span<double> out);
/// As above for integer types only; u64 values beyond 2^63-1 wrap.
void convert(DType type, ByteOrder order, std::span<const std::byte> bytes, std::span<std::int64_t> out);

/// The DType of a C++ number type, for writers.
template <class T>
constexpr DType dtype_of();
template <>
constexpr DType dtype_of<std::uint8_t>() {
  return DType::u8;
}
template <>
constexpr DType dtype_of<std::uint16_t>() {
  return DType::u16;
}
template <>
constexpr DType dtype_of<std::int32_t>() {
  return DType::i32;
}
template <>
constexpr DType dtype_of<std::int64_t>() {
  return DType::i64;
}
template <>
constexpr DType dtype_of<float>() {
  return DType::f32;
}
template <>
constexpr DType dtype_of<double>() {
  return DType::f64;
}

}  // namespace uwv
