// SPDX-License-Identifier: Apache-2.0
#include "uwv/render/gl_rasterizer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <thread>
#include <tuple>

#include "render/gl_api.h"
#include "render/gl_path.h"
#include "support/gl_backends_under_test.h"
#include "support/render_scenes.h"

namespace uwv::testing {
namespace {

using Path = GlOptions::Path;

/// Every test runs on each backend with each path.
class GlRasterizerTest : public ::testing::TestWithParam<std::tuple<const char*, Path>> {
 protected:
  void SetUp() override {
    std::string reason;
    std::unique_ptr<GlContext> context = open_backend(std::get<0>(GetParam()), reason);
    if (context == nullptr) GTEST_SKIP() << std::get<0>(GetParam()) << " is absent: " << reason;
    if (std::get<1>(GetParam()) == Path::compute && !context->api().compute)
      GTEST_SKIP() << std::get<0>(GetParam()) << " has no compute shaders: " << context->version();
    context_ = context.get();
    rasterizer_ = make_gl_rasterizer(std::move(context), {std::get<1>(GetParam())});
  }

  void expect_zbuffer_as_reference(const Scene& scene) {
    ZBuffer wanted, got;
    naive_zbuffer(scene.grid(), scene.target, scene.footprint, wanted);
    rasterizer_->zbuffer(scene.grid(), scene.target, scene.footprint, got);
    expect_same(wanted, got);
  }

  GlContext* context_ = nullptr;  // owned by rasterizer_
  std::unique_ptr<Rasterizer> rasterizer_;
};

TEST_P(GlRasterizerTest, DrawsTheReferencesZBuffer) {
  for (const Scene& scene : all_scenes()) {
    SCOPED_TRACE(scene.name);
    ZBuffer wanted;
    naive_zbuffer(scene.grid(), scene.target, scene.footprint, wanted);
    const auto none = std::count(wanted.winner.pixels().begin(), wanted.winner.pixels().end(), PointCode::none);
    EXPECT_EQ(static_cast<std::size_t>(none) == wanted.winner.pixels().size(), scene.can_be_empty);
    expect_zbuffer_as_reference(scene);
  }
}

TEST_P(GlRasterizerTest, CoversTheReferencesPixels) {
  for (const Scene& scene : all_scenes()) {
    SCOPED_TRACE(scene.name);
    ValidityMask wanted, got;
    naive_coverage(scene.grid(), scene.target, scene.footprint, wanted);
    rasterizer_->coverage(scene.grid(), scene.target, scene.footprint, got);
    expect_same(wanted, got);
  }
}

TEST_P(GlRasterizerTest, NarrowsAndFillsAsDrawingWould) {
  const std::vector<Scene> scenes = all_scenes();
  for (std::size_t i = 0; i < std::min<std::size_t>(3, scenes.size()); ++i) {
    SCOPED_TRACE(scenes[i].name);
    expect_narrows_to_parts(*rasterizer_, scenes[i]);
    expect_fills_empty_pixels(*rasterizer_, scenes[i]);
  }
}

TEST_P(GlRasterizerTest, SplatsTheReferencesSoftPicture) {
  for (const Scene& scene : all_scenes()) {
    SCOPED_TRACE(scene.name);
    SoftSplat wanted, got;
    for (const ImageRgbF* colour : {&scene.colour, static_cast<const ImageRgbF*>(nullptr)}) {
      naive_soft_splat(scene.grid(), colour, scene.target, {}, wanted);
      rasterizer_->soft_splat(scene.grid(), colour, scene.target, {}, got);
      expect_same(wanted, got);
    }
  }
}

TEST_P(GlRasterizerTest, SoftSplatHonoursItsOptions) {
  const Scene scene = all_scenes().front();
  const SoftSplatOptions options{20.0F, 3.0F};
  SoftSplat wanted, got, with_defaults;
  naive_soft_splat(scene.grid(), &scene.colour, scene.target, options, wanted);
  rasterizer_->soft_splat(scene.grid(), &scene.colour, scene.target, options, got);
  expect_same(wanted, got);
  rasterizer_->soft_splat(scene.grid(), &scene.colour, scene.target, {}, with_defaults);
  EXPECT_NE(with_defaults.depth, got.depth);
}

TEST_P(GlRasterizerTest, LooksAtEveryPixelFromItsOwnCamera) {
  Scene scene = make_scene("own camera", test_camera({70, 50}, 1.0), test_camera({70, 50}, 1.0), 0.2F,
                           [](int, int, float random) { return 1 + random; });
  scene.use_keep = false;
  ZBuffer out;
  rasterizer_->zbuffer(scene.grid(), scene.target, {}, out);
  EXPECT_EQ(out.depth, scene.depth);
  for (int y = 0; y < 50; ++y)
    for (int x = 0; x < 70; ++x) ASSERT_EQ(out.winner(x, y), PointCode::pack(x, y)) << "at (" << x << ", " << y << ")";
}

TEST_P(GlRasterizerTest, FootprintsReachInFromOutside) {
  // One point just right of the picture, several pixels wide.
  Scene scene = make_scene("outside", test_camera({1, 1}, 1.0), test_camera({40, 40}, 1.0), 0,
                           [](int, int, float) { return 1.0F; });
  scene.use_keep = false;
  scene.source.intrinsics = {1, 1, 0.5, 0.5};
  scene.target.intrinsics = {10, 10, 41, 20};
  ZBuffer out;
  rasterizer_->zbuffer(scene.grid(), scene.target, {}, out);
  EXPECT_EQ(out.winner(39, 20), PointCode::pack(0, 0));
  EXPECT_EQ(out.winner(35, 20), PointCode::none);
  expect_zbuffer_as_reference(scene);
}

TEST_P(GlRasterizerTest, ScratchMemoryIsReusedForOtherSizes) {
  std::vector<Scene> scenes = all_scenes();
  for (const std::size_t i : {0U, 12U, 9U, 6U, 0U}) {
    SCOPED_TRACE(scenes[i].name);
    expect_zbuffer_as_reference(scenes[i]);
  }
}

TEST_P(GlRasterizerTest, DrawsLargePictures) {
  const Camera target = test_camera({7680, 4320}, 1.0, {0.2, 0.1, 0});
  Scene scene =
      make_scene("8K", test_camera({7680, 8}, 1.0), target, 0.01F, [](int, int, float random) { return 1 + random; });
  scene.source.intrinsics.cy = 2000;
  expect_zbuffer_as_reference(scene);
}

TEST_P(GlRasterizerTest, RefusesWhatTheDriverCannotDraw) {
  Scene scene = all_scenes().front();
  scene.target.size = {65535, 65535};
  ZBuffer out;
  try {
    rasterizer_->zbuffer(scene.grid(), scene.target, {}, out);
    FAIL() << "65535x65535 pixels were drawn";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::backend_missing);
    EXPECT_THAT(error.what(), ::testing::HasSubstr("65535x65535"));
  }
  expect_zbuffer_as_reference(all_scenes().front());  // still works afterwards
}

TEST_P(GlRasterizerTest, MovesBetweenThreads) {
  const Scene scene = all_scenes().front();
  std::thread([&] { expect_zbuffer_as_reference(scene); }).join();
  expect_zbuffer_as_reference(scene);
  std::thread([&] { rasterizer_.reset(); }).join();
}

TEST_P(GlRasterizerTest, AlternatesWithAnotherContext) {
  const Scene scene = all_scenes().front();
  for (const char* name : backend_names) {
    std::string reason;
    std::unique_ptr<GlContext> context = open_backend(name, reason);
    if (context == nullptr) continue;
    const std::unique_ptr<Rasterizer> other = make_gl_rasterizer(std::move(context));
    ZBuffer ours, theirs;
    for (int i = 0; i < 2; ++i) {
      rasterizer_->zbuffer(scene.grid(), scene.target, scene.footprint, ours);
      other->zbuffer(scene.grid(), scene.target, scene.footprint, theirs);
      expect_same(ours, theirs);
    }
  }
}

TEST_P(GlRasterizerTest, NeitherMindsNorChangesTheContextsState) {
  const GlCurrent current(*context_);
  const GlApi& gl = context_->api();
  GLuint texture = 0;
  gl.GenTextures(1, &texture);
  gl.ActiveTexture(GL_TEXTURE1);
  gl.BindTexture(GL_TEXTURE_2D, texture);
  gl.Enable(GL_SCISSOR_TEST);
  gl.Enable(GL_BLEND);
  gl.Enable(GL_RASTERIZER_DISCARD);
  gl.ColorMask(GL_FALSE, GL_FALSE, GL_TRUE, GL_TRUE);
  gl.DepthMask(GL_FALSE);
  gl.DepthFunc(GL_GREATER);
  gl.DepthRange(0.25, 0.5);
  gl.PixelStorei(GL_UNPACK_ROW_LENGTH, 17);
  gl.PixelStorei(GL_PACK_SKIP_PIXELS, 3);
  gl.Viewport(1, 2, 3, 4);
  if (gl.ClipControl != nullptr) gl.ClipControl(GL_UPPER_LEFT, GL_ZERO_TO_ONE);

  const Scene scene = all_scenes().front();
  expect_zbuffer_as_reference(scene);
  SoftSplat wanted, got;
  naive_soft_splat(scene.grid(), &scene.colour, scene.target, {}, wanted);
  rasterizer_->soft_splat(scene.grid(), &scene.colour, scene.target, {}, got);
  expect_same(wanted, got);

  EXPECT_EQ(gl.integer(GL_ACTIVE_TEXTURE), GL_TEXTURE1);
  EXPECT_EQ(gl.integer(GL_TEXTURE_BINDING_2D), static_cast<GLint>(texture));
  EXPECT_TRUE(gl.IsEnabled(GL_SCISSOR_TEST) && gl.IsEnabled(GL_BLEND) && gl.IsEnabled(GL_RASTERIZER_DISCARD));
  EXPECT_FALSE(gl.IsEnabled(GL_DEPTH_TEST) || gl.IsEnabled(GL_PROGRAM_POINT_SIZE));
  std::array<GLboolean, 4> colour_mask{};
  gl.GetBooleanv(GL_COLOR_WRITEMASK, colour_mask.data());
  EXPECT_THAT(colour_mask, ::testing::ElementsAre(0, 0, 1, 1));
  EXPECT_EQ(gl.integer(GL_DEPTH_WRITEMASK), 0);
  EXPECT_EQ(gl.integer(GL_DEPTH_FUNC), GL_GREATER);
  std::array<GLdouble, 2> depth_range{};
  gl.GetDoublev(GL_DEPTH_RANGE, depth_range.data());
  EXPECT_THAT(depth_range, ::testing::ElementsAre(0.25, 0.5));
  EXPECT_EQ(gl.integer(GL_UNPACK_ROW_LENGTH), 17);
  EXPECT_EQ(gl.integer(GL_PACK_SKIP_PIXELS), 3);
  std::array<GLint, 4> viewport{};
  gl.GetIntegerv(GL_VIEWPORT, viewport.data());
  EXPECT_THAT(viewport, ::testing::ElementsAre(1, 2, 3, 4));
  EXPECT_TRUE(gl.ClipControl == nullptr || gl.integer(GL_CLIP_ORIGIN) == GL_UPPER_LEFT);
  EXPECT_EQ(gl.integer(GL_CURRENT_PROGRAM), 0);
  EXPECT_EQ(gl.integer(GL_DRAW_FRAMEBUFFER_BINDING), 0);
  EXPECT_EQ(gl.GetError(), static_cast<GLenum>(GL_NO_ERROR));
}

TEST_P(GlRasterizerTest, AgreesWithTheCpuRenderer) {
  ThreadPool pool(2);
  const std::unique_ptr<Rasterizer> cpu = make_cpu_rasterizer(pool);
  for (const Scene& scene : all_scenes()) {
    SCOPED_TRACE(scene.name);
    ZBuffer wanted, got;
    cpu->zbuffer(scene.grid(), scene.target, scene.footprint, wanted);
    rasterizer_->zbuffer(scene.grid(), scene.target, scene.footprint, got);
    expect_same(wanted, got);
    ValidityMask wanted_mask, got_mask;
    cpu->coverage(scene.grid(), scene.target, scene.footprint, wanted_mask);
    rasterizer_->coverage(scene.grid(), scene.target, scene.footprint, got_mask);
    expect_same(wanted_mask, got_mask);
    SoftSplat wanted_soft, got_soft;
    cpu->soft_splat(scene.grid(), &scene.colour, scene.target, {}, wanted_soft);
    rasterizer_->soft_splat(scene.grid(), &scene.colour, scene.target, {}, got_soft);
    expect_same(wanted_soft, got_soft);
  }
}

TEST_P(GlRasterizerTest, NamesDriverAndPath) {
  EXPECT_THAT(rasterizer_->name(), ::testing::StartsWith("gl ("));
  EXPECT_THAT(rasterizer_->name(), ::testing::HasSubstr(std::string(to_string(std::get<1>(GetParam())))));
}

INSTANTIATE_TEST_SUITE_P(Backends, GlRasterizerTest,
                         ::testing::Combine(::testing::ValuesIn(backend_names),
                                            ::testing::Values(Path::sprites, Path::compute)),
                         [](const auto& instance) {
                           return as_test_name(std::get<0>(instance.param)) + "_" +
                                  std::string(to_string(std::get<1>(instance.param)));
                         });

// Mesa reads the override when the process makes its first context, so this only bites in a process of its own
// (ctest's).
TEST(GlPathTest, SoftSplatsWithoutFloatAtomics) {
  setenv("MESA_EXTENSION_OVERRIDE", "-GL_NV_shader_atomic_float", 1);
  std::string reason;
  std::unique_ptr<GlContext> context = open_backend("egl surfaceless", reason);
  unsetenv("MESA_EXTENSION_OVERRIDE");
  if (context == nullptr) GTEST_SKIP() << "egl surfaceless is absent: " << reason;
  if (!context->api().compute || context->api().float_atomics)
    GTEST_SKIP() << "the driver's extensions stay as they are";
  const std::unique_ptr<Rasterizer> rasterizer = make_gl_rasterizer(std::move(context), {Path::compute});
  const Scene scene = all_scenes().front();
  SoftSplat wanted, got;
  naive_soft_splat(scene.grid(), &scene.colour, scene.target, {}, wanted);
  rasterizer->soft_splat(scene.grid(), &scene.colour, scene.target, {}, got);
  expect_same(wanted, got);
}

TEST(GlPathTest, ComputeNeedsComputeShaders) {
  GlApi gl;
  gl.version = 41;
  EXPECT_THAT([&] { make_compute_path(gl); }, ::testing::ThrowsMessage<Error>(::testing::HasSubstr("OpenGL 4.1")));
}

TEST(GlPathTest, NamesRoundTrip) {
  for (const Path path : {Path::automatic, Path::sprites, Path::compute})
    EXPECT_EQ(parse_gl_path(to_string(path)), path);
  EXPECT_THROW(parse_gl_path("triangles"), Error);
}

}  // namespace
}  // namespace uwv::testing
