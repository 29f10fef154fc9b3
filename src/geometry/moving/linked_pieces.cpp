// SPDX-License-Identifier: Apache-2.0
#include "geometry/moving/linked_pieces.h"

#include <algorithm>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <set>
#include <utility>

#include "geometry/layers/colour_model.h"
#include "geometry/layers/cv_bridge.h"

namespace uwv::moving {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

using layers::view;

/// 255 where it moves.
cv::Mat moving_in(const ValidityMask& static_pixels) { return view(static_pixels) == 0; }

std::vector<cv::Mat> moving_in(std::span<const ValidityMask> static_pixels) {
  std::vector<cv::Mat> out;
  for (const ValidityMask& mask : static_pixels) out.push_back(moving_in(mask));
  return out;
}

cv::Mat disc(int radius) {
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(2 * radius + 1, 2 * radius + 1));
}

/// How far things are taken to move from frame to frame without being lost.
int reach_of(Size size) { return std::max(2, size.height / 40); }

/// Pairs of labels of two pictures that share a pixel.
std::set<std::pair<int, int>> shared_labels(const cv::Mat& a, const cv::Mat& b) {
  std::set<std::pair<int, int>> pairs;
  std::pair<int, int> last{0, 0};
  for (int y = 0; y < a.rows; ++y)
    for (int x = 0; x < a.cols; ++x) {
      const std::pair<int, int> now{a.at<int>(y, x), b.at<int>(y, x)};
      if (now.first == 0 || now.second == 0 || now == last) continue;
      pairs.insert(now);
      last = now;
    }
  return pairs;
}

int root_of(std::vector<int>& parent, int i) {
  while (parent[at(i)] != i) i = parent[at(i)] = parent[at(parent[at(i)])];
  return i;
}

/// Labels spread over the pixels around them; where two meet either may win.
cv::Mat spread(const cv::Mat& labels, int reach) {
  cv::Mat as_float, wide, out;
  labels.convertTo(as_float, CV_32F);
  cv::dilate(as_float, wide, cv::Mat::ones(2 * reach + 1, 2 * reach + 1, CV_8U));
  wide.convertTo(out, CV_32S);
  labels.copyTo(out, labels != 0);
  return out;
}

}  // namespace

LinkedPieces::LinkedPieces(std::vector<cv::Mat> masks, int reach, ThreadPool& pool)
    : masks_(std::move(masks)), counts_(masks_.size()), offsets_(masks_.size() + 1) {
  std::vector<std::set<std::pair<int, int>>> links(masks_.size());
  pool.run(frames(), [&](int i) {
    cv::Mat own;
    counts_[at(i)] = cv::connectedComponents(masks_[at(i)], own, 8, CV_32S);
    if (i + 1 < frames() && counts_[at(i)] > 1) links[at(i)] = shared_labels(spread(own, reach), labels(i + 1));
  });
  for (std::size_t i = 0; i < masks_.size(); ++i) offsets_[i + 1] = offsets_[i] + counts_[i];
  std::vector<int> parent(at(offsets_.back()));
  std::iota(parent.begin(), parent.end(), 0);
  for (int i = 0; i + 1 < frames(); ++i)
    for (const auto& [here, next] : links[at(i)]) {
      const int a = root_of(parent, offsets_[at(i)] + here), b = root_of(parent, offsets_[at(i + 1)] + next);
      parent[at(std::max(a, b))] = std::min(a, b);
    }
  chain_of_.assign(parent.size(), -1);
  for (int i = 0; i < frames(); ++i)
    for (int label = 1; label < counts_[at(i)]; ++label) {
      const int root = root_of(parent, offsets_[at(i)] + label);
      if (chain_of_[at(root)] < 0) {
        chain_of_[at(root)] = chain_count();
        first_.push_back(i);
        last_.push_back(i);
      }
      const int chain = chain_of_[at(offsets_[at(i)] + label)] = chain_of_[at(root)];
      last_[at(chain)] = i;
    }
}

cv::Mat LinkedPieces::labels(int frame) const {
  cv::Mat out;
  cv::connectedComponents(masks_[at(frame)], out, 8, CV_32S);
  return out;
}

int LinkedPieces::chain(int frame, int label) const { return chain_of_[at(offsets_[at(frame)] + label)]; }

namespace {

/// Pixels of each chain of the foreground in each frame, and how many of them move.
struct MovingShares {
  std::vector<std::vector<double>> area, moving;  ///< [chain][frame]

  MovingShares(const LinkedPieces& pieces, std::span<const ValidityMask> static_pixels, ThreadPool& pool)
      : area(at(pieces.chain_count()), std::vector<double>(at(pieces.frames()), 0.0)), moving(area) {
    pool.run(pieces.frames(), [&](int i) {
      const cv::Mat labels = pieces.labels(i);
      for (int y = 0; y < labels.rows; ++y)
        for (int x = 0; x < labels.cols; ++x) {
          const int label = labels.at<int>(y, x);
          if (label == 0) continue;
          const std::size_t chain = at(pieces.chain(i, label));
          area[chain][at(i)] += 1;
          moving[chain][at(i)] += static_pixels[at(i)](x, y) == 0 ? 1 : 0;
        }
    });
  }

  double around(int chain, int frame, int window) const {
    double moves = 0, all = 0;
    const int frames = static_cast<int>(area[at(chain)].size());
    for (int i = std::max(0, frame - window); i <= std::min(frames - 1, frame + window); ++i) {
      moves += moving[at(chain)][at(i)];
      all += area[at(chain)][at(i)];
    }
    return all > 0 ? moves / all : 0;
  }
};

/// Logarithm of the odds that a pixel has the colours of `adopted` rather than of what surrounds it, averaged over a
/// few pixels (CV_32F).
cv::Mat colour_odds(const cv::Mat& picture, const cv::Mat& adopted, int reach) {
  layers::ColourModel colours;
  colours.learn(picture, adopted, reach, 1.0);
  cv::Mat odds(picture.size(), CV_32F);
  for (int y = 0; y < odds.rows; ++y)
    for (int x = 0; x < odds.cols; ++x) odds.at<float>(y, x) = colours.log_odds(picture.at<cv::Vec3b>(y, x));
  cv::blur(odds, odds, cv::Size(5, 5));
  return odds;
}

/// Settles by colour what motion and foreground disagree on around an adopted piece: the flow's blur beyond the outline
/// goes back to the static scene, and feet that the foreground has lost are found again. `moves` is changed.
void settle_outline(const cv::Mat& picture, const cv::Mat& adopted, cv::Mat& moves) {
  constexpr float sure = 1, unlike = -0.7F;  // Dark clothes before a dark wall must not cost what motion has found.
  const int reach = std::max(2, moves.rows / 24), surroundings = 2 * reach;
  cv::Mat near, nearer;
  cv::dilate(adopted, near, disc(reach));
  cv::dilate(adopted | (moves & near), nearer, disc(reach));
  cv::Rect box = cv::boundingRect(nearer);
  box = cv::Rect(box.x - reach, box.y - reach, box.width + 2 * reach, box.height + 2 * reach) &
        cv::Rect(0, 0, moves.cols, moves.rows);
  const cv::Mat odds = colour_odds(picture(box), adopted(box), surroundings);
  const cv::Mat own = adopted(box);
  cv::Mat inside = own | (moves(box) & near(box) & (odds > unlike)) | (nearer(box) & (odds > sure));
  cv::morphologyEx(inside, inside, cv::MORPH_OPEN, disc(std::max(1, reach / 10)));
  inside |= own;
  cv::Mat labels, kept = cv::Mat::zeros(inside.size(), CV_8U);
  std::vector<std::uint8_t> touches(at(cv::connectedComponents(inside, labels, 8, CV_32S)), 0);
  for (int y = 0; y < labels.rows; ++y)
    for (int x = 0; x < labels.cols; ++x)
      if (own.at<std::uint8_t>(y, x) != 0) touches[at(labels.at<int>(y, x))] = 255;
  for (int y = 0; y < labels.rows; ++y)
    for (int x = 0; x < labels.cols; ++x)
      if (inside.at<std::uint8_t>(y, x) != 0) kept.at<std::uint8_t>(y, x) = touches[at(labels.at<int>(y, x))];
  moves(box).setTo(0, near(box));
  moves(box) |= kept;
}

}  // namespace

void adopt_foreground(std::span<const ImageRgb> frames, std::span<const ForegroundMask> foreground, double agreement,
                      int window, ThreadPool& pool, std::vector<ValidityMask>& static_pixels) {
  std::vector<cv::Mat> masks;
  for (const ForegroundMask& mask : foreground) masks.push_back(view(mask));
  const LinkedPieces pieces(masks, reach_of(foreground[0].size()), pool);
  const MovingShares shares(pieces, static_pixels, pool);
  pool.run(pieces.frames(), [&](int i) {
    std::vector<std::uint8_t> taken(at(pieces.label_count(i)), 0);
    for (int label = 1; label < pieces.label_count(i); ++label)
      taken[at(label)] = shares.around(pieces.chain(i, label), i, window) >= agreement ? 255 : 0;
    const cv::Mat labels = pieces.labels(i);
    cv::Mat adopted(labels.size(), CV_8U);
    for (int y = 0; y < labels.rows; ++y)
      for (int x = 0; x < labels.cols; ++x) adopted.at<std::uint8_t>(y, x) = taken[at(labels.at<int>(y, x))];
    if (cv::countNonZero(adopted) == 0) return;
    ValidityMask& mask = static_pixels[at(i)];
    cv::Mat moves = moving_in(mask);
    settle_outline(view(frames[at(i)]), adopted, moves);
    view(mask).setTo(0, moves);
    view(mask).setTo(1, moves == 0);
  });
}

int drop_fleeting(int least_life, double smallest, ThreadPool& pool, std::vector<ValidityMask>& static_pixels) {
  const LinkedPieces pieces(moving_in(static_pixels), reach_of(static_pixels[0].size()), pool);
  const int least = std::min(least_life, pieces.frames());
  std::vector<int> left(static_pixels.size(), 0);
  pool.run(pieces.frames(), [&](int i) {
    if (pieces.label_count(i) <= 1) return;
    const cv::Mat labels = pieces.labels(i);
    std::vector<double> area(at(pieces.label_count(i)), 0);
    for (int y = 0; y < labels.rows; ++y)
      for (int x = 0; x < labels.cols; ++x) area[at(labels.at<int>(y, x))] += 1;
    std::vector<char> stays(area.size(), 1);
    for (int label = 1; label < pieces.label_count(i); ++label) {
      stays[at(label)] = pieces.life(pieces.chain(i, label)) >= least && area[at(label)] >= smallest ? 1 : 0;
      left[at(i)] += stays[at(label)];
    }
    for (int y = 0; y < labels.rows; ++y)
      for (int x = 0; x < labels.cols; ++x)
        if (stays[at(labels.at<int>(y, x))] == 0) static_pixels[at(i)](x, y) = 1;
  });
  return std::accumulate(left.begin(), left.end(), 0);
}

void close_holes(double share_of_piece, ThreadPool& pool, std::vector<ValidityMask>& static_pixels) {
  pool.run(static_cast<int>(static_pixels.size()), [&](int i) {
    const cv::Mat moves = moving_in(static_pixels[at(i)]);
    if (cv::countNonZero(moves) == 0) return;
    cv::Mat piece_labels, piece_stats, hole_labels, hole_stats, centres;
    cv::connectedComponentsWithStats(moves, piece_labels, piece_stats, centres, 8, CV_32S);
    const int holes = cv::connectedComponentsWithStats(moves == 0, hole_labels, hole_stats, centres, 4, CV_32S);
    for (int hole = 1; hole < holes; ++hole) {
      const cv::Rect box(hole_stats.at<int>(hole, cv::CC_STAT_LEFT), hole_stats.at<int>(hole, cv::CC_STAT_TOP),
                         hole_stats.at<int>(hole, cv::CC_STAT_WIDTH), hole_stats.at<int>(hole, cv::CC_STAT_HEIGHT));
      if (box.x == 0 || box.y == 0 || box.br().x == moves.cols || box.br().y == moves.rows) continue;
      // What is just left of its first pixel is the piece around it.
      int x = box.x;
      while (hole_labels.at<int>(box.y, x) != hole) ++x;
      const int around = piece_stats.at<int>(piece_labels.at<int>(box.y, x - 1), cv::CC_STAT_AREA);
      if (hole_stats.at<int>(hole, cv::CC_STAT_AREA) > share_of_piece * around) continue;
      view(static_pixels[at(i)])(box).setTo(0, hole_labels(box) == hole);
    }
  });
}

}  // namespace uwv::moving
