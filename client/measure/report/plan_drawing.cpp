#include "measure/report/plan_drawing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "measure/report/plane_summary.h"
#include "plot/value_scale.h"

namespace tessera::client {
namespace {

constexpr double kPlanLeft = 64, kPlanRight = 24, kPlanTop = 16, kPlanBottom = 46, kLargestPlan = 520;
constexpr double kPlanAir = 0.08;  // around all places, share of the longer side

/// Writes a meter's number beside the one that stands there already.
void draw_label(Canvas& canvas, const std::string& label, PagePoint at, std::vector<PagePoint>& labels) {
  constexpr double kWidth = 20, kHeight = 13;
  const auto is_taken = [&] {
    return std::ranges::any_of(labels, [&](const PagePoint& other) {
      return std::abs(other.x - at.x) < kWidth && std::abs(other.y - at.y) < kHeight;
    });
  };
  // A crowd of meters at one place is not worth a search of the whole plan.
  for (int i = 0; i < 30 && is_taken(); ++i) at.x += kWidth;
  labels.push_back(at);
  canvas.text(label, at, {.size = 12, .bold = true});
}

}  // namespace

PlanDrawing::PlanDrawing(const Measured& measured, const MeasuredReportOptions& options, double width)
    : measured_(measured), options_(options), width_(width) {
  low_ = {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  high_ = {-low_.x, -low_.y};
  for (const MeasuredMeter& meter : measured.meters) {
    for (const Reading& reading : meter.readings) add(flat(reading.position));
    for (const MeasuredPlane& plane : meter.planes) {
      for (const double u : {0.0, 1.0}) {
        for (const double v : {0.0, 1.0}) add(flat(plane.corner + plane.edge_u * u + plane.edge_v * v));
      }
    }
  }
  has_places_ = low_.x <= high_.x;
  if (!has_places_) return;
  if (options.has_bounds) {
    add(flat(options.bounds_low));
    add(flat(options.bounds_high));
  }
  double longer = std::max(high_.x - low_.x, high_.y - low_.y);
  if (!(longer > 0)) longer = 1;
  // A line of meters has some room on both of its sides.
  const double least = 0.2 * longer;
  for (double Flat::*axis : {&Flat::x, &Flat::y}) {
    const double lacking = std::max(0.0, least - (high_.*axis - low_.*axis));
    low_.*axis -= kPlanAir * longer + lacking / 2;
    high_.*axis += kPlanAir * longer + lacking / 2;
  }
  scale_ =
      std::min((width_ - kPlanLeft - kPlanRight) / (high_.x - low_.x), kLargestPlan / (high_.y - low_.y));
}

PlanDrawing::Flat PlanDrawing::flat(const Imath::V3d& point) const {
  return {point.x, options_.y_up ? -point.z : point.y};
}

void PlanDrawing::add(const Flat& point) {
  if (!std::isfinite(point.x) || !std::isfinite(point.y)) return;
  low_ = {std::min(low_.x, point.x), std::min(low_.y, point.y)};
  high_ = {std::max(high_.x, point.x), std::max(high_.y, point.y)};
}

PagePoint PlanDrawing::on_page(const Flat& point) const {
  return {kPlanLeft + (point.x - low_.x) * scale_, kPlanTop + (high_.y - point.y) * scale_};
}

double PlanDrawing::height() const { return kPlanTop + (high_.y - low_.y) * scale_ + kPlanBottom; }

void PlanDrawing::draw_frame(Canvas& canvas) const {
  const PagePoint top = on_page({low_.x, high_.y}), bottom = on_page({high_.x, low_.y});
  const auto ticks = [](double low, double high, double points) {
    return ticks_on({ScaleKind::kLinear, low, high}, std::max(2, static_cast<int>(points / 80)));
  };
  for (const ScaleTick& tick : ticks(low_.x, high_.x, bottom.x - top.x)) {
    const double x = on_page({tick.value, 0}).x;
    const PagePoint line[] = {{x, top.y}, {x, bottom.y}};
    canvas.line(line, false, {.paint = kPageGrid});
    canvas.text(tick.label, {x, bottom.y + 16},
                {.size = 11, .align = TextAlign::kMiddle, .paint = kPageFaint});
  }
  for (const ScaleTick& tick : ticks(low_.y, high_.y, bottom.y - top.y)) {
    const double y = on_page({0, tick.value}).y;
    const PagePoint line[] = {{top.x, y}, {bottom.x, y}};
    canvas.line(line, false, {.paint = kPageGrid});
    canvas.text(tick.label, {top.x - 6, y + 4},
                {.size = 11, .align = TextAlign::kRight, .paint = kPageFaint});
  }
  canvas.text("x", {(top.x + bottom.x) / 2, bottom.y + 34},
              {.size = 12, .align = TextAlign::kMiddle, .paint = kPageFaint});
  canvas.text(options_.y_up ? "-z" : "y", {16, (top.y + bottom.y) / 2},
              {.size = 12, .align = TextAlign::kMiddle, .paint = kPageFaint});
}

void PlanDrawing::draw_bounds(Canvas& canvas) const {
  const Flat a = flat(options_.bounds_low), b = flat(options_.bounds_high);
  const std::array<PagePoint, 4> corners = {on_page(a), on_page({b.x, a.y}), on_page(b), on_page({a.x, b.y})};
  canvas.line(corners, true, {.paint = kPageFaint, .dashed = true});
}

void PlanDrawing::draw_meter(Canvas& canvas, const MeasuredMeter& meter, const std::string& label,
                             std::vector<PagePoint>& labels) const {
  bool is_labelled = false;
  for (const MeasuredPlane& plane : meter.planes) {
    std::array<PagePoint, 4> corners;
    constexpr double kWay[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    PagePoint highest{0, std::numeric_limits<double>::infinity()};
    for (std::size_t i = 0; i < 4; ++i) {
      corners[i] = on_page(flat(plane.corner + plane.edge_u * kWay[i][0] + plane.edge_v * kWay[i][1]));
      if (corners[i].y < highest.y || (corners[i].y == highest.y && corners[i].x < highest.x))
        highest = corners[i];
    }
    canvas.line(corners, true, {.paint = kPageData, .width = 1.8});
    draw_label(canvas, label, {highest.x + 5, highest.y + 15}, labels);
    is_labelled = true;
  }
  for (const MeasuredMesh& mesh : meter.meshes) {
    Imath::V3d sum(0);
    for (const Imath::V3d& vertex : mesh.vertices) sum += vertex;
    const PagePoint at =
        on_page(flat(sum / static_cast<double>(std::max<std::size_t>(1, mesh.vertices.size()))));
    canvas.disc(at, 5, kPageData);
    draw_label(canvas, label, {at.x + 8, at.y - 5}, labels);
    is_labelled = true;
  }
  for (std::size_t i = 0; i < meter.readings.size(); ++i) {
    const Flat place = flat(meter.readings[i].position);
    if (!std::isfinite(place.x) || is_of_map(meter, i)) continue;
    const PagePoint at = on_page(place);
    canvas.disc(at, 3.4, kPageData);
    if (!is_labelled) draw_label(canvas, label, {at.x + 6, at.y - 5}, labels);
    is_labelled = true;
  }
}

void PlanDrawing::draw(Canvas& canvas) const {
  draw_frame(canvas);
  if (options_.has_bounds) draw_bounds(canvas);
  std::vector<PagePoint> labels;
  for (std::size_t i = 0; i < measured_.meters.size(); ++i)
    draw_meter(canvas, measured_.meters[i], absl::StrCat(i + 1), labels);
}

}  // namespace tessera::client
