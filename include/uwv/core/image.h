// SPDX-License-Identifier: Apache-2.0
// Pictures in memory: an owning, row-major, gap-free raster of one pixel type.
//
// Pixel (x, y) has its centre at (x + 0.5, y + 0.5); x grows to the right, y downwards. Row y starts at data() +
// y*width. Rows are not padded, so a whole picture is one span of width*height pixels; data() is 64-byte aligned for
// SIMD.
#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <span>
#include <vector>

#include "uwv/core/error.h"

namespace uwv {

/// Width and height in pixels. Both are positive in every picture that holds something; {0, 0} is the empty picture.
struct Size {
  int width = 0;
  int height = 0;
  std::size_t pixels() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  friend bool operator==(const Size&, const Size&) = default;
};

/// 8-bit sRGB colour, red first.
struct Rgb8 {
  std::uint8_t r = 0, g = 0, b = 0;
  friend bool operator==(const Rgb8&, const Rgb8&) = default;
};

namespace detail {
/// Allocator whose blocks start on a 64-byte boundary: one cache line, and the widest SIMD register.
template <class T>
struct CacheAligned {
  using value_type = T;
  static constexpr std::align_val_t alignment{64};
  CacheAligned() = default;
  template <class U>
  CacheAligned(const CacheAligned<U>&) {}  // NOLINT(google-explicit-constructor): containers convert allocators
  T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), alignment)); }
  void deallocate(T* p, std::size_t) { ::operator delete(p, alignment); }
  friend bool operator==(const CacheAligned&, const CacheAligned&) { return true; }
};
/// A pixel of zeros. Eigen's vectors leave T{} uninitialised.
template <class T>
T blank_pixel() {
  if constexpr (requires { T::Zero(); })
    return T::Zero();
  else
    return T{};
}
}  // namespace detail

/// An owning picture of pixels T. Copying copies pixels; moving is free.
template <class T>
class Image {
 public:
  Image() = default;
  explicit Image(Size size, T fill = detail::blank_pixel<T>()) : size_(checked(size)), pixels_(size.pixels(), fill) {}
  Image(int width, int height, T fill = detail::blank_pixel<T>()) : Image(Size{width, height}, fill) {}

  Size size() const { return size_; }
  int width() const { return size_.width; }
  int height() const { return size_.height; }
  bool empty() const { return pixels_.empty(); }

  T* data() { return pixels_.data(); }
  const T* data() const { return pixels_.data(); }
  T* row(int y) { return data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(size_.width); }
  const T* row(int y) const { return data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(size_.width); }
  /// Unchecked access; x in [0, width), y in [0, height).
  T& operator()(int x, int y) { return row(y)[x]; }
  const T& operator()(int x, int y) const { return row(y)[x]; }
  /// All pixels in row-major order.
  std::span<T> pixels() { return {pixels_.data(), pixels_.size()}; }
  std::span<const T> pixels() const { return {pixels_.data(), pixels_.size()}; }

  bool contains(int x, int y) const { return x >= 0 && y >= 0 && x < size_.width && y < size_.height; }
  void fill(T value) { pixels_.assign(pixels_.size(), value); }
  /// Makes the picture `size` large; pixel values are unspecified afterwards unless the size was already right.
  void resize(Size size) {
    pixels_.resize(checked(size).pixels());
    size_ = size;
  }

  friend bool operator==(const Image&, const Image&) = default;

 private:
  static Size checked(Size size) {
    require(size.width >= 0 && size.height >= 0, "an Image cannot be {}x{} pixels", size.width, size.height);
    return size;
  }

  Size size_;
  std::vector<T, detail::CacheAligned<T>> pixels_;
};

using ImageRgb = Image<Rgb8>;

/// Depth: float32 distance along the optical axis (not along the ray), in scene units. 0 is invalid; valid values are
/// finite and positive. Importers map NaN, Inf and negative values to 0 (see sanitize_depth in depth.h).
using DepthMap = Image<float>;

}  // namespace uwv
