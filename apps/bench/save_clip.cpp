// SPDX-License-Identifier: Apache-2.0
#include <filesystem>

#include "bench/benchmarks.h"
#include "bench/dungeon_clip.h"
#include "bench/timing.h"
#include "uwv/io/cameras_file.h"
#include "uwv/io/depth_writer.h"
#include "uwv/io/image_file.h"
#include "uwv/io/video_writer.h"

namespace uwv::bench {
namespace {

void make_folder(const std::filesystem::path& folder) {
  std::error_code problem;
  std::filesystem::create_directories(folder, problem);
  if (problem) fail(ErrorCode::output_failed, "{}: cannot be made: {}", folder.string(), problem.message());
}

/// White where the figure is.
ImageRgb figure_picture(const Image<std::int32_t>& object, int figure) {
  ImageRgb out(object.size());
  for (std::size_t i = 0; i < out.pixels().size(); ++i)
    if (object.pixels()[i] == figure) out.pixels()[i] = {255, 255, 255};
  return out;
}

}  // namespace

std::vector<Table> save_clip(const BenchOptions& options) {
  options.check();
  const std::filesystem::path folder = options.out;
  make_folder(folder / "image");
  const DungeonClip clip =
      dungeon_clip(options.models, options.size,
                   {options.frames, options.texture, options.travel, options.figure, options.figure_distance});
  if (clip.figure >= 0) make_folder(folder / "foreground");

  ThreadPool pool(options.threads);
  Monitor monitor;
  VideoWriter video((folder / "clip.mp4").string(), options.size, {.fps = clip.fps});
  const auto depths = make_depth_writer((folder / "depth.npz").string(), {}, options.size, options.frames, monitor);
  CameraTrack track;
  std::size_t figure_pixels = 0;
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < options.frames; ++i) {
    const Camera& camera = clip.cameras[static_cast<std::size_t>(i)];
    const double time = i / clip.fps;
    const SyntheticFrame frame = render_frame(clip, i, pool);
    const std::string name = fmt::format("{:05}.png", i);
    write_png((folder / "image" / name).string(), frame.colour);
    if (clip.figure >= 0) {
      const ImageRgb figure = figure_picture(frame.object, clip.figure);
      write_png((folder / "foreground" / name).string(), figure);
      figure_pixels +=
          static_cast<std::size_t>(std::count(figure.pixels().begin(), figure.pixels().end(), Rgb8{255, 255, 255}));
    }
    video.write(frame.colour);
    depths->write(frame.depth);
    track.cameras.push_back(camera);
    track.times.push_back(time);
  }
  video.finish();
  depths->finish();
  write_cameras((folder / "cameras.json").string(), track, CamerasFormat::uwv);

  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const double pixels = static_cast<double>(options.size.pixels()) * options.frames;
  Table table(options.out, {"frames", "size", "figure_%", "seconds_a_frame"});
  table.add({options.frames, fmt::format("{}x{}", options.size.width, options.size.height),
             100 * static_cast<double>(figure_pixels) / pixels, seconds / options.frames});
  return {table};
}

}  // namespace uwv::bench
