// SPDX-License-Identifier: Apache-2.0
// What the tables of `uwv_bench geometry` share.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "bench/benchmarks.h"
#include "bench/geometry_scores.h"
#include "uwv/geometry/multi_view_stereo.h"
#include "uwv/geometry/structure_from_motion.h"

namespace uwv::bench {

/// Seconds of each stage, by what the work reports: what passes until a report belongs to the stage reported.
class StageClock : public Monitor {
 public:
  bool progress(std::string_view stage, long done, long total) override;
  /// In the order of their first report.
  const std::vector<std::pair<std::string, double>>& stages() const { return stages_; }

 private:
  std::vector<std::pair<std::string, double>> stages_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

struct FoundCameras {
  SfmResult result;
  double processor_seconds = 0;
};

/// What a table's times have to be read with: who else was at work. Load is the number of threads that wanted a
/// processor, on average over a minute.
class Machine {
 public:
  /// From now on.
  explicit Machine(const ThreadPool& pool);
  /// Until now.
  Table table() const;

 private:
  static double load();
  int threads_;
  double load_before_;
};

/// A clip, and cameras found from its pictures alone.
struct FoundClip {
  const TrueClip& truth;
  ThreadPool& pool;
  FoundCameras known_focal;
  FoundCameras own_focal;
};

/// One way to run multi-view stereo, and its name in tables and plots.
struct MvsVariant {
  std::string name;
  MvsOptions options;
};

struct MvsMeasured {
  MvsSummary summary;
  DepthScore score;
  double seconds = 0, processor_seconds = 0;  ///< For the clip, medians of the runs.
};

/// What multi-view stereo is given beside the clip's pictures.
struct MvsInput {
  std::span<const Camera> cameras;
  std::span<const ScenePoint> points;
  std::span<const ValidityMask> static_pixels;
};

/// Runs it and judges its depth; `scale` as for score_depth().
MvsMeasured measure_stereo(const TrueClip& clip, const MvsInput& input, const MvsOptions& options, double scale,
                           int runs, ThreadPool& pool);
/// The same with nothing but the clip's pictures: cameras that were found (they must be `moving`), and what moves
/// found as well, as uwv_app does.
MvsMeasured measure_found(const FoundClip& clip, const SfmResult& cameras, int runs);
/// What tables say of it.
const std::vector<std::string>& depth_columns();
std::vector<nlohmann::ordered_json> depth_figures(const MvsMeasured& measured, std::size_t frames);

/// Scene points as structure from motion would give them, without error: a grid in every fifth frame (every one of a
/// short clip), seen in whichever frames show the same surface there.
std::vector<ScenePoint> true_points(const TrueClip& clip);

/// Structure from motion with and without the focal length.
FoundClip find_cameras(const TrueClip& clip, ThreadPool& pool);
/// A table for add_cameras().
Table camera_table(const std::string& name);
/// Rows of a clip: the cameras found, and COLMAP's where there is `options.colmap_folder`.
void add_cameras(Table& table, const FoundClip& clip, const BenchOptions& options);
/// One option of structure from motion changed at a time, with the focal length known and not.
Table camera_option_table(const TrueClip& clip, ThreadPool& pool);
/// Where the time goes, structure from motion and stereo with default options.
Table stage_table(const TrueClip& clip, ThreadPool& pool);
/// One option of multi-view stereo changed at a time, and some together, with true cameras; then all defaults with
/// found cameras. One factor is taken out of all depth: found scenes have a scale of their own, and a recording's poses
/// may disagree with its depth by more than stereo errs. Drawn into `options.plot` unless that is empty.
Table depth_table(const FoundClip& clip, const BenchOptions& options);
/// Flicker of relative depth aligned by each way of smoothing. Empty where no cameras are found.
Table alignment_flicker_table(const TrueClip& truth, ThreadPool& pool);
/// Pictures of other frames, rendered from one frame and its depth: true or found, with true or found cameras.
Table view_table(const FoundClip& clip, const BenchOptions& options);
/// What each choice of plan_geometry() costs and brings: clouds, key frames, points.
std::vector<Table> choice_tables(const TrueClip& clip, const BenchOptions& options, ThreadPool& pool);

}  // namespace uwv::bench
