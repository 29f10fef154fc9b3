// SPDX-License-Identifier: Apache-2.0
#include "trajectory/keyframe_path.h"

#include <algorithm>
#include <cmath>

#include "trajectory/rotations.h"
#include "uwv/trajectory/pose_spline.h"

namespace uwv::detail {
namespace {

/// A keyframe as the subject world sees it.
struct Key {
  double time = 0;  ///< 0 = first frame, 1 = last.
  SpherePlace sphere;
  bool on_sphere = false;  ///< `sphere` says it all but for the roll.
  Eigen::Vector3d position;
  Eigen::Vector3d target = Eigen::Vector3d::Zero();
  bool has_target = false;  ///< `rotation` follows from position, target and roll.
  double roll = 0;
  Eigen::Matrix3d rotation;
  double log_zoom = 0;
  Easing easing = Easing::linear;
};

class KeyframePath {
 public:
  KeyframePath(const KeyframeMotion& motion, const TrajectorySpec& spec, const PathContext& context, long frames)
      : spec_(spec), context_(context), frames_(frames) {
    for (std::size_t i = 0; i < motion.keyframes.size(); ++i) keys_.push_back(make_key(motion, i));
    for (std::size_t i = 1; i < keys_.size(); ++i)
      if (!(keys_[i - 1].time < keys_[i].time))
        refuse(i, fmt::format("its time, {:g} of the path, is not after the previous keyframe's, {:g}", keys_[i].time,
                              keys_[i - 1].time));
  }

  CameraPath build() const {
    const auto all = [&](auto property) { return std::all_of(keys_.begin(), keys_.end(), property); };
    CameraPath path;
    if (all([](const Key& key) { return key.on_sphere; }))
      path.subject_from_cam = poses_on_sphere();
    else if (all([](const Key& key) { return key.has_target; }))
      path.subject_from_cam = poses_with_targets();
    else
      path.subject_from_cam = poses_freely();
    const PointSpline log_zoom = curve(1, [](const Key& key) { return Eigen::VectorXd::Constant(1, key.log_zoom); });
    for (long k = 0; k < frames_; ++k) path.zoom.push_back(std::exp(log_zoom(time_of(k))[0]));
    return path;
  }

 private:
  [[noreturn]] void refuse(std::size_t key, std::string_view sentence, std::string_view member = "") const {
    fail(ErrorCode::value_invalid, "{}: /keyframes/{}{}: {}", spec_.name, key, member, sentence);
  }

  double fraction(long frame) const {
    return frames_ > 1 ? static_cast<double>(frame) / static_cast<double>(frames_ - 1) : 0.0;
  }

  double time_of_key(const KeyframeMotion& motion, std::size_t i) const {
    const Keyframe& key = motion.keyframes[i];
    if (key.at) return *key.at;
    if (key.frame) {
      if (*key.frame >= frames_)
        refuse(i, fmt::format("frame {} is past the end of a path of {} frames", *key.frame, frames_), "/frame");
      return fraction(*key.frame);
    }
    const std::size_t count = motion.keyframes.size();
    return count > 1 ? static_cast<double>(i) / static_cast<double>(count - 1) : 0.0;
  }

  Eigen::Vector3d point_in_subject(const Eigen::Vector3d& point) const {
    if (spec_.frame_of_reference == FrameOfReference::source_world) return context_.world.point_in_subject(point);
    return spec_.units == LengthUnit::radius ? Eigen::Vector3d(point * context_.world.radius()) : point;
  }

  Rigid3 pose_in_subject(const Rigid3& pose) const {
    if (spec_.frame_of_reference == FrameOfReference::source_world) return context_.world.subject_from_cam(pose);
    return {pose.rotation, point_in_subject(pose.translation)};
  }

  Rigid3 pose_on_sphere(const SpherePlace& place, double roll) const {
    const Rigid3& start = context_.world.subject_from_cam0();
    const Eigen::Matrix3d turn = rotation_y(radians(place.phi)) * rotation_x(radians(place.theta));
    return {rolled(turn * start.rotation, roll), turn * start.translation * place.r};
  }

  static Eigen::Matrix3d rolled(const Eigen::Matrix3d& rotation, double roll) {
    return roll == 0 ? rotation : Eigen::Matrix3d(rotation * rotation_z(radians(roll)));
  }

  Key make_key(const KeyframeMotion& motion, std::size_t i) const {
    const Keyframe& given = motion.keyframes[i];
    Key key;
    key.time = time_of_key(motion, i);
    key.roll = given.roll;
    key.easing = given.easing;
    key.log_zoom = std::log(given.fov ? zoom_for_fov(*given.fov, context_) : given.focal.value_or(1.0));
    place(given, key);
    aim(given, key, i);
    return key;
  }

  void place(const Keyframe& given, Key& key) const {
    if (const auto* sphere = std::get_if<SpherePlace>(&given.place)) {
      const Rigid3 pose = pose_on_sphere(*sphere, given.roll);
      key.sphere = *sphere;
      key.position = pose.translation;
      key.rotation = pose.rotation;
      key.on_sphere = std::holds_alternative<std::monostate>(given.aim);
      // Past the poles such a camera hangs upside down, which looking at the subject does not reproduce.
      const double tilt = std::remainder(sphere->theta - spec_.elevation, 360);
      key.has_target = key.on_sphere && std::abs(tilt) < 89.9;
    } else if (const auto* position = std::get_if<Eigen::Vector3d>(&given.place)) {
      key.position = point_in_subject(*position);
    } else {
      const Rigid3 pose = pose_in_subject(std::get<Rigid3>(given.place));
      key.position = pose.translation;
      key.rotation = rolled(pose.rotation, given.roll);
    }
  }

  void aim(const Keyframe& given, Key& key, std::size_t i) const {
    if (const auto* rotation = std::get_if<Eigen::Matrix3d>(&given.aim)) {
      key.rotation = rolled(pose_in_subject({*rotation, Eigen::Vector3d::Zero()}).rotation, given.roll);
      return;
    }
    const bool silent = std::holds_alternative<std::monostate>(given.aim);
    if (silent && !std::holds_alternative<Eigen::Vector3d>(given.place)) return;
    if (const auto* point = std::get_if<Eigen::Vector3d>(&given.aim)) key.target = point_in_subject(*point);
    key.has_target = true;
    const LookAt answer = look_at(key.position, key.target, key.roll, key.rotation);
    if (answer != LookAt::good) refuse(i, complaint(answer), silent ? "/position" : "/look_at");
  }

  static std::string_view complaint(LookAt answer) {
    return answer == LookAt::no_direction ? "the camera is at the point it looks at; move it away or give a rotation"
                                          : "the camera looks straight up or down, where upright has no meaning; give "
                                            "a rotation, or phi, theta and r";
  }

  /// The time of frame k after the easing of the piece it lies in.
  double time_of(long k) const {
    const double time = fraction(k);
    const auto right = std::upper_bound(keys_.begin(), keys_.end(), time,
                                        [](double value, const Key& key) { return value < key.time; });
    if (right == keys_.begin() || right == keys_.end()) return time;
    const Key& left = *(right - 1);
    if (left.easing == Easing::linear) return time;
    const double length = right->time - left.time;
    return left.time + length * ease(left.easing, (time - left.time) / length);
  }

  std::vector<double> times() const {
    std::vector<double> list;
    for (const Key& key : keys_) list.push_back(key.time);
    return list;
  }

  template <class Values>
  PointSpline curve(Eigen::Index dimensions, const Values& values_of) const {
    Eigen::MatrixXd points(dimensions, std::ssize(keys_));
    for (std::size_t i = 0; i < keys_.size(); ++i) points.col(static_cast<Eigen::Index>(i)) = values_of(keys_[i]);
    return PointSpline(times(), points);
  }

  /// Angles and the logarithm of the distance are interpolated: arcs stay arcs, and turns may exceed half a circle.
  std::vector<Rigid3> poses_on_sphere() const {
    const PointSpline values = curve(4, [](const Key& key) {
      return Eigen::Vector4d(key.sphere.phi, key.sphere.theta, std::log(key.sphere.r), key.roll);
    });
    std::vector<Rigid3> poses;
    for (long k = 0; k < frames_; ++k) {
      const Eigen::Vector4d v = values(time_of(k));
      poses.push_back(pose_on_sphere({v[0], v[1], std::exp(v[2])}, v[3]));
    }
    return poses;
  }

  /// Position, target and roll are interpolated: what the camera looks at stays in the middle between keys, too.
  std::vector<Rigid3> poses_with_targets() const {
    const PointSpline values =
        curve(7, [](const Key& key) { return (Eigen::VectorXd(7) << key.position, key.target, key.roll).finished(); });
    std::vector<Rigid3> poses;
    for (long k = 0; k < frames_; ++k) {
      const Eigen::VectorXd v = values(time_of(k));
      Rigid3 pose{Eigen::Matrix3d::Identity(), v.head<3>()};
      const LookAt answer = look_at(pose.translation, v.segment<3>(3), v[6], pose.rotation);
      if (answer != LookAt::good)
        refuse(key_before(k), fmt::format("between this keyframe and the next, in frame {}, {}", k, complaint(answer)));
      poses.push_back(pose);
    }
    return poses;
  }

  std::size_t key_before(long k) const {
    std::size_t key = 0;
    while (key + 1 < keys_.size() && keys_[key + 1].time <= fraction(k)) ++key;
    return key;
  }

  std::vector<Rigid3> poses_freely() const {
    std::vector<Eigen::Matrix3d> rotations;
    for (const Key& key : keys_) rotations.push_back(key.rotation);
    if (const std::size_t ambiguous = RotationSpline::first_ambiguous_turn(rotations); ambiguous != 0)
      refuse(ambiguous,
             "the camera is turned by half a turn from the previous keyframe, and either way round would do; add a "
             "keyframe "
             "in between");
    const RotationSpline rotation(times(), rotations);
    const PointSpline position = curve(3, [](const Key& key) -> Eigen::VectorXd { return key.position; });
    std::vector<Rigid3> poses;
    for (long k = 0; k < frames_; ++k) poses.push_back({rotation(time_of(k)), position(time_of(k))});
    return poses;
  }

  const TrajectorySpec& spec_;
  const PathContext& context_;
  long frames_;
  std::vector<Key> keys_;
};

}  // namespace

double zoom_for_fov(double fov_deg, const PathContext& context) {
  return 0.5 * context.size.width / std::tan(0.5 * radians(fov_deg)) / std::abs(context.intrinsics.fx);
}

CameraPath keyframe_path(const KeyframeMotion& motion, const TrajectorySpec& spec, const PathContext& context,
                         long frames) {
  return KeyframePath(motion, spec, context, frames).build();
}

}  // namespace uwv::detail
