// SPDX-License-Identifier: Apache-2.0
// Runs whose depth a network gives: what is made of each kind of answer. The networks here know the truth and tell it
// in their own unit.
#include <gmock/gmock.h>

#include <deque>

#include "pipeline/filmed_room.h"
#include "uwv/io/cameras_file.h"
#include "uwv/io/frame_source.h"
#include "uwv/io/npy.h"

namespace uwv {
namespace {

using test::WarningMonitor;
using ::testing::Contains;
using ::testing::HasSubstr;

/// Gives its answers one after the other.
class ScriptedNetwork : public DepthNetwork {
 public:
  explicit ScriptedNetwork(std::deque<DepthNetworkResult> answers)
      : answers_(std::move(answers)), meaning_(answers_.front().meaning) {}
  const std::string& name() const override { return name_; }
  NetworkDepth meaning() const override { return meaning_; }
  Size input_size(Size frame) const override { return frame; }
  DepthNetworkResult run(std::span<const ImageRgb> frames, const DepthNetworkOptions&, ThreadPool&, Monitor&) override {
    DepthNetworkResult answer = answers_.at(0);
    answers_.pop_front();
    EXPECT_EQ(frames.size(), answer.frames.size());
    return answer;
  }

 private:
  std::string name_ = "scripted";
  std::deque<DepthNetworkResult> answers_;
  NetworkDepth meaning_;
};

class NetworkRun : public test::FilmedRoom {
 protected:
  /// The truth, each frame's depth z told as say(frame, z).
  DepthNetworkResult told(NetworkDepth meaning, const std::function<double(std::size_t, double)>& say) const {
    DepthNetworkResult answer;
    answer.meaning = meaning;
    for (std::size_t i = 0; i < depths_.size(); ++i) {
      FrameGeometry frame{DepthMap(depths_[i].size()), ConfidenceMap(depths_[i].size(), 0.75F)};
      for (std::size_t p = 0; p < frame.depth.pixels().size(); ++p)
        frame.depth.pixels()[p] = static_cast<float>(say(i, depths_[i].pixels()[p]));
      frame.confidence(0, 0) = 0;
      answer.frames.push_back(std::move(frame));
    }
    return answer;
  }

  RunSummary run_with(std::deque<DepthNetworkResult> answers) {
    RunComponents components;
    components.open_depth_network = [&](const std::string& folder) {
      EXPECT_EQ(folder, options_.depth_model);
      ++opened_;
      return std::make_unique<ScriptedNetwork>(answers);
    };
    options_.depth_model = folder_.file("clip");  // any folder: nothing of it is read
    return run(options_, monitor_, {}, components);
  }

  const nlohmann::ordered_json& facts_of(const RunSummary& summary) const { return summary.stages[0].facts; }

  /// How far the estimated camera got from where it began.
  double travelled() {
    const CameraTrack track =
        read_cameras(options_.out + "/geometry/cameras.json", {.size = {240, 136}, .intrinsics = {}}, monitor_);
    return (track.cameras.back().world_from_cam.translation - track.cameras.front().world_from_cam.translation).norm();
  }
  double truly_travelled() const {
    return (cameras_.back().world_from_cam.translation - cameras_.front().world_from_cam.translation).norm();
  }

  WarningMonitor monitor_;
  int opened_ = 0;
};

double metres(std::size_t, double z) { return z; }

TEST_F(NetworkRun, KeepsMetresAndScalesTheMeasuredCameras) {
  film(9, 1.5);
  const RunSummary summary = run_with({told(NetworkDepth::metric, metres)});
  const auto& facts = facts_of(summary);
  EXPECT_EQ(facts["provider"], "network") << facts.dump(1);
  EXPECT_EQ(facts["choice"]["reason"], "--depth-model is given");
  EXPECT_EQ(facts["network"]["unit"], "metres");
  const DepthFit fit = depth_fit();
  EXPECT_NEAR(fit.scale, 1, 0.02);
  EXPECT_LT(fit.error, 0.01);
  EXPECT_NEAR(travelled() / truly_travelled(), 1, 0.08) << "twelve degrees seen in 240 pixels tell it no better";
  NpyArrayReader confidence(options_.out + "/geometry/confidence.npz", "confidence");
  std::vector<float> values(240 * 136);
  confidence.read(4, std::span<float>(values));
  EXPECT_EQ(values[0], 0) << "what the network does not know stays unknown";
  EXPECT_NEAR(values[200] / 255, 0.75, 0.01);
}

TEST_F(NetworkRun, BringsInverseDepthOfAnyLineToTheCameras) {
  film(9, 1.5);
  DepthNetworkResult answer = told(NetworkDepth::inverse_affine, [](std::size_t i, double z) {
    return (40.0 + 3.0 * static_cast<double>(i % 3)) / z - 12.0;  // some of it below zero
  });
  answer.consistent = false;
  const auto least = std::min_element(answer.frames[0].depth.pixels().begin(), answer.frames[0].depth.pixels().end());
  ASSERT_LT(*least, 0) << "else the test does not ask what it should";
  const RunSummary summary = run_with({answer});
  EXPECT_EQ(facts_of(summary)["network"]["alignment"]["reference"], "reconstructed points");
  EXPECT_LT(depth_error(), 0.04);
}

TEST_F(NetworkRun, TakesTheNetworksCameras) {
  film(5, 1.5);
  DepthNetworkResult answer = told(NetworkDepth::up_to_scale, metres);
  for (const Camera& camera : cameras_) {
    answer.world_from_cam.push_back(cameras_[0].cam_from_world() * camera.world_from_cam);
    answer.intrinsics.push_back(camera.intrinsics);
  }
  options_.fov.reset();
  const RunSummary summary = run_with({answer});
  const auto& facts = facts_of(summary);
  EXPECT_THAT(facts["structure_from_motion"].get<std::string>(), HasSubstr("skipped"));
  EXPECT_NEAR(travelled(), truly_travelled(), 1e-9);
  EXPECT_EQ(depth_error(), 0);
  EXPECT_THAT(monitor_.warnings, ::testing::Not(Contains(HasSubstr("field of view"))));
}

TEST_F(NetworkRun, LooksBehindTheForegroundOfAPhotoWithTheSameNetwork) {
  film(1, 0);
  ImageRgb mask(Size{240, 136});
  for (int y = 50; y < 90; ++y)
    for (int x = 100; x < 140; ++x) mask(x, y) = {255, 255, 255};
  write_png(folder_.file("mask.png"), mask);
  options_.foreground = folder_.file("mask.png");
  options_.frames = 2;
  // What lies behind comes in another unit; the wall around the mask tells which.
  const RunSummary summary = run_with(
      {told(NetworkDepth::metric, metres), told(NetworkDepth::metric, [](std::size_t, double z) { return 2.5 * z; })});
  EXPECT_FALSE(facts_of(summary)["background"].is_string()) << facts_of(summary).dump(1);
  Monitor monitor;
  DepthMap behind;
  ASSERT_TRUE(open_depth(options_.out + "/geometry/background_depth.npz", {}, monitor)->read(0, behind));
  EXPECT_NEAR(behind(120, 70), depths_[0](120, 70), 1e-3 * depths_[0](120, 70));
}

TEST_F(NetworkRun, SteadiesANetworkThatSeesEachFrameAlone) {
  film(4, 0);
  DepthNetworkResult answer =
      told(NetworkDepth::up_to_scale, [](std::size_t i, double z) { return z * (1 + 0.3 * static_cast<double>(i)); });
  answer.consistent = false;
  options_.layers = LayerChoice::off;
  run_with({answer});
  EXPECT_LT(depth_error(), 1e-4);
}

TEST_F(NetworkRun, TakesScaleAndShiftFromAPriorWhereNothingMoves) {
  film(3, 0);
  options_.layers = LayerChoice::off;
  const DepthNetworkResult answer = told(NetworkDepth::inverse_affine, [](std::size_t, double z) { return 7 / z - 1; });
  const RunSummary summary = run_with({answer});
  EXPECT_EQ(facts_of(summary)["network"]["alignment"]["reference"], "prior");
  EXPECT_THAT(monitor_.warnings, Contains(HasSubstr("those of a prior")));
}

TEST_F(NetworkRun, SaysThatCamerasOfOtherShotsArePlaceholders) {
  film(9, 1.5);
  ThreadPool pool;
  const StockScene other = sphere_floor_wall({.size = {240, 136}});
  const SyntheticFrame seen = render(other.scene, other.source, 0, pool, 2);
  for (int i = 9; i < 12; ++i) {
    write_png(folder_.file(fmt::format("clip/{:03}.png", i)), seen.colour);
    depths_.push_back(seen.depth);
  }
  options_.layers = LayerChoice::off;
  const RunSummary summary = run_with({told(NetworkDepth::metric, metres)});
  EXPECT_EQ(facts_of(summary)["frames"], 12);
  EXPECT_FALSE(facts_of(summary).contains("other_shots")) << "the network saw every frame: nothing is assumed";
  EXPECT_THAT(monitor_.warnings, Contains(HasSubstr("the cameras of the others are placeholders")));
}

TEST_F(NetworkRun, PassesNormalsOn) {
  film(2, 0);
  options_.layers = LayerChoice::off;
  DepthNetworkResult answer = told(NetworkDepth::metric, metres);
  answer.normals.assign(2, NormalMap(Size{240, 136}, Eigen::Vector3f(0, 0.6F, -0.8F)));
  run_with({answer});
  NpyArrayReader normals(options_.out + "/geometry/normals.npz", "normals");
  EXPECT_EQ(normals.header().shape, (std::vector<std::size_t>{2, 136, 240, 3}));
  std::vector<float> values(normals.slice_values());
  normals.read(1, std::span<float>(values));
  EXPECT_NEAR(values[4], 0.6F, 1e-3);
}

/// Says that the middle third of every picture is the foreground, and follows it two pixels to the right a frame.
class MiddleFinder : public ForegroundFinder {
 public:
  Image<float> find(const ImageRgb& picture) override {
    Image<float> probability(picture.size());
    for (int y = 0; y < picture.height(); ++y)
      for (int x = picture.width() / 3; x < 2 * picture.width() / 3; ++x) probability(x, y) = 0.9F;
    return probability;
  }
  std::string name() const override { return "the middle"; }
};
class MiddleTracker : public ForegroundTracker {
 public:
  std::vector<ForegroundMask> follow(std::span<const ImageRgb> frames, std::span<const PixelIndex> prompts,
                                     Monitor&) override {
    EXPECT_GE(prompts.size(), 10U);
    std::vector<ForegroundMask> masks;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      ForegroundMask& mask = masks.emplace_back(frames[i].size());
      for (int y = 20; y < 120; ++y)
        for (int x = 80; x < 160; ++x) mask(x + 2 * static_cast<int>(i), y) = 1;
    }
    return masks;
  }
  std::string name() const override { return "shifting"; }
};

TEST_F(NetworkRun, FollowsTheForegroundByASegmenter) {
  film(3, 0);
  RunComponents components;
  components.open_foreground_network = [](const std::string&) { return std::make_unique<MiddleFinder>(); };
  components.open_foreground_tracker = [](const std::string&) { return std::make_unique<MiddleTracker>(); };
  options_.saliency_model = options_.segmenter = folder_.file("clip");  // any folder: nothing of it is read
  const RunSummary summary = run(options_, monitor_, {}, components);
  EXPECT_THAT(facts_of(summary)["foreground"].get<std::string>(), HasSubstr("the middle"));
  EXPECT_THAT(facts_of(summary)["foreground"].get<std::string>(), HasSubstr("followed by shifting"));
  ClipOptions as_is;
  as_is.resize.mode = ResizePolicy::Mode::none;
  const auto masks = open_clip(options_.out + "/geometry/foreground_mask.mp4", as_is, monitor_);
  ImageRgb mask;
  ASSERT_TRUE(masks->read(2, mask));
  EXPECT_GT(mask(160, 60).r, 200);
  EXPECT_LT(mask(78, 60).r, 50) << "it has moved on";
}

TEST_F(NetworkRun, OpensNoNetworkForWhatIsThereAlready) {
  film(2, 0);
  options_.layers = LayerChoice::off;
  const DepthNetworkResult answer = told(NetworkDepth::metric, metres);
  run_with({answer});
  options_.traj = "right";
  EXPECT_EQ(run_with({answer}).stages[0].status, StageSummary::Status::resumed);
  EXPECT_EQ(opened_, 1);
}

TEST_F(NetworkRun, SaysWhatIsMissing) {
  film(2, 0);
  options_.depth_model = folder_.file("clip");
  EXPECT_THAT(error_of_run(), HasSubstr("built without TorchScript networks"));
  options_.depth_model = folder_.file("nowhere");
  EXPECT_THAT(error_of_run(), HasSubstr("nowhere"));
  EXPECT_FALSE(std::filesystem::exists(options_.out));
  options_.depth_model.clear();
  options_.geometry = GeometryChoice::network;
  EXPECT_THROW(options_.check(), std::invalid_argument);
  options_.depth_model = "net";
  options_.geometry = GeometryChoice::prior;
  EXPECT_THROW(options_.check(), std::invalid_argument);
  options_.geometry = GeometryChoice::automatic;
  EXPECT_NO_THROW(options_.check());
  options_.depth = "depth.npz";
  EXPECT_THROW(options_.check(), std::invalid_argument);
}

}  // namespace
}  // namespace uwv
