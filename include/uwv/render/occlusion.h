// SPDX-License-Identifier: Apache-2.0
// Algorithm 1 of the paper, "Occlusion-aware Point Cloud Rendering": a source frame with depth is moved into a target
// camera; what the target cannot see, and what faces away from it, is not drawn.
//
//   1. M'     which target pixels the source's points reach           (source -> target)
//      M''    which source pixels those target pixels come back to    (target -> source)
//      M_vis  the product of M'' over the path so far
//   2. M_front  n . v > cos(alpha), n towards the source camera, v towards the target camera
//   3. the final picture: only points with M_s * M_vis * M_front       (source -> target)
//
// Frames are given one by one in path order; memory does not depend on how many there are.
#pragma once

#include <memory>
#include <numbers>
#include <optional>
#include <string>

#include "uwv/geometry/reliability.h"
#include "uwv/geometry/slopes.h"
#include "uwv/render/rasterizer.h"

namespace uwv {

/// How points become pixels. docs/performance.md has cost and accuracy of each.
enum class Kernel {
  nearest,   ///< The nearest point's own colour; fastest.
  bilinear,  ///< The official soft-z splat: for comparison with the Python code; blurs, and lets background shine
             ///< through.
  resample,  ///< As nearest for what is seen; colour is then looked up in the source where the pixel's ray meets the
             ///< surface.
};

/// How M'' is found.
enum class Visibility {
  none,       ///< Not at all: M'' = 1, the "naive" rendering.
  ztest,      ///< Project each source point and compare with the target's z-buffer: one pass fewer.
  reproject,  ///< The paper's: render the back-projected target view from the source camera.
};

/// How M'' of several frames combine into M_vis.
enum class Accumulation {
  product,          ///< The paper's: once invisible, invisible for the rest of the path.
  product_in_view,  ///< As product, but leaving the picture does not count as being occluded: for paths that return.
  none,             ///< Each frame on its own: M_vis = M''.
  foreground,       ///< The official video recursion V_i = (V_{i-1} and M''_i) or F_i; needs SourceFrame::foreground.
};

/// Names as used on the command line and in run.json; parse throws Error(value_invalid) listing the known names.
std::string_view to_string(Kernel);
std::string_view to_string(Visibility);
std::string_view to_string(Accumulation);
Kernel parse_kernel(std::string_view name);
Visibility parse_visibility(std::string_view name);
Accumulation parse_accumulation(std::string_view name);

struct OcclusionOptions {
  Kernel kernel = Kernel::resample;
  Visibility visibility = Visibility::reproject;
  Accumulation accumulation = Accumulation::product;

  /// Normal filter: points with n . v <= cos(alpha) are not drawn. Radians; pi/2 (the official code's fixed choice)
  /// drops back faces only, smaller values also drop surfaces seen at a grazing angle, larger ones keep some back
  /// faces, 0 keeps nothing.
  double alpha = std::numbers::pi / 2;
  /// False skips the filter altogether (M_front = 1).
  bool normal_filter = true;

  /// ztest: a point is visible when its depth is at most (1 + depth_tolerance) times the z-buffer's surface there;
  /// unset means 0.02, since with 0 rounding hides points behind their own surface. reproject: > 0 additionally asks
  /// the returning point's depth to agree that well with the source's; unset means 0, no such test, as in the paper.
  std::optional<float> depth_tolerance;

  FootprintOptions footprint;
  /// reproject: scales the footprints of the way back, on top of footprint.point_size. What comes back has been rounded
  /// to target pixels once, so exact patches leave cracks, which the product over many frames would widen: with 1, an
  /// orbit to 90 degrees in 81 frames keeps 92 % of what is visible, with 1.1 more than 99 %, and no colour depends on
  /// it.
  float return_size = 1.1F;
  /// How far, in pixels, the centres of kept points reach into pixels that nothing covers: 1 shows what the official
  /// bilinear kernel shows at the rims of surfaces, up to 0.5 adds nothing. Off, because those pixels are guesses
  /// (around 20 dB on real pairs, where the rest has 27 to 31). M'' does not see them. Not for bilinear, which reaches
  /// 1 by itself.
  float fringe = 0;
  SlopeOptions slopes;
  /// Off, as in the paper (M^s = 1): where depth is sharp the filter only loses pixels, and with them what hides
  /// others. EdgeSharpness::smears() tells when to turn it on.
  ReliabilityOptions reliability{.enabled = false};
  /// Points the filter drops are not drawn, but still hide what lies behind them: they are the rims of objects, and
  /// without them the background shines through. False takes them out of all passes, as the official code does; so
  /// does Kernel::bilinear always. A mask given as SourceFrame::valid says what exists, and is always taken out.
  bool dropped_points_hide = true;
  SoftSplatOptions soft_splat;

  /// Leaves out passes that cannot change a pixel (see FrameReport::skipped). Off only to prove that.
  bool skip_unneeded = true;

  /// depth_tolerance, or what suits the visibility when it is unset.
  float tolerance() const { return depth_tolerance.value_or(visibility == Visibility::ztest ? 0.02F : 0.0F); }

  void check() const;
};

/// One source frame. Pointers are borrowed for the call; null means "not given".
struct SourceFrame {
  long index = 0;                       ///< Two calls with the same index must bring the same frame.
  Camera camera;                        ///< T^s and K of this frame; camera.size is the size of everything below.
  const ImageRgb* colour = nullptr;     ///< Required.
  const DepthMap* depth = nullptr;      ///< Required; 0 = invalid.
  const SlopeMap* slopes = nullptr;     ///< Imported normals as slopes; null = computed from depth.
  const ValidityMask* valid = nullptr;  ///< M^s; null = the reliability filter's answer.
  /// A decimated cloud: the cell sides of the points `valid` keeps (see PointGrid::cells). `depth` holds the planes'
  /// depths at those points and the picture's own everywhere else, `slopes` likewise. Not for Kernel::bilinear.
  const Image<std::uint8_t>* cells = nullptr;
  const ValidityMask* foreground = nullptr;  ///< F (1 = moving foreground), for Accumulation::foreground.
};

/// What one frame becomes. Pixels that show nothing have colour {0, 0, 0}, depth 0, valid 0.
struct RenderedFrame {
  ImageRgb colour;
  DepthMap depth;
  ValidityMask valid;  ///< M^r.
};

/// The masks on the way, for those who ask.
struct FrameMasks {
  ValidityMask first;    ///< M', target pixels.
  ValidityMask second;   ///< M'', source pixels.
  ValidityMask visible;  ///< M_vis, source pixels.
  ValidityMask front;    ///< M_front, source pixels.
};

/// What was done for one frame.
struct FrameReport {
  int passes = 0;       ///< Renderings made: 3 at most.
  std::string skipped;  ///< Empty, or why fewer passes were enough.
  double seconds = 0;
  std::size_t points = 0;  ///< Points of M^s.
  std::size_t drawn = 0;   ///< Points that went into the final rendering.
};

/// Renders a path frame by frame and remembers M_vis between frames.
class OcclusionRenderer {
 public:
  /// Both references outlive the renderer. Throws std::invalid_argument for options out of range.
  OcclusionRenderer(Rasterizer& rasterizer, ThreadPool& pool, OcclusionOptions options);
  ~OcclusionRenderer();

  /// Renders the next frame of the path. `masks` may be null. Throws std::invalid_argument when sizes disagree, or when
  /// the source's size changes along the path while M_vis accumulates.
  FrameReport render(const SourceFrame& source, const Camera& target, RenderedFrame& out, FrameMasks* masks = nullptr);

  /// Forgets M_vis: the next frame starts a new path.
  void restart();

  const OcclusionOptions& options() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// M_front alone: 1 where n . v > cos_alpha. Points with invalid depth are 0.
ValidityMask front_mask(const PointGrid& points, const Camera& target, double cos_alpha, ThreadPool& pool);
/// The same into a mask that is used again and again.
void front_mask(const PointGrid& points, const Camera& target, double cos_alpha, ThreadPool& pool, ValidityMask& out);

}  // namespace uwv
