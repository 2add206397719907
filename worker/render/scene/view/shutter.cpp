#include "render/scene/view/shutter.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace tessera::render {

namespace {

constexpr int kMostValues = 256;

/// Openness at a time, in any unit.
struct Point {
  double time, open;
};

std::vector<Point> read_trapezoid(const v1::Shutter::Trapezoid& shutter, std::vector<std::string>& faults) {
  const double opening = shutter.opening(), closing = shutter.closing();
  if (!(opening >= 0 && closing >= 0 && opening + closing <= 1)) {
    faults.push_back(
        absl::StrCat("a shutter opens and closes for shares of its time, 1 at most together, not ", opening,
                     " and ", closing));
    return {};
  }
  if (opening == 0 && closing == 0) return {};
  std::vector<Point> points;
  if (opening > 0) points.push_back({0, 0});
  points.push_back({opening, 1});
  if (opening + closing < 1) points.push_back({1 - closing, 1});
  if (closing > 0) points.push_back({1, 0});
  return points;
}

std::vector<Point> read_samples(const v1::Shutter::Sampled& shutter, std::vector<std::string>& faults) {
  const auto& values = shutter.values();
  const std::size_t count = faults.size();
  if (values.size() < 2 || values.size() > kMostValues)
    faults.push_back(
        absl::StrCat("a shutter's curve has 2 to ", kMostValues, " values, not ", values.size()));
  const auto bad = std::ranges::find_if(values, [](double x) { return !(x >= 0 && std::isfinite(x)); });
  if (bad != values.end())
    faults.push_back(absl::StrCat("value ", bad - values.begin(), " of the shutter's curve is ", *bad));
  if (std::ranges::none_of(values, [](double x) { return x > 0; }))
    faults.emplace_back("the shutter never opens: no value of its curve is above 0");
  if (faults.size() > count) return {};
  if (std::ranges::all_of(values, [&](double x) { return x == values[0]; })) return {};
  std::vector<Point> points;
  const double most = std::ranges::max(values), last = values.size() - 1;
  for (int i = 0; i < values.size(); ++i) points.push_back({i / last, values[i] / most});
  return points;
}

/// Scales the openness to a mean of 1.
std::vector<ShutterTable::Knot> knots_of(const std::vector<Point>& points) {
  std::vector<double> cdf(points.size());
  for (std::size_t i = 1; i < points.size(); ++i)
    cdf[i] = cdf[i - 1] + (points[i].time - points[i - 1].time) * (points[i].open + points[i - 1].open) / 2;
  std::vector<ShutterTable::Knot> knots;
  for (std::size_t i = 0; i < points.size(); ++i)
    knots.push_back({static_cast<float>(points[i].time), static_cast<float>(points[i].open / cdf.back()),
                     static_cast<float>(cdf[i] / cdf.back())});
  return knots;
}

void read_rolling(const v1::Shutter::Rolling& rolling, FilmSize film, ShutterTable& table,
                  std::vector<std::string>& faults) {
  using Rolling = v1::Shutter::Rolling;
  if (!(rolling.duration() > 0 && rolling.duration() <= 1))
    faults.push_back(
        absl::StrCat("rows of a rolling shutter are exposed for a share of its time above 0 and 1 "
                     "at most, not ",
                     rolling.duration()));
  if (!Rolling::Direction_IsValid(rolling.direction()))
    faults.emplace_back("the direction of a rolling shutter is unknown");
  table.across = rolling.direction() == Rolling::RIGHT || rolling.direction() == Rolling::LEFT;
  table.from_last = rolling.direction() == Rolling::UP || rolling.direction() == Rolling::LEFT;
  table.rows = static_cast<std::int32_t>(table.across ? film.width : film.height);
  table.duration = static_cast<float>(rolling.duration());
}

}  // namespace

absl::StatusOr<std::shared_ptr<const ShutterTable>> build_shutter(const v1::Shutter& shutter, FilmSize film) {
  std::vector<std::string> faults;
  std::vector<Point> points;
  if (shutter.has_trapezoid()) points = read_trapezoid(shutter.trapezoid(), faults);
  if (shutter.has_sampled()) points = read_samples(shutter.sampled(), faults);
  auto table = std::make_shared<ShutterTable>();
  if (!points.empty()) table->knots = knots_of(points);
  if (shutter.has_rolling()) read_rolling(shutter.rolling(), film, *table, faults);
  if (!faults.empty())
    return absl::InvalidArgumentError(absl::StrCat("camera: ", absl::StrJoin(faults, "; ")));
  if (table->knots.empty() && table->rows == 0) return nullptr;
  return table;
}

}  // namespace tessera::render
