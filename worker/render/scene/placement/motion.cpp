#include "render/scene/placement/motion.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "tessera/v1/scene.pb.h"

namespace tessera::render {

namespace {

using Matrix3 = std::array<double, 9>;

Matrix3 linear_part(const Transform& t) {
  return {t.m[0], t.m[1], t.m[2], t.m[4], t.m[5], t.m[6], t.m[8], t.m[9], t.m[10]};
}

/// Columns are the cofactors' rows: the inverse transposed, times the determinant.
Matrix3 cofactors(const Matrix3& m) {
  return {m[4] * m[8] - m[5] * m[7], m[5] * m[6] - m[3] * m[8], m[3] * m[7] - m[4] * m[6],
          m[2] * m[7] - m[1] * m[8], m[0] * m[8] - m[2] * m[6], m[1] * m[6] - m[0] * m[7],
          m[1] * m[5] - m[2] * m[4], m[2] * m[3] - m[0] * m[5], m[0] * m[4] - m[1] * m[3]};
}

double determinant(const Matrix3& m) {
  const Matrix3 c = cofactors(m);
  return m[0] * c[0] + m[1] * c[1] + m[2] * c[2];
}

Matrix3 product(const Matrix3& a, const Matrix3& b) {
  Matrix3 r;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j)
      r[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
  }
  return r;
}

Matrix3 transposed(const Matrix3& m) { return {m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]}; }

double norm(const Matrix3& m) {
  double sum = 0;
  for (const double x : m) sum += x * x;
  return std::sqrt(sum);
}

Matrix3 difference(const Matrix3& a, const Matrix3& b) {
  Matrix3 r;
  for (std::size_t i = 0; i < 9; ++i) r[i] = a[i] - b[i];
  return r;
}

/// The orthogonal matrix nearest to `m`, by Newton's iteration with scaling [Higham 1986]; its determinant
/// has the sign of m's. None for matrices that are singular to working precision.
std::optional<Matrix3> orthogonal_factor(const Matrix3& m) {
  // Scaled to unit size, so that no square over- or underflows.
  const double size = norm(m);
  if (!(size > 0) || !std::isfinite(size)) return std::nullopt;
  Matrix3 q;
  for (std::size_t i = 0; i < 9; ++i) q[i] = m[i] / size;
  constexpr int kMostSteps = 100;
  for (int step = 0; step < kMostSteps; ++step) {
    const double d = determinant(q);
    if (!(std::abs(d) > 0)) return std::nullopt;
    const double scale = 1 / std::cbrt(std::abs(d));
    const Matrix3 c = cofactors(q);
    Matrix3 next;
    for (std::size_t i = 0; i < 9; ++i) next[i] = 0.5 * (scale * q[i] + c[i] / (d * scale));
    const double change = norm(difference(next, q));
    if (!std::isfinite(change)) return std::nullopt;
    q = next;
    if (change < 1e-15) break;
  }
  // Where it did not converge, rounding has eaten the smallest of the stretches.
  const Matrix3 unit = product(q, transposed(q));
  if (norm(difference(unit, {1, 0, 0, 0, 1, 0, 0, 0, 1})) > 1e-9) return std::nullopt;
  return q;
}

}  // namespace

Motion::Quaternion Motion::from_rotation(const Matrix3& r) {
  // The largest of the four components first [Shepperd 1978].
  const double trace = r[0] + r[4] + r[8];
  const double squares[4] = {trace, r[0], r[4], r[8]};
  const auto largest = std::max_element(squares, squares + 4) - squares;
  Quaternion q;
  switch (largest) {
    case 0:
      q = {1 + trace, r[7] - r[5], r[2] - r[6], r[3] - r[1]};
      break;
    case 1:
      q = {r[7] - r[5], 1 + r[0] - r[4] - r[8], r[1] + r[3], r[2] + r[6]};
      break;
    case 2:
      q = {r[2] - r[6], r[1] + r[3], 1 - r[0] + r[4] - r[8], r[5] + r[7]};
      break;
    default:
      q = {r[3] - r[1], r[2] + r[6], r[5] + r[7], 1 - r[0] - r[4] + r[8]};
      break;
  }
  const double l = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {q.w / l, q.x / l, q.y / l, q.z / l};
}

Motion::Matrix3 Motion::to_rotation(const Quaternion& q) {
  const double xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z, xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
  const double wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  return {1 - 2 * (yy + zz), 2 * (xy - wz), 2 * (xz + wy), 2 * (xy + wz),    1 - 2 * (xx + zz),
          2 * (yz - wx),     2 * (xz - wy), 2 * (yz + wx), 1 - 2 * (xx + yy)};
}

double Motion::angle_between(const Quaternion& a, const Quaternion& b) {
  const auto size = [](double w, double x, double y, double z) {
    return std::sqrt(w * w + x * x + y * y + z * z);
  };
  return 2 * std::atan2(size(a.w - b.w, a.x - b.x, a.y - b.y, a.z - b.z),
                        size(a.w + b.w, a.x + b.x, a.y + b.y, a.z + b.z));
}

Motion::Quaternion Motion::slerp(double t, const Quaternion& a, const Quaternion& b) {
  const double angle = angle_between(a, b);
  double from = 1 - t, to = t;
  if (angle > 1e-7) {
    from = std::sin((1 - t) * angle) / std::sin(angle);
    to = std::sin(t * angle) / std::sin(angle);
  }
  const Quaternion q{from * a.w + to * b.w, from * a.x + to * b.x, from * a.y + to * b.y,
                     from * a.z + to * b.z};
  const double l = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {q.w / l, q.x / l, q.y / l, q.z / l};
}

absl::StatusOr<Motion> Motion::between(const Transform& start, const Transform& end) {
  Motion motion(start);
  if (start.m == end.m) return motion;
  motion.end_ = end;
  const double side = start.determinant();
  if ((side < 0) != (end.determinant() < 0)) {
    return absl::InvalidArgumentError(
        "its motion turns it inside out: one of its transforms mirrors, the other does not");
  }
  const Transform* places[2] = {&start, &end};
  for (std::size_t i = 0; i < 2; ++i) {
    const Matrix3 m = linear_part(*places[i]);
    const std::optional<Matrix3> q = orthogonal_factor(m);
    if (!q)
      return absl::InvalidArgumentError(i == 0 ? "its transform is singular"
                                               : "its transform at the end of its motion is singular");
    // A rotation and a stretch that mirrors, if `m` does: both linear interpolation and rotation keep it a
    // mirror.
    Matrix3 rotation = *q;
    if (side < 0) std::transform(rotation.begin(), rotation.end(), rotation.begin(), std::negate<>());
    motion.rotations_[i] = from_rotation(rotation);
    motion.stretches_[i] = product(transposed(rotation), m);
  }
  Quaternion& second = motion.rotations_[1];
  const Quaternion& first = motion.rotations_[0];
  if (first.w * second.w + first.x * second.x + first.y * second.y + first.z * second.z < 0) {
    second = {-second.w, -second.x, -second.y, -second.z};
  }
  motion.count_segments();
  return motion;
}

absl::StatusOr<Motion> Motion::from_proto(const v1::Matrix& start, const v1::Matrix& end) {
  const auto first = Transform::from_proto(start);
  if (!first.ok()) return first.status();
  if (end.elements().empty()) return Motion(*first);
  const auto last = Transform::from_proto(end);
  if (!last.ok()) return last.status();
  return between(*first, *last);
}

void Motion::count_segments() {
  // A chord over an angle a leaves the arc by a^2 / 8 of the radius; where the stretch grows by g at the same
  // time, by another a g / 4.
  constexpr double kTolerance = 1e-5;
  const double turn = 2 * angle_between(rotations_[0], rotations_[1]);
  const double growth =
      norm(difference(stretches_[0], stretches_[1])) / std::min(norm(stretches_[0]), norm(stretches_[1]));
  const double pieces = std::ceil(std::sqrt(turn * (turn / 8 + growth / 4) / kTolerance));
  segments_ = static_cast<int>(std::clamp(pieces, 1.0, double{kMostSegments}));
}

bool Motion::translates_only() const {
  return segments_ > 0 && std::equal(start_.m.begin(), start_.m.begin() + 3, end_.m.begin()) &&
         std::equal(start_.m.begin() + 4, start_.m.begin() + 7, end_.m.begin() + 4) &&
         std::equal(start_.m.begin() + 8, start_.m.begin() + 11, end_.m.begin() + 8);
}

Transform Motion::at(double time) const {
  if (segments_ == 0 || time <= 0) return start_;
  if (time >= 1) return end_;
  Matrix3 stretch;
  for (std::size_t i = 0; i < 9; ++i) stretch[i] = (1 - time) * stretches_[0][i] + time * stretches_[1][i];
  const Matrix3 m = product(to_rotation(slerp(time, rotations_[0], rotations_[1])), stretch);
  Transform result;
  for (std::size_t row = 0; row < 3; ++row) {
    std::copy_n(m.begin() + 3 * row, 3, result.m.begin() + 4 * row);
    result.m[4 * row + 3] = (1 - time) * start_.m[4 * row + 3] + time * end_.m[4 * row + 3];
  }
  return result;
}

int segments_of_product(const Motion& left, const Motion& right) {
  if (!left.moves() || !right.moves()) return std::max(left.segments(), right.segments());
  return left.translates_only() && right.translates_only() ? 1 : Motion::kMostSegments;
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
