// SPDX-License-Identifier: Apache-2.0
// Finders of what a picture is about (paper, "Layer-wise Point Cloud Construction": the foreground of the first frame).
#pragma once

#include <memory>
#include <string>

#include "uwv/geometry/layers.h"

namespace uwv {

/// The saliency network u2netp (U^2-Net, Qin et al. 2020, small version) from its ONNX file, which `scripts/setup` puts
/// into `.cache/models/u2netp.onnx`. It works on the picture shrunk to 320x320, colours divided by the picture's
/// largest value and normalised by ImageNet's mean and deviation; the answer is stretched to [0, 1] unless the network
/// saw nothing at all (no value above 0.2), and enlarged to the picture. About 2 s a picture on one core. Throws Error:
/// file_not_found; file_damaged (not to be read as ONNX); format_unknown (another network: it does not turn 1x3x320x320
/// into 1x1x320x320). find() throws std::invalid_argument for an empty picture.
std::unique_ptr<ForegroundFinder> make_saliency_network(const std::string& onnx_path);

/// What there is without a network: colours that the picture's border does not have, near the middle, are the subject;
/// GrabCut draws its outline. Good for one subject before a plain background, poor for cluttered scenes.
struct ContrastFinderOptions {
  int working_side = 256;  ///< The longer side is shrunk to this: outlines to 2-3 pixels in 480 lines, 0.1 to 0.3 s.
  double border = 0.06;    ///< Share of the shorter side that counts as border. Thinner: few colours; thicker: subject.
  int border_colours = 6;  ///< Clusters that describe the border. More forgive cluttered borders, and hide subjects.
  double min_contrast = 6.0;  ///< Lab distance (0..~100 scale) below which nothing stands out: noise and gradients.
  int outline_rounds = 3;     ///< GrabCut iterations; 0 leaves the soft contrast. Little changes after the third.
  void check() const;
};
std::unique_ptr<ForegroundFinder> make_contrast_finder(const ContrastFinderOptions& options = {});

}  // namespace uwv
