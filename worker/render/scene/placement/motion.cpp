#include "render/scene/placement/motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace tessera::render {

namespace {

/// Faster ones are refused: with kMostSegments, about 2,000 degrees of turning.
constexpr double kWorstError = 1e-2;

double in_radians(double degrees) { return degrees * (std::numbers::pi / 180); }

Transform turned_by(const Motion::Turn& turn, double part) {
  const Matrix3 m = rotation_about(turn.axis, part * in_radians(turn.degrees));
  Transform t;
  for (std::size_t row = 0; row < 3; ++row) std::copy_n(m.begin() + 3 * row, 3, t.m.begin() + 4 * row);
  const Imath::V3d shift = turn.about - t.apply_vector(turn.about);
  t.m[3] = shift.x, t.m[7] = shift.y, t.m[11] = shift.z;
  return t;
}

Imath::V3d origin_of(const Transform& t) { return {t.m[3], t.m[7], t.m[11]}; }

/// "its transform at motion key 2"; -1 is the start.
std::string name_of_key(const std::vector<Motion::Key>& keys, std::ptrdiff_t number) {
  if (number < 0) return "its transform";
  if (keys.size() == 1 && keys[0].time == 1) return "its transform at the end of its motion";
  return absl::StrCat("its transform at motion key ", number);
}

void check_times(const std::vector<Motion::Key>& keys, std::vector<std::string>& faults) {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const double time = keys[i].time;
    if (!(time > 0 && time <= 1)) {
      faults.push_back(
          absl::StrCat("motion key ", i, ": its time of ", time,
                       " is not above 0, when the shutter opens, and at most 1, when it closes"));
    } else if (i > 0 && !(time > keys[i - 1].time)) {
      faults.push_back(absl::StrCat("motion key ", i, ": its time of ", time,
                                    " is not after that of the key before, ", keys[i - 1].time));
    }
  }
}

}  // namespace

double Motion::Piece::angle() const {
  return 2 * angle_between(rotations[0], rotations[1]) + (turns ? std::abs(in_radians(turn.degrees)) : 0);
}

double Motion::Piece::growth() const {
  const double change = norm(difference(stretches[0], stretches[1]));
  return change > 0 ? change / std::min(norm(stretches[0]), norm(stretches[1])) : 0;
}

double Motion::Piece::travel() const { return (origin_of(to) - origin_of(from)).length(); }

bool Motion::Piece::translates_only() const {
  return !turns && !was_turned && linear_part(from) == linear_part(to);
}

Transform Motion::Piece::at(double time) const {
  const double t = (time - begin) / duration();
  Transform placed = from;
  if (t >= 1) placed = to;
  if (t > 0 && t < 1 && from.m != to.m) {
    Matrix3 stretch;
    for (std::size_t i = 0; i < 9; ++i) stretch[i] = (1 - t) * stretches[0][i] + t * stretches[1][i];
    const Matrix3 m = product(to_rotation(slerp(t, rotations[0], rotations[1])), stretch);
    for (std::size_t row = 0; row < 3; ++row) {
      std::copy_n(m.begin() + 3 * row, 3, placed.m.begin() + 4 * row);
      placed.m[4 * row + 3] = (1 - t) * from.m[4 * row + 3] + t * to.m[4 * row + 3];
    }
  }
  if (turns) placed = placed * turned_by(turn, std::clamp(t, 0.0, 1.0));
  return was_turned ? placed * turned : placed;
}

/// Decomposes the placements at both ends of the piece that leads to a key; false where one cannot be.
bool Motion::read_piece(const Transform& start, const std::vector<Key>& keys, std::size_t number,
                        Piece& piece, std::vector<std::string>& faults) {
  const auto before = static_cast<std::ptrdiff_t>(number) - 1;
  piece.begin = number == 0 ? 0 : keys[number - 1].time;
  piece.end = keys[number].time;
  piece.from = number == 0 ? start : keys[number - 1].place;
  piece.to = keys[number].place;
  piece.turn = keys[number].turn;
  piece.turns = piece.turn.degrees != 0;
  if (piece.turns) {
    const double length = piece.turn.axis.length();
    if (!(length > 0) || !std::isfinite(length)) {
      faults.push_back(absl::StrCat("motion key ", number, ": the axis of its turn has no direction"));
      return false;
    }
    piece.turn.axis /= length;
  }
  if (piece.from.m == piece.to.m && !piece.turns) return true;
  const Matrix3 linear[2] = {linear_part(piece.from), linear_part(piece.to)};
  std::optional<Matrix3> rotations[2];
  for (std::size_t i = 0; i < 2; ++i) {
    rotations[i] = orthogonal_factor(linear[i]);
    if (rotations[i]) continue;
    std::string fault = name_of_key(keys, before + static_cast<std::ptrdiff_t>(i)) + " is singular";
    // The piece before may have told of its end.
    if (std::ranges::find(faults, fault) == faults.end()) faults.push_back(std::move(fault));
  }
  if (!rotations[0] || !rotations[1]) return false;
  const bool mirrors = piece.from.determinant() < 0;
  if (mirrors != (piece.to.determinant() < 0)) {
    faults.push_back(absl::StrCat("its motion turns it inside out",
                                  keys.size() > 1 ? absl::StrCat(" at motion key ", number) : "",
                                  ": one of its transforms mirrors, the other does not"));
    return false;
  }
  for (std::size_t i = 0; i < 2; ++i) {
    // A rotation and a stretch that mirrors, if the placing does: both linear interpolation and rotation keep
    // it a mirror.
    Matrix3 rotation = *rotations[i];
    if (mirrors) std::transform(rotation.begin(), rotation.end(), rotation.begin(), std::negate<>());
    piece.rotations[i] = from_rotation(rotation);
    piece.stretches[i] = product(transposed(rotation), linear[i]);
  }
  Quaternion& second = piece.rotations[1];
  const Quaternion& first = piece.rotations[0];
  if (first.w * second.w + first.x * second.x + first.y * second.y + first.z * second.z < 0)
    second = {-second.w, -second.x, -second.y, -second.z};
  return true;
}

absl::StatusOr<Motion> Motion::through(const Transform& start, std::vector<Key> keys) {
  Motion motion(start);
  const bool stays = std::ranges::all_of(
      keys, [&](const Key& key) { return key.place.m == start.m && key.turn.degrees == 0; });
  std::vector<std::string> faults;
  check_times(keys, faults);
  Transform turned;
  bool was_turned = false;
  for (std::size_t i = 0; i < keys.size() && !stays; ++i) {
    Piece piece{};
    if (!read_piece(start, keys, i, piece, faults)) continue;
    piece.turned = turned;
    piece.was_turned = was_turned;
    if (piece.turns) turned = turned_by(piece.turn, 1) * turned;
    was_turned |= piece.turns;
    motion.pieces_.push_back(piece);
  }
  if (faults.empty()) {
    motion.steps_ = steps_of_product({&motion, 1});
    if (!(motion.steps_.arc_error <= kWorstError))
      faults.push_back("it turns too fast: " + roughness_of(motion.steps_));
  }
  if (!faults.empty()) return absl::InvalidArgumentError(absl::StrJoin(faults, "; "));
  return motion;
}

absl::Status Motion::said_twice() {
  return absl::InvalidArgumentError(
      "where it is when the shutter closes is said twice: as the end of its motion and by motion keys");
}

std::vector<Motion::Key> Motion::read_keys(const Messages& keys, const Transform& start,
                                           std::vector<std::string>& faults) {
  std::vector<Key> ways;
  Transform place = start;
  const auto point = [](const v1::Point3& p) { return Imath::V3d(p.x(), p.y(), p.z()); };
  for (int i = 0; i < keys.size(); ++i) {
    const v1::MotionKey& key = keys[i];
    if (key.has_place()) {
      const auto own = Transform::from_proto(key.place());
      if (own.ok()) {
        place = *own;
      } else {
        faults.push_back(absl::StrCat("motion key ", i, ": ", own.status().message()));
      }
    }
    Key& way = ways.emplace_back(Key{key.time(), place});
    if (key.has_turn())
      way.turn = {point(key.turn().axis()), key.turn().degrees(), point(key.turn().about())};
    const Turn& turn = way.turn;
    if (!std::isfinite(turn.degrees) || !std::isfinite(turn.about.length2())) {
      faults.push_back(absl::StrCat("motion key ", i, ": its turn is not finite"));
      way.turn = {};
    }
  }
  return ways;
}

absl::StatusOr<Motion> Motion::from_proto(const v1::Matrix& start, const v1::Matrix& end,
                                          const Messages& keys) {
  const auto first = Transform::from_proto(start);
  if (!first.ok()) return first.status();
  if (end.elements().empty() && keys.empty()) return Motion(*first);
  if (!end.elements().empty()) {
    if (!keys.empty()) return said_twice();
    const auto last = Transform::from_proto(end);
    if (!last.ok()) return last.status();
    return between(*first, *last);
  }
  std::vector<std::string> faults;
  std::vector<Key> ways = read_keys(keys, *first, faults);
  auto motion = through(*first, std::move(ways));
  if (!motion.ok()) faults.emplace_back(motion.status().message());
  if (!faults.empty()) return absl::InvalidArgumentError(absl::StrJoin(faults, "; "));
  return motion;
}

Transform Motion::at(double time) const {
  if (pieces_.empty()) return start_;
  const auto piece = std::ranges::find_if(pieces_, [&](const Piece& p) { return time < p.end; });
  return (piece == pieces_.end() ? pieces_.back() : *piece).at(time);
}

bool Motion::translates_only() const {
  return moves() && std::ranges::all_of(pieces_, &Piece::translates_only);
}

absl::StatusOr<Motion> Motion::of_reflected() const {
  Transform reflection;
  reflection.m[0] = reflection.m[5] = reflection.m[10] = -1;
  std::vector<Key> keys;
  for (const Piece& piece : pieces_)
    keys.push_back({piece.end,
                    piece.to * reflection,
                    {piece.turn.axis, piece.turns ? piece.turn.degrees : 0, -piece.turn.about}});
  return through(start_ * reflection, std::move(keys));
}

absl::Status append_steps(const std::function<Transform(double)>& place, int segments,
                          std::vector<Affine>& steps) {
  for (int k = 0; k <= segments; ++k) {
    const Affine step = place(static_cast<double>(k) / segments).to_affine();
    if (!std::all_of(step.m, step.m + 12, [](float x) { return std::isfinite(x); })) {
      return absl::InvalidArgumentError("its motion is not finite");
    }
    steps.push_back(step);
  }
  return absl::OkStatus();
}

}  // namespace tessera::render
