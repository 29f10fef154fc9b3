// SPDX-License-Identifier: Apache-2.0
// Foreground and background as two layers (paper, "Layer-wise Point Cloud Construction").
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "uwv/core/mask.h"
#include "uwv/core/monitor.h"
#include "uwv/core/thread_pool.h"
#include "uwv/geometry/scene_geometry.h"

namespace uwv {

/// 1 = belongs to the foreground, which may move; 0 = background.
using ForegroundMask = Mask<struct ForegroundTag>;

/// Finds what a picture is about. Implementations: saliency.h, and TorchScript nets (uwv::model).
class ForegroundFinder {
 public:
  virtual ~ForegroundFinder() = default;
  /// Probability of foreground in [0, 1], sized as the picture.
  virtual Image<float> find(const ImageRgb& picture) = 0;
  virtual std::string name() const = 0;
};

struct ForegroundOptions {
  double threshold = 0.5;   ///< Probability from which a pixel is foreground; the official code's for videos.
  double min_share = 0.05;  ///< Smaller subjects are taken for noise: the official code's limit.
  /// Below min_share the official code declares the whole picture foreground, which makes everything movable. Ours
  /// says that there is none; true = the official way.
  bool all_when_none = false;
  void check() const;
};

/// The foreground of one picture.
struct Foreground {
  ForegroundMask mask;
  double share = 0;  ///< Of the picture's pixels that the finder called foreground, before min_share was applied.
  std::string note;  ///< One sentence: what was found, by whom, and what was made of it.
};

/// The foreground of a clip's first frame. Throws std::invalid_argument when picture is empty.
Foreground find_foreground(const ImageRgb& picture, ForegroundFinder& finder, const ForegroundOptions& options = {});
/// The same from probabilities; NaN counts as 0. `finder_name` is for the note.
Foreground foreground_from(const Image<float>& probability, const std::string& finder_name,
                           const ForegroundOptions& options = {});
/// A mask the user gives: any grey value of at least 128 is foreground. Throws Error(size_mismatch) naming `what` when
/// it is not of `wanted` size.
Foreground foreground_from_picture(const ImageRgb& picture, Size wanted, const std::string& what);

struct PromptOptions {
  int erode_window = 9;     ///< Side of the square that the mask is eroded by: prompts stay off the outline.
  int erode_rounds = 2;     ///< Times it is eroded.
  int first_step = 100;     ///< Grid step in pixels to begin with.
  int step_decrement = 10;  ///< Taken off the step while there are too few points.
  int min_points = 10;      ///< Enough points; also the step stops shrinking at step_decrement.
  void check() const;
};

/// A pixel's indices, column first.
struct PixelIndex {
  int x = 0, y = 0;
  friend bool operator==(const PixelIndex&, const PixelIndex&) = default;
};

/// Where a promptable segmenter is asked, as the official code asks SAM 2: grid points (multiples of the step, 0
/// included) inside the eroded mask, row by row. The picture's border does not erode. The step shrinks from 100 by 10
/// until there are ten points or it is 10; empty when the eroded mask holds no grid point then.
std::vector<PixelIndex> prompt_points(const ForegroundMask& mask, const PromptOptions& options = {});

/// Follows what points of a clip's first frame belong to. Implementations: TorchScript segmenters (uwv::model).
class ForegroundTracker {
 public:
  virtual ~ForegroundTracker() = default;
  /// One mask a frame, sized as the frames, in which the answers to all prompts are united. `prompts` are pixels of the
  /// first frame, at least one. Reports stage "segmenter".
  virtual std::vector<ForegroundMask> follow(std::span<const ImageRgb> frames, std::span<const PixelIndex> prompts,
                                             Monitor& monitor) = 0;
  virtual std::string name() const = 0;
};

/// Foreground in any of them, as the official code unites its prompts' answers. Throws std::invalid_argument when there
/// are none or sizes differ.
ForegroundMask unite(std::span<const ForegroundMask> masks);

/// Closes gaps and leaves a thin rim: 3x3 dilation `dilate` times, then erosion `erode` times. The defaults are those
/// of the official reconstruction code, which keeps one pixel more than it found.
ForegroundMask close_gaps(const ForegroundMask& mask, int dilate = 4, int erode = 3);

}  // namespace uwv
