#include "plot/isoline_labels.h"

#include <algorithm>
#include <cmath>

namespace tessera::client {
namespace {

/// A line by the distance along it.
class MeasuredLine {
 public:
  explicit MeasuredLine(std::span<const PagePoint> points) : points_(points), distances_(points.size()) {
    for (std::size_t i = 1; i < points.size(); ++i) {
      distances_[i] =
          distances_[i - 1] + std::hypot(points[i].x - points[i - 1].x, points[i].y - points[i - 1].y);
    }
  }

  double length() const { return distances_.empty() ? 0 : distances_.back(); }

  PagePoint at(double distance) const {
    const auto after = std::ranges::lower_bound(distances_, distance);
    const auto i = std::clamp<std::ptrdiff_t>(after - distances_.begin(), 1,
                                              static_cast<std::ptrdiff_t>(points_.size()) - 1);
    const auto last = static_cast<std::size_t>(i);
    const double step = distances_[last] - distances_[last - 1];
    const double share = step > 0 ? (distance - distances_[last - 1]) / step : 0;
    const PagePoint &from = points_[last - 1], &to = points_[last];
    return {std::lerp(from.x, to.x, share), std::lerp(from.y, to.y, share)};
  }

 private:
  std::span<const PagePoint> points_;
  std::vector<double> distances_;
};

bool is_inside(const PageBox& box, const PagePoint& point, double margin) {
  return point.x > box.x + margin && point.x < box.x + box.width - margin && point.y > box.y + margin &&
         point.y < box.y + box.height - margin;
}

}  // namespace

std::optional<LabelPlace> label_place(std::span<const PagePoint> line, double length, const PageBox& within,
                                      const std::vector<PagePoint>& taken) {
  constexpr int kPlaces = 40;
  constexpr double kMostBend = 0.25;  // by which the way is longer than straight on
  const MeasuredLine measured(line);
  if (line.size() < 2 || measured.length() < 2 * length) return std::nullopt;
  std::optional<LabelPlace> best;
  double least = kMostBend;
  for (int i = 1; i < kPlaces; ++i) {
    const double middle = measured.length() * i / kPlaces;
    if (middle < length / 2 || middle > measured.length() - length / 2) continue;
    const PagePoint from = measured.at(middle - length / 2), to = measured.at(middle + length / 2),
                    at = measured.at(middle);
    const bool crowded = std::ranges::any_of(taken, [&](const PagePoint& other) {
      return std::hypot(other.x - at.x, other.y - at.y) < 1.4 * length;
    });
    if (crowded || !is_inside(within, from, 6) || !is_inside(within, to, 6)) continue;
    const double bend = length / std::max(std::hypot(to.x - from.x, to.y - from.y), 1e-9) - 1;
    if (bend >= least) continue;
    least = bend;
    double turned = std::atan2(to.y - from.y, to.x - from.x);
    if (turned > M_PI / 2) turned -= M_PI;
    if (turned <= -M_PI / 2) turned += M_PI;
    best = LabelPlace{at, turned};
  }
  return best;
}

}  // namespace tessera::client
