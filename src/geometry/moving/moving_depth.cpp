// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cmath>

#include "geometry/deterministic_cv.h"
#include "geometry/moving/dense_flow.h"
#include "geometry/moving/grouping.h"
#include "geometry/moving/pieces.h"
#include "uwv/geometry/moving_objects.h"

namespace uwv {
namespace {

using moving::Piece;

/// Frames between two reports to the monitor.
constexpr int frames_at_once = 8;
/// A contact this far (relative) from the median of its neighbours in time is a mistake.
constexpr double contact_outlier = 0.25;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// One object over time: its piece in each frame, and what was made of it.
struct Track {
  int first_frame = 0;
  std::vector<const Piece*> pieces;
  std::vector<MovingDepthSource> sources;
  std::vector<double> at_foot;  ///< Inverse depth; 0 = none.
  std::vector<Eigen::Vector3d> up_in_cam;
};

/// What moves in each frame, one piece an object, and which objects they are.
struct Pieces {
  std::vector<std::vector<Piece>> of_frame;
  std::vector<std::vector<int>> numbers;
  int objects = 0;
};

/// The pieces of one frame as they are joined in `pieces`, and their labels.
cv::Mat joined_labels(const ValidityMask& static_pixels, const std::vector<int>& objects) {
  cv::Mat labels;
  std::vector<int> numbers;
  const std::vector<Piece> parts = moving::find_pieces(static_pixels, labels);
  moving::join_pieces(parts, objects, labels, numbers);
  return labels;
}

/// Runs body(i) for each of the frames, some at a time, and reports.
template <class Body>
void in_chunks(int count, int first_step, ThreadPool& pool, Monitor& monitor, const Body& body) {
  for (int first = 0; first < count; first += frames_at_once) {
    monitor.step("moving depth", first_step + first, 3L * count);
    pool.run(std::min(frames_at_once, count - first), [&](int part) { body(first + part); });
  }
}

/// The object each connected piece of each frame belongs to.
std::vector<std::vector<int>> find_objects(std::span<const ImageRgb> frames,
                                           std::span<const ValidityMask> static_pixels, int flow_height,
                                           ThreadPool& pool, Monitor& monitor) {
  const int count = static_cast<int>(frames.size());
  const Size small = moving::shrunk_size(frames[0].size(), flow_height);
  std::vector<moving::PieceRelations> relations(frames.size());
  std::vector<std::size_t> pieces_of_frame(frames.size(), 0);
  in_chunks(count, 0, pool, monitor, [&](int i) {
    cv::Mat labels, next_labels, flow;
    std::vector<Piece> next;
    const std::vector<Piece> pieces = moving::find_pieces(static_pixels[at(i)], labels);
    pieces_of_frame[at(i)] = pieces.size();
    if (pieces.empty()) return;
    if (i + 1 < count) {
      next = moving::find_pieces(static_pixels[at(i + 1)], next_labels);
      flow =
          moving::dense_flow(moving::shrunk_grey(frames[at(i)], small), moving::shrunk_grey(frames[at(i + 1)], small));
    }
    relations[at(i)] = moving::relate_pieces(pieces, labels, flow, next, next_labels);
  });
  return moving::group_pieces(pieces_of_frame, relations);
}

/// Forgets contacts with what is no ground. Ground is level for an upright camera, or as the ground in other frames is:
/// a camera that looks steeply down sees it as a wall.
void keep_ground(std::span<const Camera> cameras, double ground_tilt, std::vector<std::vector<Piece>>& pieces) {
  constexpr double like_other_ground = 0.5;  // radians
  const auto level = [&](std::size_t frame, const Piece& piece) {
    const double up = cameras[frame].intrinsics.fy > 0 ? -piece.normal_in_cam.y() : piece.normal_in_cam.y();
    return up >= std::cos(ground_tilt);
  };
  Eigen::Vector3d up_in_world = Eigen::Vector3d::Zero();
  const auto in_world = [&](std::size_t frame, const Piece& piece) -> Eigen::Vector3d {
    return cameras[frame].world_from_cam.rotation * piece.normal_in_cam;
  };
  for (std::size_t i = 0; i < pieces.size(); ++i)
    for (const Piece& piece : pieces[i])
      if (piece.contact > 0 && level(i, piece)) up_in_world += piece.area * in_world(i, piece);
  const bool known = up_in_world.norm() > 0;
  if (known) up_in_world.normalize();
  for (std::size_t i = 0; i < pieces.size(); ++i)
    for (Piece& piece : pieces[i]) {
      const bool alike = known && in_world(i, piece).dot(up_in_world) >= std::cos(like_other_ground);
      if (!level(i, piece) && !alike) piece.contact = 0;
    }
}

Pieces look_at_pieces(std::span<const Camera> cameras, std::span<const ValidityMask> static_pixels,
                      const std::vector<std::vector<int>>& objects, const std::vector<FrameGeometry>& geometry,
                      const MovingDepthOptions& options, ThreadPool& pool, Monitor& monitor) {
  const int count = static_cast<int>(cameras.size());
  Pieces pieces;
  pieces.of_frame.resize(cameras.size());
  pieces.numbers.resize(cameras.size());
  in_chunks(count, count, pool, monitor, [&](int i) {
    cv::Mat labels;
    const std::vector<Piece> parts = moving::find_pieces(static_pixels[at(i)], labels);
    pieces.of_frame[at(i)] = moving::join_pieces(parts, objects[at(i)], labels, pieces.numbers[at(i)]);
    for (Piece& piece : pieces.of_frame[at(i)])
      moving::measure_piece(piece, labels, geometry[at(i)].depth, cameras[at(i)].intrinsics, options);
  });
  keep_ground(cameras, options.ground_tilt, pieces.of_frame);
  for (const std::vector<int>& numbers : pieces.numbers)
    for (const int number : numbers) pieces.objects = std::max(pieces.objects, number + 1);
  return pieces;
}

std::vector<Track> tracks_of(const Pieces& pieces) {
  std::vector<Track> tracks(at(pieces.objects));
  for (std::size_t frame = 0; frame < pieces.of_frame.size(); ++frame)
    for (std::size_t p = 0; p < pieces.of_frame[frame].size(); ++p) {
      Track& track = tracks[at(pieces.numbers[frame][p])];
      if (track.pieces.empty()) track.first_frame = static_cast<int>(frame);
      track.pieces.push_back(&pieces.of_frame[frame][p]);
    }
  return tracks;
}

/// Median of the contacts within three frames; 0 when there is none.
double median_contact(const Track& track, int i) {
  std::vector<double> near;
  for (int j = std::max(0, i - 3); j <= std::min(static_cast<int>(track.pieces.size()) - 1, i + 3); ++j)
    if (track.pieces[at(j)]->contact > 0) near.push_back(track.pieces[at(j)]->contact);
  if (near.empty()) return 0;
  std::nth_element(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(near.size() / 2), near.end());
  return near[near.size() / 2];
}

/// A straight line through the values around frame i, weighted by a Gaussian in time; unlike an average it does not lag
/// at the ends. Larger values (nearer places) weigh more: feet that were not found, and jumps, only ever make a contact
/// look farther.
double smoothed(const std::vector<double>& values, int i, double deviation) {
  if (!(deviation > 0)) return values[at(i)];
  constexpr double weight_of_nearer = 3;
  constexpr int rounds = 5;
  const int reach = static_cast<int>(std::ceil(3 * deviation));
  double constant = 0, slope = 0;
  for (int round = 0; round < rounds; ++round) {
    double s0 = 0, s1 = 0, s2 = 0, v0 = 0, v1 = 0;
    for (int j = std::max(0, i - reach); j <= std::min(static_cast<int>(values.size()) - 1, i + reach); ++j) {
      if (!(values[at(j)] > 0)) continue;
      const double t = j - i, nearer = values[at(j)] > constant + slope * t ? weight_of_nearer : 1;
      const double weight = nearer * std::exp(-0.5 * t * t / (deviation * deviation));
      s0 += weight, s1 += weight * t, s2 += weight * t * t;
      v0 += weight * values[at(j)], v1 += weight * t * values[at(j)];
    }
    if (!(s0 > 0)) return 0;
    const double determinant = s0 * s2 - s1 * s1;
    const bool straight = determinant > 1e-9 * s0 * s0 && s2 * v0 - s1 * v1 > 0;
    constant = straight ? (s2 * v0 - s1 * v1) / determinant : v0 / s0;
    slope = straight ? (s0 * v1 - s1 * v0) / determinant : 0;
  }
  return constant;
}

void place_by_contact(Track& track) {
  for (int i = 0; i < static_cast<int>(track.pieces.size()); ++i) {
    const double contact = track.pieces[at(i)]->contact, around = median_contact(track, i);
    if (!(contact > 0) || std::abs(contact - around) > contact_outlier * around) continue;
    track.at_foot[at(i)] = contact;
    track.sources[at(i)] = MovingDepthSource::contact;
    track.up_in_cam[at(i)] = track.pieces[at(i)]->normal_in_cam;
  }
}

/// Where contact is lost, the object is as much nearer as it looks larger than in the nearest frame with contact.
void place_by_size(Track& track) {
  const int count = static_cast<int>(track.pieces.size());
  for (int i = 0; i < count; ++i) {
    if (track.sources[at(i)] == MovingDepthSource::contact) continue;
    for (int away = 1; away < count && track.sources[at(i)] == MovingDepthSource::none; ++away)
      for (const int j : {i - away, i + away}) {
        if (j < 0 || j >= count || track.sources[at(j)] != MovingDepthSource::contact) continue;
        track.at_foot[at(i)] = track.at_foot[at(j)] * moving::size_ratio(*track.pieces[at(i)], *track.pieces[at(j)]);
        track.up_in_cam[at(i)] = track.up_in_cam[at(j)];
        track.sources[at(i)] = MovingDepthSource::size;
        break;
      }
  }
}

/// Without any contact: as far away as fits in front of the background in all frames, growing as it grows in the
/// picture.
void place_by_background(Track& track) {
  double scale = 0;
  for (const Piece* piece : track.pieces)
    scale = std::max(scale, 1.05 * piece->behind_median / moving::size_ratio(*piece, *track.pieces[0]));
  if (!(scale > 0)) return;
  for (std::size_t i = 0; i < track.pieces.size(); ++i) {
    track.at_foot[i] = scale * moving::size_ratio(*track.pieces[i], *track.pieces[0]);
    track.sources[i] = MovingDepthSource::background;
  }
}

void place(Track& track, std::span<const Camera> cameras, double smoothing) {
  const std::size_t count = track.pieces.size();
  track.sources.assign(count, MovingDepthSource::none);
  track.at_foot.assign(count, 0.0);
  for (std::size_t i = 0; i < count; ++i)
    track.up_in_cam.emplace_back(0, cameras[at(track.first_frame) + i].intrinsics.fy > 0 ? -1 : 1, 0);
  place_by_contact(track);
  place_by_size(track);
  if (track.sources[0] == MovingDepthSource::none) place_by_background(track);
  const std::vector<double> rough = track.at_foot;
  for (int i = 0; i < static_cast<int>(count); ++i) track.at_foot[at(i)] = smoothed(rough, i, smoothing);
}

float confidence_of(MovingDepthSource source, double of_contact) {
  switch (source) {
    case MovingDepthSource::contact: return static_cast<float>(of_contact);
    case MovingDepthSource::size: return static_cast<float>(of_contact / 2);
    case MovingDepthSource::background: return static_cast<float>(of_contact / 3);
    default: return 0;
  }
}

void paint(const std::vector<Track>& tracks, std::span<const Camera> cameras,
           std::span<const ValidityMask> static_pixels, const std::vector<std::vector<int>>& objects,
           const MovingDepthOptions& options, ThreadPool& pool, std::vector<FrameGeometry>& geometry) {
  pool.run(static_cast<int>(geometry.size()), [&](int frame) {
    const cv::Mat labels = joined_labels(static_pixels[at(frame)], objects[at(frame)]);
    FrameGeometry& out = geometry[at(frame)];
    for (std::size_t p = 0; p < out.depth.pixels().size(); ++p)
      if (static_pixels[at(frame)].pixels()[p] == 0) out.depth.pixels()[p] = 0, out.confidence.pixels()[p] = 0;
    for (const Track& track : tracks) {
      const int i = frame - track.first_frame;
      if (i < 0 || i >= static_cast<int>(track.pieces.size()) || !(track.at_foot[at(i)] > 0)) continue;
      const moving::Stand stand{track.at_foot[at(i)], track.up_in_cam[at(i)],
                                confidence_of(track.sources[at(i)], options.confidence)};
      moving::paint_piece(*track.pieces[at(i)], labels, stand, cameras[at(frame)].intrinsics, options, out);
    }
  });
}

MovingDepthSummary summarise(const std::vector<Track>& tracks) {
  MovingDepthSummary summary;
  double area[4] = {0, 0, 0, 0}, all = 0;
  for (const Track& track : tracks) {
    MovingObject& object = summary.objects.emplace_back();
    object.first_frame = track.first_frame;
    object.sources = track.sources;
    for (std::size_t i = 0; i < track.pieces.size(); ++i) {
      object.depths.push_back(track.at_foot[i] > 0 ? 1 / track.at_foot[i] : 0.0);
      area[static_cast<int>(track.sources[i])] += track.pieces[i]->area;
      all += track.pieces[i]->area;
    }
  }
  if (!(all > 0)) return summary;
  const auto share = [&](MovingDepthSource source) { return area[static_cast<int>(source)] / all; };
  summary.contact_share = share(MovingDepthSource::contact);
  summary.unknown_share = share(MovingDepthSource::none);
  const auto note = [&](MovingDepthSource source, const char* sentence) {
    if (share(source) > 0)
      summary.notes.push_back(fmt::format("{:.1f} % of the moving pixels {}", 100 * share(source), sentence));
  };
  note(MovingDepthSource::contact,
       "stand where they touch the ground, which is an assumption: things in the air are "
       "put too far away");
  note(MovingDepthSource::size, "touch no visible ground in their frame and were placed by their change of size");
  note(MovingDepthSource::background,
       "touch no visible ground in any frame and were put just in front of what is "
       "behind them: their depth is a bound only");
  note(MovingDepthSource::none, "have no static depth around them and got none");
  return summary;
}

}  // namespace

void MovingDepthOptions::check() const {
  require(contact_strip > 0 && contact_strip <= 2, "contact_strip {} is outside (0, 2]", contact_strip);
  require(ground_tilt > 0 && ground_tilt < 1.5, "ground_tilt {} rad is outside (0, 1.5)", ground_tilt);
  require(smoothing >= 0 && smoothing <= 100, "smoothing {} is outside 0..100", smoothing);
  require(lean >= 0 && lean <= 1, "lean {} is outside 0..1", lean);
  require(relief >= 0 && relief <= 2, "relief {} is outside 0..2", relief);
  require(confidence >= 0 && confidence < 0.5, "confidence {} of moving depth is outside [0, 0.5)", confidence);
  require(flow_height >= 32 && flow_height <= 4320, "flow_height {} is outside 32..4320", flow_height);
}

std::string MovingDepthSummary::brief() const {
  return fmt::format("{} moving objects, {:.0f} % placed by contact with the ground, {:.0f} % without depth, {:.1f} s",
                     objects.size(), 100 * contact_share, 100 * unknown_share, seconds);
}

MovingDepthSummary fill_moving_depth(std::span<const ImageRgb> frames, std::span<const Camera> cameras,
                                     std::span<const ValidityMask> static_pixels, const MovingDepthOptions& options,
                                     ThreadPool& pool, Monitor& monitor, std::vector<FrameGeometry>& geometry) {
  options.check();
  const auto begin = std::chrono::steady_clock::now();
  require(cameras.size() == frames.size() && static_pixels.size() == frames.size() && geometry.size() == frames.size(),
          "fill_moving_depth: {} frames, {} cameras, {} masks and {} depth maps", frames.size(), cameras.size(),
          static_pixels.size(), geometry.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Size size = frames[0].size();
    require(size.pixels() > 0 && frames[i].size() == size && static_pixels[i].size() == size &&
                geometry[i].depth.size() == size && geometry[i].confidence.size() == size,
            "fill_moving_depth: what belongs to frame {} is not all {}x{}", i, size.width, size.height);
  }
  if (frames.empty()) return {};
  const DeterministicCv deterministic;
  const auto objects = find_objects(frames, static_pixels, options.flow_height, pool, monitor);
  const Pieces pieces = look_at_pieces(cameras, static_pixels, objects, geometry, options, pool, monitor);
  std::vector<Track> tracks = tracks_of(pieces);
  for (Track& track : tracks) place(track, cameras, options.smoothing);
  // From here on nothing stops: depth is written for all frames or none.
  monitor.step("moving depth", 2 * static_cast<long>(frames.size()), 3 * static_cast<long>(frames.size()));
  paint(tracks, cameras, static_pixels, objects, options, pool, geometry);
  MovingDepthSummary summary = summarise(tracks);
  summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return summary;
}

}  // namespace uwv
