// SPDX-License-Identifier: Apache-2.0
// What the tables of `uwv_bench accuracy` share: a stock scene, the frame its camera took, and paths followed from it.
#pragma once

#include <memory>
#include <string>

#include "bench/benchmarks.h"
#include "uwv/eval/path_truth.h"
#include "uwv/render/occlusion.h"

namespace uwv::bench {

/// The stock scene of that name; an unknown one is Error(value_invalid) listing those there are.
StockScene scene_named(const std::string& name, Size size);

/// A scene, what its camera saw, and the renderer under test.
struct Lab {
  Lab(StockScene stock, ThreadPool& threads);

  ThreadPool& pool;
  std::unique_ptr<Rasterizer> rasterizer;
  StockScene scene;
  SyntheticFrame seen;  ///< By the source camera, 2x2 rays a pixel.

  /// The source frame, with the scene's exact depth.
  SourceFrame source() const;
  /// The orbit to `degrees` in `steps` frames, and what is true at its end.
  PathTruth orbit(double degrees, int steps) const;
  /// What a camera really sees.
  SyntheticFrame view(const Camera& camera) const { return render(scene.scene, camera, 0, pool, 2); }
};

/// The default for synthetic scenes: their depth is exact and the truth is about every pixel, so nothing is filtered.
OcclusionOptions unfiltered();

/// The end of a path.
struct Followed {
  RenderedFrame frame;
  FrameMasks masks;
  double ms = 0;  ///< Of a frame, the median: one frame the machine held up does not count.
};

/// Renders `source` along the path as a video would be: everything is computed anew for each frame.
Followed follow(const Lab& lab, const OcclusionOptions& options, SourceFrame source,
                const std::vector<Camera>& cameras);

// The tables, each in a file of its own.

/// One option changed at a time, at growing angles; written to options.plot as well when that is set.
Table option_table(const Lab& lab, const BenchOptions& options);
/// The same path at full, half and quarter size, each judged at its own size.
Table resolution_table(const BenchOptions& options, ThreadPool& pool);
/// Depth as 32-bit float, 16-bit float and whole millimetres.
Table depth_width_table(const Lab& lab, const BenchOptions& options);
/// What the reliability filter costs sharp depth and gains smeared depth.
Table smeared_depth_table(const Lab& lab);
/// What leaving out unneeded passes saves, and that it changes nothing.
Table skipped_passes_table(const Lab& lab, const BenchOptions& options);
/// M_vis after many frames to the same angle: what a product of small losses comes to.
Table long_paths_table(const Lab& lab);

}  // namespace uwv::bench
