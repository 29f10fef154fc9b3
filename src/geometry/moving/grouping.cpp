// SPDX-License-Identifier: Apache-2.0
#include "geometry/moving/grouping.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <set>

namespace uwv::moving {
namespace {

/// Pieces are near when the gap between them is at most this share of the picture's height.
constexpr double near_gap = 1.0 / 16;
/// Two pieces are one thing when they are near in this share of the frames that show both...
constexpr double near_share = 0.5;
/// ...and their flow differs by less than this share of the picture's height per frame, on average. Limbs swing.
constexpr double alike_step = 0.02;

/// What lives for fewer frames is a splinter of what it is near, however it moves.
constexpr int brief_life = 5;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::vector<std::pair<int, int>> near_pairs(const std::vector<Piece>& pieces, const cv::Mat& labels) {
  if (pieces.size() < 2) return {};
  const int reach = std::max(2, static_cast<int>(near_gap * labels.rows));
  cv::Mat as_float, highest;
  labels.convertTo(as_float, CV_32F);
  cv::dilate(as_float, highest, cv::Mat::ones(2 * reach + 1, 2 * reach + 1, CV_8U));
  std::set<std::pair<int, int>> pairs;
  for (int y = 0; y < labels.rows; ++y)
    for (int x = 0; x < labels.cols; ++x) {
      const int own = labels.at<int>(y, x), other = static_cast<int>(highest.at<float>(y, x));
      if (own > 0 && other > own) pairs.emplace(own - 1, other - 1);
    }
  return {pairs.begin(), pairs.end()};
}

std::vector<cv::Vec2f> mean_steps(const std::vector<Piece>& pieces, const cv::Mat& labels, const cv::Mat& flow) {
  std::vector<cv::Vec2f> sums(pieces.size(), cv::Vec2f(0, 0));
  std::vector<float> counts(pieces.size(), 0);
  for (int y = 0; y < flow.rows; ++y)
    for (int x = 0; x < flow.cols; ++x) {
      const int label = labels.at<int>(y * labels.rows / flow.rows, x * labels.cols / flow.cols);
      if (label == 0) continue;
      sums[at(label - 1)] += flow.at<cv::Vec2f>(y, x);
      counts[at(label - 1)] += 1;
    }
  for (std::size_t i = 0; i < sums.size(); ++i)
    sums[i] *= counts[i] > 0 ? 1 / (counts[i] * static_cast<float>(flow.rows)) : 0.0F;
  return sums;
}

/// A piece followed from frame to frame.
struct Thread {
  int first_frame = 0;
  std::vector<int> pieces;  ///< Index in each frame.
};

/// Threads, and for each piece of each frame the thread it is in.
struct Threads {
  std::vector<Thread> all;
  std::vector<std::vector<int>> of;

  Threads(const std::vector<std::size_t>& pieces_of_frame, const std::vector<PieceRelations>& relations) {
    for (std::size_t frame = 0; frame < pieces_of_frame.size(); ++frame) {
      std::vector<int>& own = of.emplace_back(pieces_of_frame[frame], -1);
      if (frame > 0)
        for (std::size_t p = 0; p < of[frame - 1].size(); ++p)
          if (relations[frame - 1].becomes[p] >= 0) own[at(relations[frame - 1].becomes[p])] = of[frame - 1][p];
      for (std::size_t p = 0; p < own.size(); ++p) {
        if (own[p] < 0) {
          own[p] = static_cast<int>(all.size());
          all.emplace_back().first_frame = static_cast<int>(frame);
        }
        all[at(own[p])].pieces.push_back(static_cast<int>(p));
      }
    }
  }

  int life(int thread) const { return static_cast<int>(all[at(thread)].pieces.size()); }

  int common_frames(int a, int b) const {
    const Thread &one = all[at(a)], &two = all[at(b)];
    const int from = std::max(one.first_frame, two.first_frame);
    const int to = std::min(one.first_frame + static_cast<int>(one.pieces.size()),
                            two.first_frame + static_cast<int>(two.pieces.size()));
    return to - from;
  }
};

struct Company {
  int near_frames = 0;
  double apart = 0;  ///< Sum over those frames of the difference of their steps.
};

}  // namespace

PieceRelations relate_pieces(const std::vector<Piece>& pieces, const cv::Mat& labels, const cv::Mat& flow,
                             const std::vector<Piece>& next, const cv::Mat& next_labels) {
  PieceRelations out;
  out.nearby = near_pairs(pieces, labels);
  out.becomes.assign(pieces.size(), -1);
  out.steps.assign(pieces.size(), cv::Vec2f(0, 0));
  if (flow.empty()) return out;
  out.steps = mean_steps(pieces, labels, flow);
  if (!next.empty()) out.becomes = follow_pieces(pieces, labels, flow, next, next_labels);
  return out;
}

std::vector<std::vector<int>> group_pieces(const std::vector<std::size_t>& pieces_of_frame,
                                           const std::vector<PieceRelations>& relations) {
  const Threads threads(pieces_of_frame, relations);
  std::map<std::pair<int, int>, Company> company;
  for (std::size_t frame = 0; frame < relations.size(); ++frame)
    for (const auto& [p, q] : relations[frame].nearby) {
      const int a = threads.of[frame][at(p)], b = threads.of[frame][at(q)];
      Company& together = company[{std::min(a, b), std::max(a, b)}];
      together.near_frames += 1;
      together.apart += cv::norm(relations[frame].steps[at(p)] - relations[frame].steps[at(q)]);
    }
  std::vector<int> parent(threads.all.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[at(i)] != i) i = parent[at(i)] = parent[at(parent[at(i)])];
    return i;
  };
  for (const auto& [pair, together] : company) {
    if (together.near_frames < near_share * threads.common_frames(pair.first, pair.second)) continue;
    const bool brief = std::min(threads.life(pair.first), threads.life(pair.second)) < brief_life;
    if (!brief && together.apart > alike_step * together.near_frames) continue;
    const int a = root(pair.first), b = root(pair.second);
    parent[at(std::max(a, b))] = std::min(a, b);
  }
  std::vector<std::vector<int>> objects;
  std::map<int, int> numbered;
  for (const std::vector<int>& of_frame : threads.of) {
    std::vector<int>& out = objects.emplace_back();
    for (const int thread : of_frame)
      out.push_back(numbered.emplace(root(thread), static_cast<int>(numbered.size())).first->second);
  }
  return objects;
}

}  // namespace uwv::moving
