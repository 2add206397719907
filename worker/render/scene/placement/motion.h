// Motion of a shape, an instance or the camera while the shutter is open.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "google/protobuf/repeated_field.h"
#include "render/scene/placement/rotation.h"
#include "render/scene/placement/transform.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

/// Evenly spaced moments that a motion is sampled at: matrices are linear in between.
struct MotionSteps {
  int segments = 0;  // 0: it stands still
  // Bound of the distance of points from their way, as a fraction of their distance from the origin of the
  // space that is placed, or from what they turn about; where nothing turns, of the length of the way.
  double error = 0;
  double arc_error = 0;  // the part of it that chords of arcs have, without bends between steps
};

/// The way through placements at moments from 0, when the shutter opens, to 1, when it closes. From one to
/// the next it goes by translation, rotation and stretch at constant speeds each: M = T R S, R orthogonal and
/// S symmetric [Shoemake & Duff 1992]. Rotations take the shorter way round. On top of that, what is placed
/// may turn within its own space, by any angle.
class Motion {
 public:
  struct Turn {
    Imath::V3d axis{0, 0, 1};  // of any length but 0
    double degrees = 0;
    Imath::V3d about{0, 0, 0};
  };
  struct Key {
    double time = 1;
    Transform place;
    Turn turn = {};  // from the key before to this one, before `place` is applied
  };

  /// Stands still.
  explicit Motion(const Transform& place) : start_(place) {}
  /// InvalidArgument tells all that is wrong: times that do not ascend or are not in (0, 1]; placements that
  /// are singular, or mirror images of the one before, so that some placement in between would be flat; axes
  /// of no length; turns that are too fast for kMostSegments.
  static absl::StatusOr<Motion> through(const Transform& start, std::vector<Key> keys);
  static absl::StatusOr<Motion> between(const Transform& start, const Transform& end) {
    return through(start, {{1, end}});
  }
  /// The same of messages, with the errors of Transform::from_proto(); stands still where neither says
  /// otherwise. An `end` is one key; beside others it is an error.
  using Messages = google::protobuf::RepeatedPtrField<v1::MotionKey>;
  static absl::StatusOr<Motion> from_proto(const v1::Matrix& start, const v1::Matrix& end,
                                           const Messages& keys = {});
  /// Keys of messages, with a fault for each that is not well-formed.
  static std::vector<Key> read_keys(const Messages& keys, const Transform& start,
                                    std::vector<std::string>& faults);
  /// The error of an `end` beside keys.
  static absl::Status said_twice();
  static absl::StatusOr<Motion> of(const v1::Shape& shape) {
    return from_proto(shape.world_from_object(), shape.world_from_object_end(), shape.motion());
  }
  static absl::StatusOr<Motion> of(const v1::Instance& instance) {
    return from_proto(instance.world_from_instance(), instance.world_from_instance_end(), instance.motion());
  }
  static absl::StatusOr<Motion> of(const v1::Camera& camera) {
    return from_proto(camera.world_from_camera(), camera.world_from_camera_end(), camera.motion());
  }

  bool moves() const { return !pieces_.empty(); }
  Transform at(double time) const;
  /// How many pieces, with linear interpolation of the matrix in each, keep to the way within 1e-5; at most
  /// kMostSegments, which is enough for rotations of up to 65 degrees at constant speed (half a turn: 7.5e-5;
  /// one and a half: 6.8e-4). Keys that no such moments hit, as of 1/3 and 3/4 and .8, cost more.
  const MotionSteps& steps() const { return steps_; }
  int segments() const { return steps_.segments; }
  /// Whether it moves along straight lines without turning or stretching.
  bool translates_only() const;
  /// The motion of what is reflected in the origin of its own space before it is placed.
  absl::StatusOr<Motion> of_reflected() const;

  static constexpr int kMostSegments = 128;  // Embree's limit

 private:
  friend MotionSteps steps_of_product(std::span<const Motion> motions);

  /// Between two keys.
  struct Piece {
    double begin, end;
    Transform from, to;
    Quaternion rotations[2];
    Matrix3 stretches[2] = {};
    Turn turn;         // of unit axis
    Transform turned;  // by the turns of earlier pieces
    bool turns = false, was_turned = false;

    double duration() const { return end - begin; }
    double angle() const;   // of both rotations, radians
    double growth() const;  // relative change of the stretch
    double travel() const;  // length of the way of the origin, turns apart
    bool translates_only() const;
    Transform at(double time) const;
  };
  /// A moment at which the velocity jumps by this, relative to the size of what moves or its way.
  struct Bend {
    double time, jump;
  };

  static bool read_piece(const Transform& start, const std::vector<Key>& keys, std::size_t number,
                         Piece& piece, std::vector<std::string>& faults);
  std::vector<Bend> bends() const;
  double way() const;

  Transform start_;
  std::vector<Piece> pieces_;
  MotionSteps steps_;
};

/// The steps that the product of motions needs, those that stand still among them.
MotionSteps steps_of_product(std::span<const Motion> motions);

/// The warning about steps that leave the way by more than a thousandth; else empty.
std::string roughness_of(const MotionSteps& steps);

/// `place` at segments + 1 evenly spaced times in [0, 1], appended. InvalidArgument when one is not finite.
absl::Status append_steps(const std::function<Transform(double)>& place, int segments,
                          std::vector<Affine>& steps);

}  // namespace tessera::render
