// SPDX-License-Identifier: Apache-2.0
#include "geometry/mvs/consistency.h"

#include <algorithm>
#include <cmath>

#include "geometry/mvs/reprojection.h"

namespace uwv::mvs {
namespace {

// Below this share of the largest possible margin, the choice of plane is chance.
constexpr float least_distinctness = 0.01F;
constexpr int agreement_of_full_trust = 4;
// Above this cost nothing looks alike even at the best depth; one other view may then agree by chance, two hardly.
constexpr float doubtful_cost = 0.3F;

}  // namespace

RatedDepth confirm(const MatchedView& reference, const std::vector<MatchedView>& others, double tolerance) {
  const InverseDepthMap& own = reference.depth->inverse_depth;
  RatedDepth out{InverseDepthMap(own.size()), Image<float>(own.size())};
  std::vector<Reprojection> reprojections;
  for (const MatchedView& other : others)
    reprojections.push_back(make_reprojection(reference.view->camera, other.view->camera));
  for (int y = 0; y < own.height(); ++y) {
    for (int x = 0; x < own.width(); ++x) {
      const float w = own(x, y);
      const float distinctness = reference.depth->distinctness(x, y);
      if (w <= 0 || distinctness < least_distinctness) continue;
      if (!reference.view->usable.empty() && reference.view->usable(x, y) == 0) continue;
      float sum = w;
      int agree = 0;
      for (std::size_t k = 0; k < others.size(); ++k) {
        const float agreed =
            agreed_inverse_depth(reprojections[k], others[k].depth->inverse_depth, static_cast<float>(x) + 0.5F,
                                 static_cast<float>(y) + 0.5F, w, static_cast<float>(tolerance));
        if (agreed <= 0) continue;
        sum += agreed;
        ++agree;
      }
      const bool looks_alike = reference.depth->cost(x, y) <= doubtful_cost;
      if (agree < (looks_alike ? 1 : 2)) continue;
      out.inverse_depth(x, y) = sum / static_cast<float>(agree + 1);
      const float share = std::min(1.0F, static_cast<float>(agree) / agreement_of_full_trust);
      out.confidence(x, y) = 0.5F + 0.35F * share + 0.15F * std::min(1.0F, 4 * distinctness);
    }
  }
  return out;
}

void remove_speckles(RatedDepth& depth, int smallest, double tolerance) {
  const int width = depth.inverse_depth.width();
  const int height = depth.inverse_depth.height();
  const auto limit = static_cast<float>(tolerance);
  float* w = depth.inverse_depth.data();
  std::vector<std::uint8_t> seen(depth.inverse_depth.size().pixels());
  std::vector<int> patch;
  for (int start = 0; start < width * height; ++start) {
    if (seen[static_cast<std::size_t>(start)] != 0 || w[start] <= 0) continue;
    patch.assign(1, start);
    seen[static_cast<std::size_t>(start)] = 1;
    for (std::size_t i = 0; i < patch.size(); ++i) {
      const int at = patch[i];
      const int x = at % width;
      const auto visit = [&](int next, bool inside) {
        if (!inside || seen[static_cast<std::size_t>(next)] != 0 || w[next] <= 0) return;
        if (std::abs(w[next] - w[at]) > limit * std::min(w[next], w[at])) return;
        seen[static_cast<std::size_t>(next)] = 1;
        patch.push_back(next);
      };
      visit(at - 1, x > 0);
      visit(at + 1, x + 1 < width);
      visit(at - width, at >= width);
      visit(at + width, at + width < width * height);
    }
    if (static_cast<int>(patch.size()) >= smallest) continue;
    for (const int at : patch) {
      w[at] = 0;
      depth.confidence.data()[at] = 0;
    }
  }
}

}  // namespace uwv::mvs
