// SPDX-License-Identifier: Apache-2.0
#include "uwv/eval/mesh_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <numbers>

#include "support/glb_builder.h"
#include "support/temp_folder.h"
#include "uwv/io/image_file.h"

namespace uwv {
namespace {

using Eigen::Vector3d;

MeshInstance instance_of(const test::GlbBuilder& file) {
  MeshInstance instance;
  instance.model = MeshModel::from_bytes(file.bytes(), "test.glb");
  return instance;
}

Eigen::Matrix3d turned(const Vector3d& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

Camera camera_with(double fov_x, Size size) {
  Camera camera;
  camera.size = size;
  camera.intrinsics = Intrinsics::from_fov_x(fov_x, size);
  return camera;
}

/// A turned cube of triangles and the same as a box that is ray-cast by its own formula.
struct Twins {
  MeshScene mesh;
  Scene analytic;
};

Twins twins(const Rigid3& world_from_model, double scale) {
  Twins both;
  both.mesh.instances.push_back(instance_of(test::cube()));
  both.mesh.instances.back().world_from_model = world_from_model;
  both.mesh.instances.back().scale = scale;
  SceneObject box;
  box.shape = Box{Vector3d::Constant(scale)};
  box.world_from_object = world_from_model;
  both.analytic.objects.push_back(box);
  return both;
}

/// Pixels in which one is hit and the other not: at most those whose centre lies on an edge.
int compare_depth(const Twins& both, const Camera& camera, double relative) {
  ThreadPool pool(2);
  const SyntheticFrame mesh = render(both.mesh, camera, 0, pool, 1);
  const SyntheticFrame analytic = render(both.analytic, camera, 0, pool, 1);
  int different = 0, hits = 0;
  for (int y = 0; y < camera.size.height; ++y)
    for (int x = 0; x < camera.size.width; ++x) {
      if ((mesh.depth(x, y) > 0) != (analytic.depth(x, y) > 0)) {
        ++different;
        continue;
      }
      hits += mesh.depth(x, y) > 0;
      EXPECT_NEAR(mesh.depth(x, y), analytic.depth(x, y), relative * static_cast<double>(analytic.depth(x, y)))
          << x << ", " << y;
    }
  EXPECT_GT(hits, 100);
  return different;
}

TEST(MeshScene, CubeOfTrianglesHasTheDepthOfABox) {
  const Rigid3 pose{turned({1, 2, 3}, 0.8), {0.2, -0.1, 5}};
  EXPECT_EQ(compare_depth(twins(pose, 1), camera_with(0.9, {160, 120}), 2e-7), 0);
}

// Half a float's last digit is 6e-8: at any scale the depth is the exact one, rounded.
TEST(MeshScene, DepthIsExactAtAnyScale) {
  for (const double scale : {1e-6, 1e-3, 1e3, 1e6}) {
    const Rigid3 pose{turned({1, 2, 3}, 0.8), scale * Vector3d(0.2, -0.1, 5)};
    EXPECT_EQ(compare_depth(twins(pose, scale), camera_with(0.9, {80, 60}), 2e-7), 0) << scale;
  }
}

TEST(MeshScene, DepthIsExactFarFromTheOrigin) {
  const Vector3d far(1e7, -1e7, 1e7);
  Camera camera = camera_with(0.9, {80, 60});
  camera.world_from_cam.translation = far;
  EXPECT_LE(compare_depth(twins({turned({1, 2, 3}, 0.8), far + Vector3d(0.2, -0.1, 5)}, 1), camera, 2e-7), 1);
}

TEST(MeshScene, CameraInsideSeesWallsAllAround) {
  // Most triangles reach behind the camera. The corners lie where two faces are equally near.
  const Rigid3 pose{turned({1, 2, 3}, 0.8), {0.1, 0.2, -0.3}};
  EXPECT_EQ(compare_depth(twins(pose, 1), camera_with(2.5, {160, 120}), 2e-7), 0);
}

TEST(MeshScene, NeighboursLeaveNoGap) {
  Camera camera = camera_with(0.25, {400, 400});
  MeshScene scene{{instance_of(test::cube())}, Colour::Zero()};
  ThreadPool pool(1);
  for (int i = 0; i < 5; ++i) {
    // The diagonal of the face in front runs through pixel centres in one of them.
    scene.instances[0].world_from_model = {turned({0, 0, 1}, 0.2 * i), {0, 0, 6}};
    const SyntheticFrame frame = render(scene, camera, 0, pool, 1);
    for (const float depth : frame.depth.pixels()) ASSERT_FLOAT_EQ(depth, 5) << i;
  }
}

TEST(MeshScene, NearerInstancesHideOthersWhateverTheirOrder) {
  ThreadPool pool(1);
  const Camera camera = camera_with(0.5, {40, 30});
  for (const bool swapped : {false, true}) {
    MeshScene scene{{instance_of(test::cube()), instance_of(test::cube())}, Colour::Zero()};
    scene.instances[0].world_from_model.translation = {0, 0, swapped ? 20.0 : 10.0};
    scene.instances[1].world_from_model.translation = {0, 0, swapped ? 10.0 : 20.0};
    const SyntheticFrame frame = render(scene, camera, 0, pool, 1);
    EXPECT_EQ(frame.object(20, 15), swapped ? 1 : 0);
    EXPECT_FLOAT_EQ(frame.depth(20, 15), 9);
    EXPECT_EQ(frame.object(0, 0), -1);
    EXPECT_EQ(frame.depth(0, 0), 0);
  }
}

TEST(MeshScene, TextureLiesAsGltfSays) {
  const test::TempFolder folder;
  ImageRgb texture(2, 2);
  texture(0, 0) = {200, 0, 0};
  texture(1, 0) = {0, 200, 0};
  texture(0, 1) = {0, 0, 200};
  texture(1, 1) = {100, 100, 100};
  const std::string path = (folder.path() / "texture.png").string();
  write_png(path, texture);
  std::ifstream stream(path, std::ios::binary);
  const std::vector<char> png{std::istreambuf_iterator<char>(stream), {}};

  test::GlbBuilder file = test::cube();
  file.append("images", {{"bufferView", file.view(png)}, {"mimeType", "image/png"}});
  file.append("textures", {{"source", 0}});
  file.append("materials",
              {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}, {"baseColorFactor", {0.5, 1, 1, 1}}}}});
  file.json["meshes"][0]["primitives"][0]["material"] = 0;
  MeshScene scene{{instance_of(file)}, Colour::Zero()};
  scene.instances[0].shading = 0;
  scene.instances[0].world_from_model.translation = {0, 0, 3};
  // The face z = -1 fills the picture: x grows to the right with u, y downwards with v. Where a texture pixel has its
  // centre, its colour is seen pure; 8 pixels of the picture are 1 of the texture.
  Camera camera;
  camera.size = {16, 16};
  camera.intrinsics = {16, 16, 8, 8};
  ThreadPool pool(1);
  const SyntheticFrame frame = render(scene, camera, 0, pool, 4);
  const auto close = [](const Rgb8& a, int r, int g, int b) {
    return std::abs(a.r - r) < 20 && std::abs(a.g - g) < 20 && std::abs(a.b - b) < 20;
  };
  EXPECT_TRUE(close(frame.colour(4, 4), 100, 0, 0));  // half the red
  EXPECT_TRUE(close(frame.colour(11, 4), 0, 200, 0));
  EXPECT_TRUE(close(frame.colour(4, 11), 0, 0, 200));
  EXPECT_TRUE(close(frame.colour(11, 11), 50, 100, 100));
}

TEST(MeshScene, DetailSticksToMovingSkin) {
  // Where the bent strip shows a point, its colour is that of the same point at rest.
  MeshScene scene{{instance_of(test::bending_strip())}, Colour::Zero()};
  MeshInstance& strip = scene.instances[0];
  strip.shading = 0;
  strip.details = {Texture::noise({0.4F, 0.4F, 0.4F}, 1.0, 3)};
  strip.world_from_model.translation = {0, 0, 4};
  const Camera camera = camera_with(1.2, {120, 90});
  ThreadPool pool(2);
  const auto colour_at = [&](const SyntheticFrame& frame, const Vector3d& x_in_model) {
    Eigen::Vector2d pixel;
    EXPECT_TRUE(project(camera.intrinsics, strip.world_from_model * x_in_model, pixel));
    const Rgb8 found = frame.colour(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
    return Vector3d(found.r, found.g, found.b);
  };
  const SyntheticFrame at_rest = render(scene, camera, 0, pool, 1);
  strip.animation = "bend";
  const SyntheticFrame bent = render(scene, camera, 1 - 1e-9, pool, 1);
  // In the upper triangle of the strip the vertices at y = 1 are blended from both joints.
  const std::vector<Vector3d> rest = strip.model.rest(), moved = strip.model.posed("bend", 1 - 1e-9);
  const Vector3d weights(0.2, 0.3, 0.5);  // of the triangle 4 3 5
  const auto inside = [&](const std::vector<Vector3d>& x) -> Vector3d {
    return weights[0] * x[4] + weights[1] * x[3] + weights[2] * x[5];
  };
  EXPECT_GT((inside(rest) - inside(moved)).norm(), 0.5);
  // A pixel is 0.05 wide, the texture's shortest wave 1: a few grey levels.
  EXPECT_LT((colour_at(at_rest, inside(rest)) - colour_at(bent, inside(moved))).norm(), 12);
}

TEST(MeshScene, DetailIsAsStrongAsItIsTold) {
  MeshScene scene{{instance_of(test::cube())}, Colour::Zero()};
  MeshInstance& cube = scene.instances[0];
  cube.shading = 0;
  cube.world_from_model.translation = {0, 0, 4};
  ThreadPool pool(1);
  const Camera camera = camera_with(0.3, {3, 3});
  const int plain = render(scene, camera, 0, pool, 1).colour(1, 1).r;
  cube.details = {Texture::flat({0.25F, 0.25F, 0.25F})};  // half as bright
  for (const double strength : {0.0, 0.5, 1.0}) {
    cube.detail_strength = strength;
    EXPECT_NEAR(render(scene, camera, 0, pool, 1).colour(1, 1).r, plain * (1 - 0.5 * strength), 1) << strength;
  }
}

TEST(MeshScene, SameWithAnyNumberOfThreads) {
  MeshScene scene{{instance_of(test::cube())}, Colour::Zero()};
  scene.instances[0].world_from_model = {turned({1, 2, 3}, 0.8), {0.2, -0.1, 5}};
  scene.instances[0].details = {Texture::noise({0.5F, 0.5F, 0.5F}, 0.2, 1)};
  ThreadPool one(1), three(3);
  const Camera camera = camera_with(0.9, {83, 61});
  const SyntheticFrame a = render(scene, camera, 0, one, 2), b = render(scene, camera, 0, three, 2);
  EXPECT_EQ(a.colour, b.colour);
  EXPECT_EQ(a.depth, b.depth);
}

TEST(MeshScene, BackgroundIsMixedInAtEdges) {
  // A cube's face that covers exactly the left half of the picture's middle column.
  MeshScene scene{{instance_of(test::cube())}, Colour::Ones()};
  scene.instances[0].shading = 1;
  scene.instances[0].world_from_model = {turned({0, 1, 0}, std::numbers::pi), {-1, 0, 2}};
  Camera camera;
  camera.size = {3, 1};
  camera.intrinsics = {3, 3, 1.5, 0.5};
  ThreadPool pool(1);
  const SyntheticFrame frame = render(scene, camera, 0, pool, 4);
  const int covered = frame.colour(0, 0).r, between = frame.colour(1, 0).r, open = frame.colour(2, 0).r;
  EXPECT_EQ(open, 255);
  EXPECT_LT(covered, 250);
  EXPECT_NEAR(between, 0.5 * (covered + open), 1.5);
}

TEST(MeshScene, EmptySceneIsAllBackground) {
  ThreadPool pool(1);
  const SyntheticFrame frame = render(MeshScene{{}, Colour::Ones()}, camera_with(1, {1, 1}), 0, pool);
  EXPECT_EQ(frame.colour(0, 0), (Rgb8{255, 255, 255}));
  EXPECT_EQ(frame.object(0, 0), -1);
  EXPECT_THROW(render(MeshScene{}, Camera{}, 0, pool), std::invalid_argument);
  EXPECT_THROW(render(MeshScene{}, camera_with(1, {1, 1}), 0, pool, 0), std::invalid_argument);
}

}  // namespace
}  // namespace uwv
