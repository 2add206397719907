// How many evenly spaced steps follow a motion, and how closely.
#include <algorithm>
#include <cmath>

#include "absl/strings/str_format.h"
#include "render/scene/placement/motion.h"

namespace tessera::render {

namespace {

constexpr double kStepTolerance = 1e-5;
constexpr double kToldError = 1e-3;

/// The distance of a way with a bend from the chord between its neighbouring steps is the jump of the
/// velocity, times the time from the bend to either step, over the time between the steps.
double bend_error(double time, double jump, int segments) {
  const double place = time * segments, part = place - std::floor(place);
  return jump * part * (1 - part) / segments;
}

}  // namespace

double Motion::way() const {
  double sum = 0;
  for (const Piece& piece : pieces_) sum += piece.travel();
  return sum;
}

std::vector<Motion::Bend> Motion::bends() const {
  std::vector<Bend> bends;
  const double all = way();
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const Piece& before = pieces_[i];
    const Piece* const after = i + 1 < pieces_.size() ? &pieces_[i + 1] : nullptr;
    if (before.end >= 1) break;
    const auto velocity = [](const Piece& piece) {
      return Imath::V3d(piece.to.m[3] - piece.from.m[3], piece.to.m[7] - piece.from.m[7],
                        piece.to.m[11] - piece.from.m[11]) /
             piece.duration();
    };
    const Imath::V3d jump = (after != nullptr ? velocity(*after) : Imath::V3d(0, 0, 0)) - velocity(before);
    // Turns and stretches by differences: of second order, so that curvature does not count.
    const double next = after != nullptr ? after->duration() : 1 - before.end;
    const double h = 1e-5 * std::min(before.duration(), next);
    const Matrix3 m = linear_part(at(before.end));
    const Matrix3 there = difference(linear_part(at(before.end + h)), m),
                  back = difference(m, linear_part(at(before.end - h)));
    const double turn = norm(difference(there, back)) / (h * norm(m));
    bends.push_back({before.end, turn + (all > 0 ? jump.length() / all : 0)});
  }
  return bends;
}

MotionSteps steps_of_product(std::span<const Motion> motions) {
  // A chord over an angle a leaves the arc by a^2 / 8 of the radius; where the stretch grows by g at the same
  // time, by another a g / 4. The angles and growths of several motions add up; where one turns what another
  // carries along, so does the way of the other.
  std::vector<Motion::Bend> bends;
  double needed = 0, turning = 0, growing = 0, going = 0, curvature = 0;
  int moving = 0;
  bool straight = true;
  for (const Motion& motion : motions) {
    if (!motion.moves()) continue;
    ++moving;
    straight &= motion.translates_only();
    const double way = motion.way();
    double turn = 0, growth = 0, travel = 0;
    for (const Motion::Piece& piece : motion.pieces_) {
      const double angle = piece.angle(), d = piece.duration();
      const double bent = angle * (angle / 8 + piece.growth() / 4);
      needed = std::max(needed, std::sqrt(bent / kStepTolerance) / d);
      curvature = std::max(curvature, bent / (d * d));
      turn = std::max(turn, angle / d), growth = std::max(growth, piece.growth() / d);
      if (way > 0) travel = std::max(travel, piece.travel() / (way * d));
    }
    turning += turn, growing += growth, going += travel;
    const auto own = motion.bends();
    bends.insert(bends.end(), own.begin(), own.end());
  }
  if (moving == 0) return {};
  if (moving > 1) {
    curvature = turning * (turning / 8 + growing / 4 + going / 4) + growing * (growing / 4 + going / 4);
    if (straight) curvature = 0;
  }
  const auto error_of_bends = [&](int segments) {
    double error = 0;
    for (const Motion::Bend& bend : bends) error += bend_error(bend.time, bend.jump, segments);
    return error;
  };
  const auto arc_error = [&](double segments) { return curvature / (segments * segments); };
  // The fewest that follow it closely, if any do, else the closest; of products that turn, that, too.
  const bool closest = (moving > 1 && !straight) || needed > Motion::kMostSegments;
  MotionSteps best{0, HUGE_VAL, 0};
  for (int n = 1; n <= Motion::kMostSegments; ++n) {
    const double bent = error_of_bends(n), error = bent + arc_error(n);
    if (!(error > best.error)) best = {n, error, arc_error(n)};
    if (!closest && n >= needed && bent <= kStepTolerance) {
      best = {n, error, arc_error(n)};
      break;
    }
  }
  return best;
}

std::string roughness_of(const MotionSteps& steps) {
  if (steps.error <= kToldError) return "";
  return absl::StrFormat(
      "its motion is followed by %d steps at most, which leave the way by up to %.2g %% of the distance from "
      "the middle of a turn, or of the way: fewer degrees while the shutter is open are followed closely, as "
      "are keys at multiples of 1/%d or of larger parts",
      Motion::kMostSegments, 100 * steps.error, Motion::kMostSegments);
}

}  // namespace tessera::render
