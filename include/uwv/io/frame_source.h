// SPDX-License-Identifier: Apache-2.0
// Frames of a clip, one at a time: a video file, a folder or pattern of pictures, or a single photo.
//
// Nothing is held but the frame under way, so memory does not grow with the clip's length. Frames arrive as 8-bit sRGB,
// upright (rotation metadata and EXIF orientation applied), and already at the working size.
#pragma once

#include <memory>
#include <string>

#include "uwv/core/image.h"
#include "uwv/core/monitor.h"
#include "uwv/io/resize_policy.h"

namespace uwv {

struct ClipOptions {
  long start = 0;        ///< First source frame to take, counted from 0. Frames before it are decoded and dropped.
  long stride = 1;       ///< Take every stride-th source frame.
  long max_frames = 81;  ///< Take at most this many (81 is what the model was trained on); 0 = all.
  ResizePolicy resize;   ///< The working size.
  int threads = 0;       ///< Threads of the video decoder; 0 = one per processor. The pixels do not depend on it.

  /// Throws std::invalid_argument: negative start, stride below 1, negative max_frames or threads, bad resize policy.
  void check() const;
};

struct ClipInfo {
  std::string path;                  ///< As given.
  std::string format;                ///< For people, e.g. "h264 yuv420p bt709 limited" or "8-bit picture".
  Size source_size;                  ///< Of the upright picture before resizing.
  Size size;                         ///< Of every frame delivered.
  double fps = 0;                    ///< Average frames per second of the file, before stride; 0 = it says nothing.
  bool is_photo = false;             ///< A single picture: no motion to be expected.
  bool variable_frame_rate = false;  ///< Intervals between the taken frames vary by more than 10 % (see open_clip).
};

/// A clip opened for reading. Frame i here is source frame start + i * stride. Not for use by two threads at once.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  virtual const ClipInfo& info() const = 0;

  /// Number of frames to be had, at least 1. For videos it is counted from the packets in the file, without decoding;
  /// it can shrink once, when read() finds that some of them cannot be decoded.
  virtual long frames() const = 0;

  /// Reads frame `index` (0 <= index < frames(), else std::invalid_argument) into `out`, which takes size info().size.
  /// Going forward is fast (what lies between is decoded and dropped); going back in a video starts over from its
  /// beginning. Returns false when the clip ends before this frame: then frames() tells the corrected number and the
  /// monitor was warned. Throws Error when a picture of a sequence is unreadable or of another size.
  virtual bool read(long index, ImageRgb& out) = 0;
};

/// Opens `path`, which is one of
/// - a video file: whatever FFmpeg decodes. Colours follow the stream's matrix and range; an unspecified matrix is
/// taken
///   as BT.709 from 720 lines on, else BT.601, and an unspecified range as limited. Display rotation by quarter turns
///   and mirroring are applied, edit lists are honoured, cover art is not a video. Frames come in presentation order
///   whatever their time stamps: a variable frame rate is reported and warned of, not resampled;
/// - a picture file (a photo: frames() == 1), or an animated GIF or PNG;
/// - a folder: its pictures in natural order (frame2 before frame10), hidden files and other files left out;
/// - a pattern whose file name holds `%d` / `%05d` (in order of the number; gaps are closed) or `*` and `?` (natural
///   order), when no file has that very name.
/// `monitor` hears warnings (also from read(), so it must outlive the source) and can stop the counting of long files.
/// Throws Error: file_not_found, file_damaged (empty, cut short before the first frame), format_unknown (no pictures in
/// it), size_mismatch, value_invalid (start lies behind the end; absurd size), cancelled.
std::unique_ptr<FrameSource> open_clip(const std::string& path, const ClipOptions& options, Monitor& monitor);

}  // namespace uwv
