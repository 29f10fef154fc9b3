// SPDX-License-Identifier: Apache-2.0
// H.264 video in mp4, by libx264.
#pragma once

#include <memory>
#include <string>

#include "uwv/core/image.h"
#include "uwv/core/mask.h"

namespace uwv {

struct VideoWriterOptions {
  double fps = 16;  ///< Frames per second, in [0.01, 1000]; 16 is what the model was trained on.
  int crf = 10;     ///< x264's quality, 0 (best) to 51. 10 is visually lossless: above 40 dB on smooth pictures.
  /// x264's trade of time for bytes, ultrafast to placebo. CPU time with conversion, size and RGB PSNR of an 832x480
  /// film frame at crf 10: ultrafast 6 ms, 81 kB, 44.8 dB; superfast 9 ms, 54 kB, 44.7 dB; veryfast 16 ms, 33 kB, 43.5
  /// dB.
  std::string preset = "superfast";
  bool cabac = false;     ///< Arithmetic coding: 6 % fewer bytes for 30 % more time at `superfast`.
  bool lossless = false;  ///< Keeps every luma code exactly (`crf` is ignored); masks need it.
  int threads = 0;  ///< 0 = one per processor. The bytes depend on it (x264 records it), the pixels next to nothing.

  /// For masks: lossless at the fastest preset, 2 ms per 832x480 frame. `superfast` with CABAC would save 40 % of the
  /// bytes of a ragged mask for twice the time.
  static VideoWriterOptions for_masks(double fps = 16);

  /// Throws std::invalid_argument naming the option.
  void check() const;
};

/// Writes frames of one size into one mp4. Limited range, BT.709 matrix, primaries and transfer, all tagged in the
/// stream, the table of contents in front (plays while loading), and no time stamps or version strings in the
/// container: the same frames and options give the same bytes with the same x264.
///
/// Even sizes are 4:2:0, which everything plays. 4:2:0 cannot carry odd sizes, so those are 4:4:4, which browsers and
/// hardware players may refuse; so is lossless video of any size (H.264's lossless profile).
///
/// Not for use by two threads at once.
class VideoWriter {
 public:
  /// Creates or overwrites `path`. Throws Error: output_failed (cannot be created), backend_missing (FFmpeg without
  /// libx264), value_invalid (a size x264 refuses; sides above 16384); std::invalid_argument for bad options or sizes.
  VideoWriter(const std::string& path, Size size, const VideoWriterOptions& options = {});
  /// Without finish() before, removes the file: nothing half-written stays behind.
  ~VideoWriter();
  VideoWriter(VideoWriter&&) noexcept;
  VideoWriter& operator=(VideoWriter&&) noexcept;

  /// Appends a frame. Throws std::invalid_argument for another size, Error(output_failed) when the disk is full.
  void write(const ImageRgb& frame);
  /// Appends a mask as black (0) and white (anything else), which every decoder returns as exactly 0 and 255.
  /// Throws std::invalid_argument unless options.lossless. Name the polarity in the file's name.
  void write(const ValidityMask& mask);
  void write(const GenerateMask& mask);

  /// Completes the file. Throws Error(output_failed), std::invalid_argument when no frame was written. Call it once.
  void finish();

 private:
  class Encoder;
  std::unique_ptr<Encoder> encoder_;
};

}  // namespace uwv
