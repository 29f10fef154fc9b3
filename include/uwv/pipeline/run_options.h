// SPDX-License-Identifier: Apache-2.0
// Everything the main job can be asked to do, in one struct.
//
// A field, its command line flag and its key in run.json share one name: `max_side` is --max-side and "max_side". The
// table in option_table.h holds the help texts; what a value means in full is said here.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "uwv/core/camera.h"
#include "uwv/geometry/depth_alignment.h"
#include "uwv/geometry/multi_view_stereo.h"
#include "uwv/geometry/structure_from_motion.h"
#include "uwv/model/model_options.h"
#include "uwv/render/gl_context.h"
#include "uwv/render/occlusion.h"

namespace uwv {

/// Where pixel centres lie in intrinsics given by number (see docs/conventions.md).
enum class PixelCentre {
  half,     ///< At (x + 0.5, y + 0.5): ours, COLMAP's.
  integer,  ///< At (x, y): OpenCV's, the reference code's, most calibration files'.
};

/// Who draws.
enum class RendererChoice {
  automatic,  ///< GL where a GPU does it, CPU where GL would only be emulated.
  gl,
  cpu,
};

/// Whether depths on edges are dropped.
enum class ReliabilityChoice {
  automatic,  ///< Where the first frame's depth edges are smeared, as estimators do; see EdgeSharpness.
  on,
  off,
};

/// Which points a frame is drawn from.
enum class CloudChoice {
  automatic,  ///< merged where the camera moved and the path shows what single frames do not see.
  per_frame,  ///< Its own.
  merged,     ///< Its own, and where they leave a pixel open, what other frames measured of the scene at rest.
};

/// Whether the background behind the foreground is drawn.
enum class LayerChoice {
  automatic,  ///< Where something moves or the path uncovers enough.
  on,
  off,  ///< Nor is it completed when geometry is estimated.
};

/// Where depth and source cameras come from.
enum class GeometryChoice {
  automatic,  ///< Files where they are given, a network where one is; else measured where the camera moved, assumed
              ///< where it did not.
  import,     ///< Files: --depth or --disparity.
  network,    ///< --depth-model, a network exported to TorchScript; cameras as for sfm where it gives none.
  sfm,        ///< Structure from motion and multi-view stereo; an error where the pictures do not allow it.
  prior,      ///< Layers on a ground plane: an assumption, for photos and cameras that stood still.
};

/// What the values of a depth file are. Only the user knows: nothing is guessed.
enum class DepthKind {
  depth,             ///< Distance along the optical axis.
  inverse,           ///< 1 / depth.
  relative_inverse,  ///< a / depth + b with unknown a and b, per frame: video depth networks. Brought to scale.
  relative_depth,    ///< a * depth + b with unknown a and b, per frame. Brought to scale.
};

/// How the rendered depth is stored.
enum class DepthOutput { npz, png16, exr, none };

/// What fills the holes of the rendering.
enum class Completion {
  none,     ///< Nothing: colour.mp4 and generate_mask.mp4 are the result.
  inpaint,  ///< A draft by image inpainting (Telea 2004), frame by frame, without any model.
  model,    ///< The video diffusion model in --model.
};

struct RunOptions {
  // -- input ---------------------------------------------------------------------------------------------------------
  std::string video;  ///< Video, picture (a photo), folder of pictures or pattern. Required.
  std::string depth;  ///< Depth clip: .npz .npy .png .exr .pfm, a folder or a pattern of them, or the
                      ///< folder `geometry` of an earlier run. Empty: estimated, see `geometry`.
  DepthKind depth_kind = DepthKind::depth;  ///< What the values of `depth` are. Relative kinds need `geometry` to come
                                            ///< to scale: the cameras are estimated too.
  std::optional<double> depth_scale;        ///< Stored value * scale = scene units. Unset: 1, or 0.001 for 16-bit PNG.
  std::string depth_key;                    ///< Member of an .npz. Empty: the first of the usual names.
  std::string disparity;  ///< Stereo disparity in pixels of the full-size picture, instead of depth; invalid where it
                          ///< is NaN, infinite, or not positive.
  double baseline = 0;    ///< Distance of the stereo pair, scene units. depth = fx * baseline / (disparity + doffs).
  double doffs = 0;       ///< cx_right - cx_left of the pair, pixels of the full-size picture.
  bool static_depth = false;  ///< One depth picture serves all frames of a locked-off video.
  std::string cameras;        ///< Source cameras, one per frame of the clip. Empty: a locked-off camera.
  std::string foreground;     ///< Mask clip, white = moving foreground.
  std::string background;  ///< The clip without its foreground, from elsewhere. With estimated geometry it stands for
                           ///< what would be completed; with `depth` it needs `background_depth`.
  std::string background_depth;  ///< Its depth, of the same kind, scale and key as `depth`.
  std::string normals;           ///< .npy/.npz, (h,w,3) or (n,h,w,3), camera frame. Empty: normals come from depth.
  std::optional<double> fx, fy, cx, cy;  ///< Intrinsics in pixels of the full-size picture. fy unset: fx; centre unset:
                                         ///< the picture's. They take precedence over those of `cameras`.
  std::optional<double> fov;             ///< Horizontal field of view in degrees, (0, 180), instead of fx.
  PixelCentre pixel_centre = PixelCentre::half;  ///< How cx and cy count.
  long start = 0;                                ///< First frame of the clip that is used.
  long stride = 1;                               ///< Every how many-th frame is used.
  long max_frames = 81;                          ///< At most so many are used; 0 = all. 81 is what the model takes.

  // -- geometry, where no depth is given
  // -------------------------------------------------------------------------------
  GeometryChoice geometry = GeometryChoice::automatic;
  std::string depth_model;                      ///< Folder of a depth network (docs/depth-models.md).
  LayerChoice layers = LayerChoice::automatic;  ///< Let the completed background show where the foreground moved away.
  std::string saliency_model;  ///< What finds the first frame's foreground: u2netp.onnx, or the folder of a TorchScript
                               ///< network (docs/depth-models.md). Empty: u2netp.onnx where scripts/setup puts it;
                               ///< without it a contrast method.
  std::string segmenter;       ///< Folder of a TorchScript network that follows it through the clip. Empty: flow does.
  AlignmentSmoothing depth_smoothing =
      AlignmentSmoothing::joint;  ///< How relative depth's lines hang together; none for depth whose unit jumps.
  int max_features = SfmOptions{}.max_features;
  double min_parallax_px = SfmOptions{}.min_parallax_px;
  int mvs_neighbours = MvsOptions{}.neighbours;
  int mvs_planes = MvsOptions{}.planes;
  double mvs_scale = MvsOptions{}.scale;
  int mvs_key_stride = 0;  ///< 0 = by the parallax between frames (see plan_geometry), else every so many-th.

  // -- picture size --------------------------------------------------------------------------------------------------
  Size size;               ///< Exact working size. {0, 0}: the token budget of the model decides.
  bool no_resize = false;  ///< Work at the clip's own size.
  int max_side = 1024;     ///< Longest side the token budget may choose.

  // -- camera path ---------------------------------------------------------------------------------------------------
  std::string traj = "free1";       ///< Trajectory file (docs/trajectories.md) or the name of a preset.
  std::optional<long> frames;       ///< Target frames. Unset: the file's; else the clip's, 81 for a photo.
  bool follow_source = false;       ///< Applies the path to the moving source camera, as the file's key does.
  std::optional<double> elevation;  ///< Degrees; see docs/trajectories.md. Unset: the file's.
  std::optional<double> radius;     ///< Distance to the orbit's centre, scene units. Unset: the file's, else the
                                    ///< median depth of the foreground (of everything without one) in the first frame.
  std::optional<double> radius_scale;  ///< Scales offsets of the path. Unset: the file's.

  // -- rendering -----------------------------------------------------------------------------------------------------
  RendererChoice renderer = RendererChoice::automatic;
  GlBackend gl = GlBackend::automatic;  ///< Which headless OpenGL, where GL is used.
  CloudChoice cloud = CloudChoice::automatic;
  /// Fewer points where surfaces are flat, so that nothing moves by more than so many pixels; 0 = keep all points.
  /// Unset: where it pays, which is nowhere yet (docs/performance.md).
  std::optional<double> max_error;
  Kernel kernel = OcclusionOptions{}.kernel;
  Visibility visibility = OcclusionOptions{}.visibility;
  /// Unset: none where the source camera moves (a pixel of its picture is another point of the scene each time), else
  /// foreground where there is one, else the paper's product.
  std::optional<Accumulation> accumulation;
  double alpha = 90;          ///< Angle of the normal filter, degrees in [0, 180].
  bool normal_filter = true;  ///< False draws back faces and grazing surfaces too.
  float point_size = FootprintOptions{}.point_size;
  float max_footprint = FootprintOptions{}.max_footprint;
  float return_size = OcclusionOptions{}.return_size;  ///< Scales footprints on the way back of reproject.
  float fringe = OcclusionOptions{}.fringe;            ///< Pixels a surface's rim may reach into what nothing covers.
  std::optional<double> log_depth_max;   ///< See SoftSplatOptions, for bilinear. Unset: each rendering's own.
  std::optional<float> depth_tolerance;  ///< Unset: 0.02 for ztest, which needs some, else 0.
  ReliabilityChoice reliability = ReliabilityChoice::automatic;       ///< The reliable-depth filter.
  bool dropped_points_hide = OcclusionOptions{}.dropped_points_hide;  ///< Points it drops still hide what is behind.
  float reliability_ratio = ReliabilityOptions{}.ratio;
  int reliability_window = ReliabilityOptions{}.window;
  int slope_radius = SlopeOptions{}.radius;
  float slope_discontinuity = SlopeOptions{}.discontinuity;
  std::optional<double> max_tilt;  ///< Degrees in (0, 90]; see SlopeOptions::max_tilt. Unset: its default, 86.
  bool foreground_ring = false;  ///< Drop depth in a band around the foreground, as the official code does, which keeps
                                 ///< what smears between the two out of the picture.
  bool skip_unneeded = true;     ///< Leave out passes that cannot change a pixel.
  bool keep_source = true;  ///< A frame seen from the source's own camera is the source picture, all of it known (the
                            ///< reference does so with frame 0), rather than its rendering.
  int threads = 0;          ///< Rendering threads; 0 = one per processor. Never changes a byte of the result.

  // -- output --------------------------------------------------------------------------------------------------------
  std::string out;            ///< Folder. Empty: "<clip's stem>_uwv" in the current folder.
  std::optional<double> fps;  ///< Of the videos written. Unset: the trajectory's, else the clip's / stride, else 16.
  int crf = 10;               ///< H.264 quality of colour, 0 (lossless) .. 51; 10 is the reference's choice.
  DepthOutput depth_format = DepthOutput::npz;
  bool save_masks = false;                 ///< Also M', M'', M_vis and M_front.
  std::vector<long> ply;                   ///< Source frames (counted after start and stride) to write as point clouds.
  int contact_sheet = 5;                   ///< Columns of contact_sheet.png; 0 = none.
  Completion complete = Completion::none;  ///< With `model` given, model.
  bool overwrite = false;                  ///< Redo finished stages, and replace files that are not ours.

  // -- completion by the video diffusion model -----------------------------------------------------------------------
  ModelOptions diffusion;  ///< Its fields are options of their own: --model, --steps, ..

  // -- comparison with a real picture --------------------------------------------------------------------------------
  std::string eval_reference;  ///< Picture of source frame 0's moment from another camera, to compare a rendering with.
  std::string eval_cameras;    ///< A cameras file whose first camera took it, in the world of `cameras`. Files without
                               ///< intrinsics: those of source frame 0.

  /// Throws std::invalid_argument, naming the flag, when a value is out of range or two contradict each other. Files
  /// are not looked at.
  void check() const;

  /// `out`, or what stands for it when empty.
  std::string out_folder() const;
};

/// What fills the holes: the model where one is named.
Completion completion_of(const RunOptions& options);

/// The part of the options the renderer sees. The reliability filter is on only where it is asked for: whether
/// `automatic` needs it is known when the depth has been seen.
OcclusionOptions occlusion_options(const RunOptions& options);

/// The horizontal field of view, in degrees, of a lens nobody tells anything about: a phone's main camera held upright,
/// or 35 mm film behind a 35 mm lens.
inline constexpr double assumed_fov_deg = 60;
Intrinsics assumed_intrinsics(Size full_size);

/// True when the values are known only up to an unknown line.
bool is_relative(DepthKind kind);

/// True when neither depth nor disparity is given, so that it has to be estimated, or when it is but has no scale.
bool estimates_geometry(const RunOptions& options);

/// The parts of the options that the estimation sees; `intrinsics` stay unset.
SfmOptions sfm_options(const RunOptions& options);
MvsOptions mvs_options(const RunOptions& options);

/// The intrinsics asked for by number (fx.. or fov), for a picture of `full_size` pixels and our pixel centres; nothing
/// when neither was given.
std::optional<Intrinsics> intrinsics_by_number(const RunOptions& options, Size full_size);

}  // namespace uwv
