// SPDX-License-Identifier: Apache-2.0
// manifest.json of a depth network. docs/depth-models.md is its reference.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "model/script_module.h"
#include "uwv/core/image.h"

namespace uwv::model {

enum class NetworkKind { metric_depth, inverse_depth, points, depth_and_pose };
enum class SizeRule { fixed, shorter_side, longer_side, width, area };
enum class Rounding { nearest, down, up };
enum class InputFilter { bilinear, bicubic, area, lanczos };
enum class ConfidenceRule { unit, logit, from_one };

struct InputRule {
  SizeRule size_rule = SizeRule::longer_side;
  int side = 0;         ///< For shorter_side, longer_side, width.
  Size size;            ///< For fixed.
  double pixels = 0;    ///< For area.
  int multiple_of = 1;  ///< Both sides become multiples of it.
  Rounding rounding = Rounding::nearest;
  double limit_aspect = 0;  ///< For shorter_side: pictures longer than this get a smaller side; 0 = no limit.
  InputFilter filter = InputFilter::bicubic;
  bool bgr = false;
  std::array<double, 2> range{0, 1};  ///< What 0 and 255 become, before mean and std.
  std::array<double, 3> mean{0, 0, 0}, std{1, 1, 1};
  std::string layout = "NCHW";  ///< Letters N (1), T (frames), C, H, W.
  TensorType dtype = TensorType::float32;

  bool takes_clips() const { return layout.find('T') != std::string::npos; }
};

/// Which of forward's outputs something is: its place in the tuple, or its key in the dictionary.
struct OutputPlace {
  int number = -1;
  std::string key;
};

/// Windows over a clip, as Video Depth Anything has them (geometry sheet 4.5): each window begins with `overlap` frames
/// of the one before, taken at `keyframes`; the last `blend` of them are its last frames and are blended, the others
/// tie the windows' scale and shift together.
struct WindowRule {
  int frames = 0;
  int overlap = 0;
  int blend = 0;
  std::vector<int> keyframes;
  int step() const { return frames - overlap; }
  int tied() const { return overlap - blend; }
};

struct DepthManifest {
  std::string path;
  std::string name;
  std::string model = "model.ts";
  NetworkKind kind = NetworkKind::metric_depth;
  bool metric = true;
  InputRule input;
  std::map<std::string, OutputPlace, std::less<>> outputs;
  ConfidenceRule confidence_rule = ConfidenceRule::unit;
  bool mask_is_logit = false;
  double mask_threshold = 0.5;
  double max_depth = 0;  ///< Farther depths are unknown (a network's sky); 0 = none.
  bool pose_is_cam_from_world = true;
  bool one_field_of_view = false;
  std::optional<WindowRule> window;
};

/// Throws Error(file_not_found, file_damaged, value_invalid).
DepthManifest read_depth_manifest(const std::string& path);

}  // namespace uwv::model
