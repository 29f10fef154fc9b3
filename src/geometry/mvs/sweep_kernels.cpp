// SPDX-License-Identifier: Apache-2.0
#include "geometry/mvs/sweep_kernels.h"

#include <algorithm>
#include <cmath>

#include "uwv/core/simd.h"

namespace uwv::mvs {
namespace {

constexpr float window_pixels = window * window;
// Grey levels squared of noise: windows with less variance than this all look alike.
constexpr float noise_variance = 6.0F;

// What planes cost on which a view does not see the pixel, as a share of the usual cost of mismatches of windows as
// textured: it shall speak neither for nor against them.
constexpr float unseen_share = 0.5F;

}  // namespace

PlaneWarp make_warp(const Camera& reference, const Camera& other) {
  const Rigid3 other_from_reference = target_from_source(other, reference);
  const Eigen::Matrix3d k = other.intrinsics.matrix();
  const Eigen::Matrix3d h = k * other_from_reference.rotation * reference.intrinsics.inverse_matrix();
  const Eigen::Vector3d c = h * Eigen::Vector3d(0.5, 0.5, 1);
  const Eigen::Vector3d t = k * other_from_reference.translation;
  return {static_cast<float>(h(0, 0)), static_cast<float>(h(1, 0)), static_cast<float>(h(2, 0)),
          static_cast<float>(h(0, 1)), static_cast<float>(h(1, 1)), static_cast<float>(h(2, 1)),
          static_cast<float>(c.x()),   static_cast<float>(c.y()),   static_cast<float>(c.z()),
          static_cast<float>(t.x()),   static_cast<float>(t.y()),   static_cast<float>(t.z())};
}

UWV_SIMD_CLONES void find_places(const PlaneWarp& warp, float w, float y, int count, Size other, int stride,
                                 std::int32_t* index, float* fx, float* fy, float* inside) {
  const float ux = warp.bx * y + warp.cx + w * warp.shift_x;
  const float uy = warp.by * y + warp.cy + w * warp.shift_y;
  const float uz = warp.bz * y + warp.cz + w * warp.shift_z;
  const float ax = warp.ax, ay = warp.ay, az = warp.az;
  const auto right = static_cast<float>(other.width - 1);
  const auto bottom = static_cast<float>(other.height - 1);
  for (int x = 0; x < count; ++x) {
    const auto px = static_cast<float>(x);
    const float z = az * px + uz;
    const float safe = z > 1e-6F ? z : 1e-6F;
    const float u = (ax * px + ux) / safe - 0.5F;
    const float v = (ay * px + uy) / safe - 0.5F;
    // Half a pixel beyond the centres at the border is still picture.
    const bool in = (z > 1e-6F) & (u >= -0.5F) & (v >= -0.5F) & (u <= right + 0.5F) & (v <= bottom + 0.5F);
    const float cu = std::min(std::max(u, 0.0F), right);
    const float cv = std::min(std::max(v, 0.0F), bottom);
    const auto iu = static_cast<std::int32_t>(cu);
    const auto iv = static_cast<std::int32_t>(cv);
    index[x] = iv * stride + iu;
    fx[x] = cu - static_cast<float>(iu);
    fy[x] = cv - static_cast<float>(iv);
    inside[x] = in ? 1.0F : 0.0F;
  }
}

UWV_SIMD_CLONES void sample_row(const float* padded, int stride, const std::int32_t* index, const float* fx,
                                const float* fy, int count, float* out) {
  for (int x = 0; x < count; ++x) {
    const float* p = padded + index[x];
    const float top = p[0] + fx[x] * (p[1] - p[0]);
    const float bottom = p[stride] + fx[x] * (p[stride + 1] - p[stride]);
    out[x] = top + fy[x] * (bottom - top);
  }
}

UWV_SIMD_CLONES void sum_columns(const float* const* values, const float* const* reference, int count, float* value,
                                 float* square, float* product) {
  for (int x = 0; x < count; ++x) {
    float s = 0, ss = 0, sp = 0;
    for (int k = 0; k < window; ++k) {
      const float v = values[k][x];
      s += v;
      ss += v * v;
      sp += v * reference[k][x];
    }
    value[x] = s;
    square[x] = ss;
    product[x] = sp;
  }
}

UWV_SIMD_CLONES void correlate(const float* value, const float* square, const float* product, const float* mean,
                               const float* variance, const float* inside, int count, float* cost) {
  for (int x = 0; x < count; ++x) {
    float s = 0, ss = 0, sp = 0;
    for (int k = -window_radius; k <= window_radius; ++k) {
      s += value[x + k];
      ss += square[x + k];
      sp += product[x + k];
    }
    const float m = s * (1 / window_pixels);
    const float var = std::max(ss * (1 / window_pixels) - m * m, 0.0F);
    const float cov = sp * (1 / window_pixels) - m * mean[x];
    const float likeness = (2 * cov + noise_variance) / (var + variance[x] + noise_variance);
    const float c = std::min(std::max(1 - likeness, 0.0F), 1.0F);
    const float unseen = unseen_share * 2 * variance[x] / (2 * variance[x] + noise_variance);
    cost[x] = inside[x] > 0 ? c : unseen;
  }
}

UWV_SIMD_CLONES void window_statistics(const float* value, const float* square, int count, float* mean,
                                       float* variance) {
  for (int x = 0; x < count; ++x) {
    float s = 0, ss = 0;
    for (int k = -window_radius; k <= window_radius; ++k) {
      s += value[x + k];
      ss += square[x + k];
    }
    mean[x] = s * (1 / window_pixels);
    variance[x] = std::max(ss * (1 / window_pixels) - mean[x] * mean[x], 0.0F);
  }
}

UWV_SIMD_CLONES void insert_sorted(float* cost, int count, int kept, std::size_t stride, float* best) {
  for (int k = 0; k < kept; ++k) {
    float* level = best + static_cast<std::size_t>(k) * stride;
    for (int x = 0; x < count; ++x) {
      const float low = std::min(level[x], cost[x]);
      cost[x] = std::max(level[x], cost[x]);
      level[x] = low;
    }
  }
}

UWV_SIMD_CLONES void mean_to_bytes(const float* best, int count, int kept, std::size_t stride, std::uint8_t* out) {
  const float factor = static_cast<float>(worst_cost) / static_cast<float>(kept);
  for (int x = 0; x < count; ++x) {
    float sum = 0;
    for (int k = 0; k < kept; ++k) sum += best[static_cast<std::size_t>(k) * stride + static_cast<std::size_t>(x)];
    out[x] = static_cast<std::uint8_t>(static_cast<int>(sum * factor + 0.5F));
  }
}

}  // namespace uwv::mvs
