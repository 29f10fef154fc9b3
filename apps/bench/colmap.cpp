// SPDX-License-Identifier: Apache-2.0
#include "bench/colmap.h"

#include <charconv>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "bench/child_process.h"
#include "uwv/core/error.h"
#include "uwv/io/image_file.h"

namespace uwv::bench {
namespace {

namespace fs = std::filesystem;

/// One run of COLMAP: a folder, and how much patience is left.
class Colmap {
 public:
  Colmap(fs::path folder, double patience) : folder_(std::move(folder)), patience_(patience) {}

  fs::path path(const char* name) const { return folder_ / name; }

  /// After a failure nothing runs any more.
  void run(const std::string& step, std::vector<std::string> flags) {
    if (!failure_.empty()) return;
    flags.insert(flags.begin(), {"colmap", step});
    // Qt would look for a display otherwise, even without a window.
    const ChildResult result = run_child(flags, {"QT_QPA_PLATFORM=offscreen"}, path("log.txt").string(), patience_);
    patience_ -= result.seconds;
    seconds_ += result.seconds;
    processor_seconds_ += result.processor_seconds;
    if (!result.started)
      failure_ = "colmap is not installed";
    else if (result.timed_out)
      failure_ = fmt::format("{} took too long", step);
    else if (result.status != 0)
      failure_ = fmt::format("{} failed, see {}", step, path("log.txt").string());
  }

  const std::string& failure() const { return failure_; }
  double seconds() const { return seconds_; }
  double processor_seconds() const { return processor_seconds_; }

 private:
  fs::path folder_;
  double patience_;
  double seconds_ = 0, processor_seconds_ = 0;
  std::string failure_;
};

void write_pictures(std::span<const ImageRgb> frames, const fs::path& folder) {
  std::error_code problem;
  fs::create_directories(folder, problem);
  if (problem) fail(ErrorCode::output_failed, "{}: cannot be made: {}", folder.string(), problem.message());
  for (std::size_t i = 0; i < frames.size(); ++i) write_png((folder / fmt::format("{:05}.png", i)).string(), frames[i]);
}

/// The model with the most pictures, as text in "text"; false when there is none.
bool largest_model(Colmap& colmap) {
  fs::path largest;
  std::uintmax_t size = 0;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(colmap.path("sparse"), ignored)) {
    const std::uintmax_t pictures = fs::file_size(entry.path() / "images.bin", ignored);
    if (ignored || pictures <= size) continue;
    size = pictures;
    largest = entry.path();
  }
  if (largest.empty()) return false;
  fs::create_directories(colmap.path("text"), ignored);
  colmap.run("model_converter",
             {"--input_path", largest.string(), "--output_path", colmap.path("text").string(), "--output_type", "TXT"});
  return colmap.failure().empty();
}

/// Lines that are no comments.
bool next_line(std::istream& file, std::string& line) {
  while (std::getline(file, line))
    if (line.empty() || line[0] != '#') return true;
  return false;
}

/// The lens of a cameras.txt with one SIMPLE_PINHOLE or PINHOLE camera. COLMAP's pixel centres are ours.
bool read_lens(std::istream& file, Intrinsics& lens) {
  std::string line, model;
  if (!next_line(file, line)) return false;
  std::istringstream words(line);
  long id = 0, width = 0, height = 0;
  if (!(words >> id >> model >> width >> height >> lens.fx)) return false;
  lens.fy = lens.fx;
  if (model == "PINHOLE" && !(words >> lens.fy)) return false;
  return static_cast<bool>(words >> lens.cx >> lens.cy);
}

/// The poses of an images.txt, for frames named by their number ("00012.png"). Returns how many there were.
int read_poses(std::istream& file, std::vector<Camera>& cameras, std::vector<std::uint8_t>& registered) {
  int poses = 0;
  for (std::string line, points; next_line(file, line); std::getline(file, points)) {
    std::istringstream words(line);
    long id = 0, lens = 0;
    double qw = 0, qx = 0, qy = 0, qz = 0;
    Eigen::Vector3d t;
    std::string name;
    if (!(words >> id >> qw >> qx >> qy >> qz >> t.x() >> t.y() >> t.z() >> lens >> name)) continue;
    std::size_t frame = 0;
    const auto number = std::from_chars(name.data(), name.data() + name.size(), frame);
    if (number.ec != std::errc() || frame >= cameras.size()) continue;
    const Rigid3 cam_from_world{Eigen::Quaterniond(qw, qx, qy, qz).normalized().toRotationMatrix(), t};
    cameras[frame].world_from_cam = cam_from_world.inverse();
    registered[frame] = 1;
    ++poses;
  }
  return poses;
}

}  // namespace

ColmapResult run_colmap(std::span<const ImageRgb> frames, const std::string& folder, const ColmapOptions& options) {
  require(!frames.empty(), "COLMAP needs at least one picture");
  // What an earlier run left would be taken for this run's.
  std::error_code ignored;
  for (const char* old : {"image", "sparse", "text", "database.db", "log.txt"})
    fs::remove_all(fs::path(folder) / old, ignored);
  write_pictures(frames, fs::path(folder) / "image");

  Colmap colmap(folder, options.patience_seconds);
  fs::create_directories(colmap.path("sparse"), ignored);
  const std::string database = colmap.path("database.db").string(), pictures = colmap.path("image").string();
  const std::string threads = std::to_string(options.threads == 0 ? -1 : options.threads);
  std::vector<std::string> lens{"--ImageReader.camera_model", "SIMPLE_PINHOLE"};
  std::string keep = "1";
  if (options.intrinsics) {
    const Intrinsics& known = *options.intrinsics;
    lens = {"--ImageReader.camera_model", "PINHOLE", "--ImageReader.camera_params",
            fmt::format("{},{},{},{}", known.fx, known.fy, known.cx, known.cy)};
    keep = "0";
  }
  ColmapResult result;
  std::vector<std::string> features{"--database_path",
                                    database,
                                    "--image_path",
                                    pictures,
                                    "--ImageReader.single_camera",
                                    "1",
                                    "--SiftExtraction.use_gpu",
                                    "0",
                                    "--SiftExtraction.num_threads",
                                    threads};
  features.insert(features.end(), lens.begin(), lens.end());
  colmap.run("feature_extractor", features);
  colmap.run("sequential_matcher", {"--database_path", database, "--SiftMatching.use_gpu", "0",
                                    "--SiftMatching.num_threads", threads, "--SequentialMatching.overlap",
                                    std::to_string(options.overlap), "--SequentialMatching.loop_detection", "0"});
  colmap.run("mapper", {"--database_path", database, "--image_path", pictures, "--output_path",
                        colmap.path("sparse").string(), "--Mapper.num_threads", threads,
                        "--Mapper.ba_refine_focal_length", keep, "--Mapper.ba_refine_extra_params", "0"});
  result.seconds = colmap.seconds();
  result.processor_seconds = colmap.processor_seconds();
  if (colmap.failure().empty() && !largest_model(colmap)) result.failure = "mapper made no model";
  if (!colmap.failure().empty()) result.failure = colmap.failure();
  if (!result.failure.empty()) return result;

  Camera camera{{}, {}, frames.front().size()};
  std::ifstream lens_file(colmap.path("text") / "cameras.txt"), pose_file(colmap.path("text") / "images.txt");
  if (!read_lens(lens_file, camera.intrinsics)) result.failure = "its cameras.txt cannot be read";
  result.cameras.assign(frames.size(), camera);
  result.registered.assign(frames.size(), 0);
  if (read_poses(pose_file, result.cameras, result.registered) == 0) result.failure = "it registered no picture";
  std::ifstream point_file(colmap.path("text") / "points3D.txt");
  for (std::string line; next_line(point_file, line);) ++result.points;
  return result;
}

}  // namespace uwv::bench
