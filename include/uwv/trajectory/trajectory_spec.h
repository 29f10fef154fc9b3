// SPDX-License-Identifier: Apache-2.0
// What a trajectory file says: the wanted camera path, before anything is known about the clip it will be used on.
//
// docs/trajectories.md documents the file format key by key, with units, axes, defaults and examples; the fields here
// have the same names. A spec that was read or parsed is consistent in itself: what can still go wrong when it meets a
// clip (a frame number past the clip's end, a camera on top of the point it looks at) is reported by build_path().
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "uwv/core/camera.h"
#include "uwv/trajectory/orbit.h"

namespace uwv {

/// One of presets(), with an extra zoom towards the end.
struct PresetMotion {
  std::string name = "still";
  double focal = 1;
  friend bool operator==(const PresetMotion&, const PresetMotion&) = default;
};

/// A place on the sphere around the subject, looking at it: angles as in FreeMove, `r` the distance in radii.
struct SpherePlace {
  double phi = 0;
  double theta = 0;
  double r = 1;
  friend bool operator==(const SpherePlace&, const SpherePlace&) = default;
};

/// Where the subject is: the origin of the subject world.
struct SubjectPoint {
  friend bool operator==(const SubjectPoint&, const SubjectPoint&) = default;
};

/// A pose the path passes through exactly.
struct Keyframe {
  std::optional<double> at{};   ///< When: 0 = first frame, 1 = last.
  std::optional<long> frame{};  ///< When: a frame number. Without `at` and `frame`, keys are spread evenly.
  std::variant<SpherePlace, Eigen::Vector3d, Rigid3> place{};  ///< On the sphere, a position, or a whole pose.
  /// Where it looks: nothing = at the subject (a whole pose: as it says), a point, or an explicit orientation.
  std::variant<std::monostate, SubjectPoint, Eigen::Vector3d, Eigen::Matrix3d> aim{};
  double roll = 0;                 ///< Degrees about the viewing direction, clockwise as the camera sees it.
  std::optional<double> focal{};   ///< Zoom: multiplies the focal length. 1 without `fov`.
  std::optional<double> fov{};     ///< Horizontal field of view in degrees, (0, 180), instead of `focal`.
  Easing easing = Easing::linear;  ///< From this key to the next.
  friend bool operator==(const Keyframe&, const Keyframe&) = default;
};

struct KeyframeMotion {
  std::vector<Keyframe> keyframes;
  friend bool operator==(const KeyframeMotion&, const KeyframeMotion&) = default;
};

/// One camera of an explicit path. Without intrinsics it has the source's.
struct ExplicitCamera {
  Rigid3 world_from_cam{};
  std::optional<Intrinsics> intrinsics{};  ///< In pixels of `size`, else of the working size.
  std::optional<double> fov{};             ///< Horizontal, degrees, instead of intrinsics.
  std::optional<Size> size{};
  friend bool operator==(const ExplicitCamera&, const ExplicitCamera&) = default;
};

struct CameraMotion {
  std::vector<ExplicitCamera> cameras;  ///< Exactly one of `cameras` and `cameras_file` is set in a spec just read.
  std::string cameras_file;             ///< For the caller to read and put into `cameras`; not opened by this module.
  friend bool operator==(const CameraMotion&, const CameraMotion&) = default;
};

using Motion = std::variant<PresetMotion, FreeMove, OrbitLists, KeyframeMotion, CameraMotion>;

/// Which moment of the source each target frame shows.
struct FollowTime {  ///< Frame k shows source frame k; after the source's end, its last frame.
  friend bool operator==(const FollowTime&, const FollowTime&) = default;
};
struct FreezeTime {  ///< All frames show one source frame.
  long frame = 0;
  friend bool operator==(const FreezeTime&, const FreezeTime&) = default;
};
struct ListedTime {  ///< An explicit source frame for each target frame.
  std::vector<long> frames;
  friend bool operator==(const ListedTime&, const ListedTime&) = default;
};
struct SpanTime {  ///< From source frame `from` to `to`, both included, evenly; backwards when from > to.
  long from = 0, to = 0;
  friend bool operator==(const SpanTime&, const SpanTime&) = default;
};
using TimeControl = std::variant<FollowTime, FreezeTime, ListedTime, SpanTime>;

enum class FrameOfReference {
  subject,       ///< Origin on the subject, axes of subject_world.h.
  source_world,  ///< The world the source cameras are given in.
};
enum class LengthUnit {
  scene,   ///< The unit of the source's depth and poses.
  radius,  ///< The distance from the first source camera to the subject.
};

struct TrajectorySpec {
  /// The most frames a path may have.
  static constexpr long max_frames = 1'000'000;

  std::string name = "trajectory";  ///< The file's name, for messages.
  long frames = 0;                  ///< 0 = as many as cameras, listed times or source frames there are; 81 for photos.
  double fps = 0;                   ///< 0 = the source's.
  double elevation = 0;             ///< Degrees, see initial_camera(); (-90, 90).
  double radius = 0;                ///< Scene units; 0 = the median depth of the first source frame.
  double radius_scale = 1;  ///< Scales the offsets x, y, z of free moves and presets on videos (official option).
  Motion motion;
  FrameOfReference frame_of_reference = FrameOfReference::subject;
  LengthUnit units = LengthUnit::scene;  ///< Of positions, look_at points and poses in the subject world.
  TimeControl time;
  bool follow_source = false;  ///< Apply the path to the moving source camera instead of the first one.

  friend bool operator==(const TrajectorySpec&, const TrajectorySpec&) = default;
};

/// Parses the text of a trajectory file. `name` is what messages call it; relative paths inside are taken from
/// `folder`. Throws Error(file_damaged) for broken JSON, with line and column, and Error(value_invalid) for everything
/// that does not fit the schema: the sentence holds the JSON pointer, what was found and what was wanted.
TrajectorySpec parse_trajectory(std::string_view json, std::string_view name, const std::filesystem::path& folder = {});

/// Reads a trajectory file: JSON, or for the ending .txt the three lines of a ViewCrafter trajectory.
TrajectorySpec read_trajectory(const std::filesystem::path& path);

/// The three lines phi, theta, r of a ViewCrafter trajectory text: numbers separated by blanks, 1 to 1000 per line.
OrbitLists parse_orbit_lists(std::string_view text, std::string_view name);

/// The path that a preset's name stands for, everything else at its default. Throws Error(value_invalid) with the
/// nearest names when there is no such preset.
TrajectorySpec trajectory_from_preset(std::string_view preset);

/// The JSON text of a spec: parsing it gives the same spec again. Files that were read by name are written as their
/// values.
std::string to_json(const TrajectorySpec& spec);

}  // namespace uwv
