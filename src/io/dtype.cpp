// SPDX-License-Identifier: Apache-2.0
#include "uwv/io/dtype.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "uwv/core/error.h"

namespace uwv {
namespace {

static_assert(std::endian::native == std::endian::little, "array files are read on little-endian machines only");

float float_from_half(std::uint16_t half) {
  const std::uint32_t sign = static_cast<std::uint32_t>(half & 0x8000U) << 16;
  const std::uint32_t exponent = (half >> 10) & 0x1FU;
  const std::uint32_t fraction = half & 0x3FFU;
  if (exponent == 0) {  // zero and denormals: fraction * 2^-24
    const float magnitude = static_cast<float>(fraction) * 0x1p-24F;
    return sign != 0 ? -magnitude : magnitude;
  }
  const std::uint32_t wide = exponent == 31 ? 0xFFU : exponent + 112;
  return std::bit_cast<float>(sign | wide << 23 | fraction << 13);
}

/// The "fn" variant: no infinities, NaN is all ones, exponent bias 7.
float float_from_e4m3(std::uint8_t bits) {
  const int exponent = (bits >> 3) & 0xF;
  const int fraction = bits & 7;
  float magnitude = exponent == 0 ? static_cast<float>(fraction) * 0x1p-9F
                                  : std::ldexp(static_cast<float>(8 + fraction), exponent - 10);
  if ((bits & 0x7F) == 0x7F) magnitude = std::numeric_limits<float>::quiet_NaN();
  return (bits & 0x80) != 0 ? -magnitude : magnitude;
}

template <class Stored>
Stored load(const std::byte* bytes, ByteOrder order) {
  std::byte buffer[sizeof(Stored)];
  for (std::size_t i = 0; i < sizeof(Stored); ++i)
    buffer[i] = bytes[order == ByteOrder::little ? i : sizeof(Stored) - 1 - i];
  return std::bit_cast<Stored>(buffer);
}

template <class Stored, class Out, class Decode>
void convert_each(ByteOrder order, std::span<const std::byte> bytes, std::span<Out> out, Decode decode) {
  const std::byte* from = bytes.data();
  for (Out& value : out) {
    value = static_cast<Out>(decode(load<Stored>(from, order)));
    from += sizeof(Stored);
  }
}

template <class Stored, class Out>
void convert_plain(ByteOrder order, std::span<const std::byte> bytes, std::span<Out> out) {
  if constexpr (std::is_same_v<Stored, Out>)
    if (order == ByteOrder::little) {
      if (!out.empty()) std::memcpy(out.data(), bytes.data(), bytes.size());
      return;
    }
  convert_each<Stored>(order, bytes, out, [](Stored value) { return value; });
}

template <class Out>
void convert_floats(DType type, ByteOrder order, std::span<const std::byte> bytes, std::span<Out> out) {
  switch (type) {
    case DType::f8_e4m3: return convert_each<std::uint8_t>(order, bytes, out, float_from_e4m3);
    case DType::f8_e5m2:
      return convert_each<std::uint8_t>(
          order, bytes, out, [](std::uint8_t v) { return float_from_half(static_cast<std::uint16_t>(v << 8)); });
    case DType::f16: return convert_each<std::uint16_t>(order, bytes, out, float_from_half);
    case DType::bf16:
      return convert_each<std::uint16_t>(
          order, bytes, out, [](std::uint16_t v) { return std::bit_cast<float>(static_cast<std::uint32_t>(v) << 16); });
    case DType::f32: return convert_plain<float>(order, bytes, out);
    default: return convert_plain<double>(order, bytes, out);
  }
}

template <class Out>
void convert_any(DType type, ByteOrder order, std::span<const std::byte> bytes, std::span<Out> out) {
  require(bytes.size() / size_of(type) == out.size() && bytes.size() % size_of(type) == 0,
          "{} bytes do not hold {} values of type {}", bytes.size(), out.size(), to_string(type));
  switch (type) {
    case DType::boolean: return convert_each<std::uint8_t>(order, bytes, out, [](std::uint8_t v) { return v != 0; });
    case DType::u8: return convert_plain<std::uint8_t>(order, bytes, out);
    case DType::i8: return convert_plain<std::int8_t>(order, bytes, out);
    case DType::u16: return convert_plain<std::uint16_t>(order, bytes, out);
    case DType::i16: return convert_plain<std::int16_t>(order, bytes, out);
    case DType::u32: return convert_plain<std::uint32_t>(order, bytes, out);
    case DType::i32: return convert_plain<std::int32_t>(order, bytes, out);
    case DType::u64: return convert_plain<std::uint64_t>(order, bytes, out);
    case DType::i64: return convert_plain<std::int64_t>(order, bytes, out);
    default: break;
  }
  if constexpr (std::is_floating_point_v<Out>)
    convert_floats(type, order, bytes, out);
  else
    require(false, "values of type {} cannot be read as integers", to_string(type));
}

}  // namespace

std::size_t size_of(DType type) {
  switch (type) {
    case DType::boolean:
    case DType::u8:
    case DType::i8:
    case DType::f8_e4m3:
    case DType::f8_e5m2: return 1;
    case DType::u16:
    case DType::i16:
    case DType::f16:
    case DType::bf16: return 2;
    case DType::u32:
    case DType::i32:
    case DType::f32: return 4;
    case DType::u64:
    case DType::i64:
    case DType::f64: return 8;
  }
  return 0;
}

std::string_view to_string(DType type) {
  switch (type) {
    case DType::boolean: return "BOOL";
    case DType::u8: return "U8";
    case DType::i8: return "I8";
    case DType::u16: return "U16";
    case DType::i16: return "I16";
    case DType::u32: return "U32";
    case DType::i32: return "I32";
    case DType::u64: return "U64";
    case DType::i64: return "I64";
    case DType::f8_e4m3: return "F8_E4M3";
    case DType::f8_e5m2: return "F8_E5M2";
    case DType::f16: return "F16";
    case DType::bf16: return "BF16";
    case DType::f32: return "F32";
    case DType::f64: return "F64";
  }
  return "?";
}

bool is_integer(DType type) {
  switch (type) {
    case DType::f8_e4m3:
    case DType::f8_e5m2:
    case DType::f16:
    case DType::bf16:
    case DType::f32:
    case DType::f64: return false;
    default: return true;
  }
}

void convert(DType type, ByteOrder order, std::span<const std::byte> bytes, std::span<float> out) {
  convert_any(type, order, bytes, out);
}
void convert(DType type, ByteOrder order, std::span<const std::byte> bytes, std::span<double> out) {
  convert_any(type, order, bytes, out);
}
void convert(DType type, ByteOrder order, std::span<const std::byte> bytes, std::span<std::int64_t> out) {
  convert_any(type, order, bytes, out);
}

}  // namespace uwv
