// SPDX-License-Identifier: Apache-2.0
// Decoded video frames to upright 8-bit RGB at the working size.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "io/libav_versions.h"
#include "uwv/core/image.h"

namespace uwv {

/// One of the eight ways to turn and mirror a picture, as the rows of an integer matrix: a stored pixel (x, y) is shown
/// at (xx * x + xy * y, yx * x + yy * y), shifted so that the picture starts at (0, 0). y grows downwards.
struct Orientation {
  int xx = 1, xy = 0, yx = 0, yy = 1;

  bool swaps_axes() const { return xx == 0; }
  bool is_upright() const { return *this == Orientation{}; }
  Size shown(Size stored) const { return swaps_axes() ? Size{stored.height, stored.width} : stored; }
  friend bool operator==(const Orientation&, const Orientation&) = default;
};

/// Nothing for any angle but quarter turns.
std::optional<Orientation> orientation_of(const libav::DisplayMatrix& m);

/// The colour system a frame is read with: its own tags, with the gaps filled by convention.
struct ColourSystem {
  AVColorSpace matrix = AVCOL_SPC_BT709;
  bool full_range = false;
  bool matrix_unsupported = false;  ///< Tagged with something we cannot undo (YCgCo, ...): read as BT.709.

  static ColourSystem of(const AVFrame& frame);
  friend bool operator==(const ColourSystem&, const ColourSystem&) = default;
};

class FrameConverter {
 public:
  /// `size` is the upright size wanted.
  FrameConverter(Size size, Orientation orientation) : size_(size), orientation_(orientation) {}

  /// Throws Error(format_unknown) naming `path` for pixel formats FFmpeg itself cannot convert.
  void convert(const AVFrame& frame, const std::string& path, ImageRgb& out);

 private:
  void prepare(const AVFrame& frame, const std::string& path);
  void scale(const AVFrame& frame, const std::string& path);

  Size size_;
  Orientation orientation_;
  libav::Scaler scaler_;
  libav::Frame scaled_;            // at the working size, not yet turned
  std::array<int, 4> prepared_{};  // width, height, format, chroma location scaler_ was made for
  ImageRgb unturned_;
};

}  // namespace uwv
