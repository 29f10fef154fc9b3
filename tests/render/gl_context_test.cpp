// SPDX-License-Identifier: Apache-2.0
#include "uwv/render/gl_context.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "render/gl_api.h"
#include "support/gl_backends_under_test.h"

namespace uwv::testing {
namespace {

class GlContextTest : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    std::string reason;
    context_ = open_backend(GetParam(), reason);
    if (context_ == nullptr) GTEST_SKIP() << GetParam() << " is absent: " << reason;
  }
  std::unique_ptr<GlContext> context_;
};

std::array<GLint, 4> viewport(const GlApi& gl) {
  std::array<GLint, 4> values{};
  gl.GetIntegerv(GL_VIEWPORT, values.data());
  return values;
}

TEST_P(GlContextTest, KnowsItsDriver) {
  EXPECT_EQ(context_->name(), GetParam());
  EXPECT_FALSE(context_->renderer().empty());
  EXPECT_GE(context_->api().version, 41);
  const bool emulated = context_->renderer().find("llvmpipe") != std::string::npos;
  EXPECT_TRUE(!emulated || context_->is_software());
}

TEST_P(GlContextTest, ScopesNest) {
  const GlCurrent outer(*context_);
  { const GlCurrent inner(*context_); }
  EXPECT_NE(context_->api().GetString(GL_VERSION), nullptr);
}

TEST_P(GlContextTest, TheContextBeforeComesBack) {
  if (std::string(GetParam()) == "osmesa") GTEST_SKIP() << "OSMesa leaves no context current";
  std::string reason;
  const std::unique_ptr<GlContext> second = open_backend(GetParam(), reason);
  ASSERT_NE(second, nullptr) << reason;
  const GlCurrent outer(*context_);
  context_->api().Viewport(1, 2, 30, 40);
  {
    const GlCurrent inner(*second);
    second->api().Viewport(5, 6, 7, 8);
  }
  EXPECT_THAT(viewport(context_->api()), ::testing::ElementsAre(1, 2, 30, 40));
}

INSTANTIATE_TEST_SUITE_P(Backends, GlContextTest, ::testing::ValuesIn(backend_names),
                         [](const auto& instance) { return as_test_name(instance.param); });

TEST(GlProbeTest, SaysWhatWorksOrWhyNot) {
  const std::vector<GlProbe> probes = probe_gl_backends();
  ASSERT_FALSE(probes.empty());
  EXPECT_EQ(probes.back().name, "osmesa");
  for (const GlProbe& probe : probes) {
    EXPECT_EQ(probe.usable, probe.reason.empty()) << probe.name;
    EXPECT_EQ(probe.usable, !probe.renderer.empty()) << probe.name;
    EXPECT_EQ(probe.reason.find('\n'), std::string::npos) << probe.reason;
  }
}

TEST(GlProbeTest, AutomaticTakesWhatTheProbeFound) {
  bool any = false;
  for (const GlProbe& probe : probe_gl_backends()) any = any || probe.usable;
  if (any)
    EXPECT_NE(make_gl_context(), nullptr);
  else
    EXPECT_THAT([] { make_gl_context(); }, ::testing::ThrowsMessage<Error>(::testing::HasSubstr("osmesa")));
}

TEST(GlBackendTest, NamesRoundTrip) {
  for (const GlBackend backend : {GlBackend::automatic, GlBackend::egl, GlBackend::osmesa})
    EXPECT_EQ(parse_gl_backend(to_string(backend)), backend);
  EXPECT_THAT([] { parse_gl_backend("glx"); }, ::testing::ThrowsMessage<Error>(::testing::HasSubstr("'glx'")));
}

TEST(GlAdoptTest, RefusesALoaderThatFindsNothing) {
  EXPECT_THAT([] { adopt_gl_context([](const char*) -> void* { return nullptr; }); },
              ::testing::Throws<Error>(::testing::Property(&Error::code, ErrorCode::backend_missing)));
}

}  // namespace
}  // namespace uwv::testing
