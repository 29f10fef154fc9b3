// SPDX-License-Identifier: Apache-2.0
#include "uwv/eval/mesh_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>

#include "support/glb_builder.h"
#include "uwv/core/error.h"

namespace uwv {
namespace {

using Eigen::Vector3d;
using test::GlbBuilder;

MeshModel model_of(const GlbBuilder& file) { return MeshModel::from_bytes(file.bytes(), "test.glb"); }

/// What reading the bytes fails with; nothing when it succeeds.
std::optional<ErrorCode> failure(const std::vector<std::byte>& bytes, const MeshModelOptions& options = {}) {
  try {
    MeshModel::from_bytes(bytes, "test.glb", options);
    return std::nullopt;
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::StartsWith("test.glb: "));
    EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr("\n")));
    return error.code();
  }
}

TEST(MeshModel, CubeHasItsTwelveTriangles) {
  const MeshModel model = model_of(test::cube());
  ASSERT_EQ(model.triangles().size(), 12U);
  ASSERT_EQ(model.rest().size(), 24U);
  for (const Vector3d& x : model.rest()) EXPECT_EQ(x.cwiseAbs(), Vector3d::Ones());
}

TEST(MeshModel, NodesMoveTurnAndScaleWhatHangsOnThem) {
  GlbBuilder file = test::cube();
  const double half = std::sqrt(0.5);
  file.append("nodes", {{"children", {0}}, {"translation", {1, 2, 3}}, {"rotation", {0, 0, half, half}}});
  file.json["nodes"][0]["scale"] = {2, 3, 4};
  file.json["nodes"][0]["translation"] = {10, 0, 0};
  const MeshModel model = model_of(file);
  const Vector3d first = model.rest().front();  // (-1, -1, -1) in the mesh
  const Vector3d in_parent(10 - 2, -3, -4);
  EXPECT_LT((first - Vector3d(1 - in_parent.y(), 2 + in_parent.x(), 3 + in_parent.z())).norm(), 1e-12);
}

TEST(MeshModel, MatrixIsTheSameAsItsParts) {
  GlbBuilder parts = test::cube(), whole = test::cube();
  parts.json["nodes"][0]["translation"] = {1, 2, 3};
  parts.json["nodes"][0]["scale"] = {2, 2, 5};
  whole.json["nodes"][0]["matrix"] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 5, 0, 1, 2, 3, 1};
  EXPECT_EQ(model_of(parts).rest(), model_of(whole).rest());
}

TEST(MeshModel, HiddenNodesAreLeftOut) {
  GlbBuilder file = test::cube();
  file.append("nodes", {{"name", "sword"}, {"mesh", 0}});
  EXPECT_EQ(model_of(file).triangles().size(), 24U);
  EXPECT_EQ(MeshModel::from_bytes(file.bytes(), "test.glb", {.hidden = {"sword"}}).triangles().size(), 12U);
}

TEST(MeshModel, SkinBendsWithItsJointsAndIgnoresItsNode) {
  const MeshModel model = model_of(test::bending_strip());
  EXPECT_LT((model.rest()[5] - Vector3d(1, 2, 0)).norm(), 1e-6);
  EXPECT_EQ(model.duration("bend"), 1);
  for (const double time : {0.0, 0.25, 0.5, 0.999}) {
    const std::vector<Vector3d> x = model.posed("bend", time);
    const double angle = time * std::numbers::pi / 2;
    const auto turned = [&](double px, double py) {  // about the joint at (0, 1)
      return Vector3d(std::cos(angle) * px - std::sin(angle) * (py - 1),
                      1 + std::sin(angle) * px + std::cos(angle) * (py - 1), 0);
    };
    EXPECT_LT((x[1] - Vector3d(1, 0, 0)).norm(), 1e-6) << time;
    EXPECT_LT((x[5] - turned(1, 2)).norm(), 1e-6) << time;
    EXPECT_LT((x[3] - 0.5 * (Vector3d(1, 1, 0) + turned(1, 1))).norm(), 1e-6) << time;
  }
}

TEST(MeshModel, AnimationRepeats) {
  const MeshModel model = model_of(test::bending_strip());
  const auto once = model.posed("bend", 0.25), later = model.posed("bend", 7.25), before = model.posed("bend", -0.75);
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_LT((once[i] - later[i]).norm(), 1e-12);
    EXPECT_LT((once[i] - before[i]).norm(), 1e-12);
  }
}

TEST(MeshModel, StepsHoldTheirValue) {
  GlbBuilder file = test::bending_strip();
  file.json["animations"][0]["samplers"][0]["interpolation"] = "STEP";
  const MeshModel model = model_of(file);
  EXPECT_EQ(model.posed("bend", 0.9), model.posed("bend", 0.0));
}

TEST(MeshModel, UnknownAnimationIsNamedWithThoseThereAre) {
  const MeshModel model = model_of(test::bending_strip());
  try {
    model.posed("dance", 0);
    FAIL() << "found an animation that is not there";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::value_invalid);
    EXPECT_THAT(error.what(), testing::HasSubstr("bend"));
  }
  EXPECT_THROW(model.posed("bend", std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
}

TEST(MeshModel, EveryTruncationIsAnError) {
  for (const GlbBuilder& file : {test::cube(), test::bending_strip()}) {
    const std::vector<std::byte> whole = file.bytes();
    ASSERT_EQ(failure(whole), std::nullopt);
    for (std::size_t size = 0; size < whole.size(); size += 7)
      EXPECT_NE(failure({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)}), std::nullopt) << size;
  }
}

struct Lie {
  const char* name;
  std::function<void(nlohmann::json&)> tell;
};
using Json = nlohmann::json;

const std::vector<Lie>& lies() {
  static const std::vector<Lie> all{
      {"mesh_of_node", [](Json& j) { j["nodes"][0]["mesh"] = 7; }},
      {"skin_of_node", [](Json& j) { j["nodes"][0]["skin"] = 7; }},
      {"own_child", [](Json& j) { j["nodes"][1]["children"] = {1}; }},
      {"cycle", [](Json& j) { j["nodes"][2]["children"] = {1}; }},
      {"two_parents", [](Json& j) { j["nodes"][0]["children"] = {2}; }},
      {"child_that_is_not_there", [](Json& j) { j["nodes"][0]["children"] = {99}; }},
      {"child_below_zero", [](Json& j) { j["nodes"][0]["children"] = {-1}; }},
      {"joint_that_is_not_there",
       [](Json& j) {
         j["skins"][0]["joints"] = {1, 99};
       }},
      {"fewer_joints_than_used", [](Json& j) { j["skins"][0]["joints"] = {1}; }},
      {"no_positions", [](Json& j) { j["meshes"][0]["primitives"][0]["attributes"].erase("POSITION"); }},
      {"accessor", [](Json& j) { j["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 99; }},
      {"index_accessor", [](Json& j) { j["meshes"][0]["primitives"][0]["indices"] = 99; }},
      {"indices_that_are_positions", [](Json& j) { j["meshes"][0]["primitives"][0]["indices"] = 0; }},
      {"too_many_values", [](Json& j) { j["accessors"][0]["count"] = 7; }},
      {"absurdly_many_values", [](Json& j) { j["accessors"][0]["count"] = 0xFFFFFFFFFFFFULL; }},
      {"offset", [](Json& j) { j["accessors"][0]["byteOffset"] = 4096; }},
      {"unknown_numbers", [](Json& j) { j["accessors"][0]["componentType"] = 4711; }},
      {"view_of_accessor", [](Json& j) { j["accessors"][0]["bufferView"] = 99; }},
      {"view_beyond_buffer", [](Json& j) { j["bufferViews"][0]["byteLength"] = 1 << 30; }},
      {"view_starts_beyond_buffer", [](Json& j) { j["bufferViews"][0]["byteOffset"] = 1 << 30; }},
      {"buffer_of_view", [](Json& j) { j["bufferViews"][0]["buffer"] = 3; }},
      {"narrow_stride", [](Json& j) { j["bufferViews"][0]["byteStride"] = 4; }},
      {"fewer_indices", [](Json& j) { j["accessors"][3]["count"] = 11; }},
      {"sampler", [](Json& j) { j["animations"][0]["channels"][0]["sampler"] = 5; }},
      {"animated_node", [](Json& j) { j["animations"][0]["channels"][0]["target"]["node"] = 99; }},
      {"fewer_times", [](Json& j) { j["accessors"][5]["count"] = 1; }},
      {"cubic", [](Json& j) { j["animations"][0]["samplers"][0]["interpolation"] = "CUBICSPLINE"; }},
      {"rotation_of_nothing",
       [](Json& j) {
         j["nodes"][1]["rotation"] = {0, 0, 0, 0};
       }},
      {"short_matrix",
       [](Json& j) {
         j["nodes"][1]["matrix"] = {1, 2, 3};
       }},
      {"lines", [](Json& j) { j["meshes"][0]["primitives"][0]["mode"] = 1; }},
      {"material", [](Json& j) { j["meshes"][0]["primitives"][0]["material"] = 4; }},
      {"image_beyond_views",
       [](Json& j) {
         j["images"] = {{{"bufferView", 99}, {"mimeType", "image/png"}}};
       }},
      {"image_that_is_none",
       [](Json& j) {
         j["images"] = {{{"bufferView", 0}, {"mimeType", "image/png"}}};
       }},
      {"image_elsewhere",
       [](Json& j) {
         j["images"] = {{{"uri", "elsewhere.png"}}};
       }},
      {"nodes_that_are_a_word", [](Json& j) { j["nodes"] = "none"; }},
  };
  return all;
}

class MeshModelLies : public testing::TestWithParam<Lie> {};

TEST_P(MeshModelLies, AreErrorsOfOneSentence) {
  GlbBuilder file = test::bending_strip();
  GetParam().tell(file.json);
  EXPECT_NE(failure(file.bytes()), std::nullopt);
}

INSTANTIATE_TEST_SUITE_P(Gltf, MeshModelLies, testing::ValuesIn(lies()),
                         [](const auto& lie) { return std::string(lie.param.name); });

TEST(MeshModel, OtherFilesAreNotOpened) {
  GlbBuilder file = test::cube();
  file.append("images", {{"uri", "/etc/hostname"}});
  EXPECT_EQ(failure(file.bytes()), ErrorCode::value_invalid);
}

TEST(MeshModel, VerticesMustBeFinite) {
  GlbBuilder file;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  file.floats({0, 0, 0, 1, 0, nan, 0, 1, 0}, "VEC3", 3);
  file.append("meshes", {{"primitives", {{{"attributes", {{"POSITION", 0}}}}}}});
  file.append("nodes", {{"mesh", 0}});
  EXPECT_EQ(failure(file.bytes()), ErrorCode::file_damaged);
}

TEST(MeshModel, RepeatedMeshesAreCounted) {
  GlbBuilder file = test::cube();
  for (int i = 0; i < 100; ++i) file.append("nodes", {{"mesh", 0}});
  EXPECT_EQ(failure(file.bytes(), {.hidden = {}, .max_triangles = 1000}), ErrorCode::out_of_memory);
  EXPECT_EQ(failure(file.bytes()), std::nullopt);
}

TEST(MeshModel, EmptyFileIsAnEmptyModel) {
  const MeshModel model = model_of(GlbBuilder());
  EXPECT_TRUE(model.triangles().empty());
  EXPECT_TRUE(model.animations().empty());
}

TEST(MeshModel, MissingAndForeignFilesAreSaid) {
  EXPECT_EQ(failure({}), ErrorCode::format_unknown);
  EXPECT_EQ(failure(std::vector<std::byte>(100, std::byte{'x'})), ErrorCode::format_unknown);
  try {
    MeshModel::read("no/such/model.glb");
    FAIL() << "read a file that does not exist";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::file_not_found);
  }
}

}  // namespace
}  // namespace uwv
