// SPDX-License-Identifier: Apache-2.0
#include <filesystem>

#include "bench/accuracy.h"
#include "uwv/io/cameras_file.h"
#include "uwv/io/depth_file.h"
#include "uwv/io/image_file.h"

namespace uwv::bench {

std::vector<Table> save_scene(const BenchOptions& options) {
  options.check();
  const std::filesystem::path folder = options.out;
  std::error_code problem;
  std::filesystem::create_directories(folder, problem);
  if (problem) fail(ErrorCode::output_failed, "{}: cannot be made: {}", options.out, problem.message());
  ThreadPool pool(options.threads);
  const StockScene stock = scene_named(options.scene, options.size);
  constexpr int rays = 4;  // a side: these pictures are looked at, not measured
  const SyntheticFrame seen = render(stock.scene, stock.source, 0, pool, rays);
  write_png((folder / "colour.png").string(), seen.colour);
  write_depth_file((folder / "depth.npy").string(), seen.depth);
  write_cameras((folder / "cameras.json").string(), {.cameras = {stock.source}, .times = {0}}, CamerasFormat::uwv);

  const double radius = (stock.subject_in_world - stock.source.world_from_cam.translation).norm();
  Table table(options.out, {"scene", "size", "distance_to_subject"});
  table.add({stock.name, fmt::format("{}x{}", options.size.width, options.size.height), radius});
  return {table};
}

}  // namespace uwv::bench
