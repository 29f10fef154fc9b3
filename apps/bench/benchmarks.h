// SPDX-License-Identifier: Apache-2.0
// What uwv_bench measures. Each function prints nothing; it returns its tables.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "bench/table.h"
#include "uwv/core/image.h"

namespace uwv::bench {

struct BenchOptions {
  Size size{832, 480};
  std::vector<Size> sizes;                  ///< Of the speed tables.
  int runs = 9;                             ///< Measured runs a figure; the median is reported.
  int threads = 0;                          ///< 0 = all processors.
  bool gl = true;                           ///< Also measure OpenGL where a backend works.
  std::string scene = "sphere_floor_wall";  ///< Stock scene of the accuracy tables, or to be saved.
  int steps = 8;                            ///< Frames of the path to each angle in the accuracy tables.
  std::string plot;                         ///< SVG file that shows the options of the accuracy table; empty = none.

  // Real second views; see real_pairs.h.
  std::string motorcycle = ".cache/demo";    ///< Folder of the stereo pair; left out when it isn't there.
  std::string rgbd;                          ///< Folder of a depth camera's recording; empty = left out.
  std::vector<std::pair<long, long>> pairs;  ///< Its frames: source, target.
  bool no_resize = false;                    ///< Pictures at their own size, not at the one uwv_app would work at.

  // The clip from models; see dungeon_clip.h.
  std::string models;  ///< Folder of the models.
  int frames = 81;     ///< Of the clip to be made; of a recording, at most so many are taken.
  bool figure = true;  ///< A figure walks through the clip.
  double texture = 0.4, travel = 1, figure_distance = 4;  ///< See DungeonOptions.

  // Cameras and depth from pictures; see geometry.h and stereo_pairs.h.
  std::string recording;       ///< Folder of a clip with known cameras and depth; see true_clip.h.
  long start = 0, stride = 1;  ///< Of its frames: start, start + stride, ...
  std::vector<std::string> tables{"cameras", "depth", "stages", "views"};  ///< Which to make.
  int mvs_runs = 1;                                                        ///< Of each option of multi-view stereo.
  std::vector<std::string> stereo;                                         ///< Folders of stereo pairs.
  std::vector<std::string> cases;                                          ///< Which rendered clips; empty = all.
  std::string colmap_folder;     ///< Also run COLMAP, which works there; empty = left out.
  double colmap_patience = 600;  ///< Seconds for each of its runs.

  std::string out;  ///< Folder a scene or clip is saved into.
  void check() const;
};

/// Milliseconds and points per second: each primitive on each renderer, and Algorithm 1 by kernel and visibility.
std::vector<Table> render_speed(const BenchOptions& options);

/// Each option against the truth of a synthetic scene at growing angles, with its time beside it; what picture size,
/// width of depth, left-out passes and long paths do.
std::vector<Table> render_accuracy(const BenchOptions& options);

/// Each method and option against what a second real camera saw.
std::vector<Table> real_views(const BenchOptions& options);

/// Aligning relative to reference depth: losses and shares of samples, ways of smoothing.
std::vector<Table> alignment_accuracy(const BenchOptions& options);

/// Saves a stock scene as uwv_app's input: colour.png, depth.npy (scene units) and cameras.json. The table tells how
/// far away the scene's subject is, for trajectories that orbit it.
std::vector<Table> save_scene(const BenchOptions& options);

/// Cameras and depth found from the pictures of a clip, against its truth; novel views made with them; their time.
std::vector<Table> geometry(const BenchOptions& options);

/// Depth of stereo pairs by the same matcher as clips', with known cameras.
std::vector<Table> stereo_depth(const BenchOptions& options);

/// What moves before a moving camera, and the background behind it, against a synthetic scene.
std::vector<Table> moving(const BenchOptions& options);

/// Cameras and depth of clips rendered from models, from easy to hopeless, ours and COLMAP's.
std::vector<Table> rendered_clips(const BenchOptions& options);

/// Saves a clip rendered from models with all that is true about it: image/*.png and clip.mp4, depth.npz (scene units),
/// cameras.json, and foreground/*.png, white where the figure is.
std::vector<Table> save_clip(const BenchOptions& options);

}  // namespace uwv::bench
