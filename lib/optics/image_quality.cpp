#include "optics/image_quality.h"

#include <cmath>
#include <complex>
#include <numbers>

#include "optics/pupil.h"
#include "optics/reflectance.h"

namespace tessera::optics {

namespace {

using std::numbers::pi;

constexpr double kLineF = 486.13, kLineC = 656.27;

/// Irradiance through an outline of the plane, at a point of the film; and the outline's area.
struct Light {
  double irradiance = 0, area = 0;
};
Light light_through(const std::vector<Point>& outline, Point film, double plane) {
  Light light;
  if (outline.empty()) return light;
  Point middle;
  for (const Point p : outline) middle.x += p.x / outline.size(), middle.y += p.y / outline.size();
  constexpr int kSteps = 32;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Point a = outline[i], b = outline[(i + 1) % outline.size()];
    const double area = ((a.x - middle.x) * (b.y - middle.y) - (a.y - middle.y) * (b.x - middle.x)) / 2;
    light.area += area;
    const Point edge{(a.x + b.x) / 2, (a.y + b.y) / 2};
    for (int k = 0; k < kSteps; ++k) {
      const double part = (k + 0.5) / kSteps;
      const double x = middle.x + (edge.x - middle.x) * part - film.x,
                   y = middle.y + (edge.y - middle.y) * part - film.y;
      const double squared = x * x + y * y + plane * plane;
      light.irradiance += area * (2 * k + 1) / (kSteps * kSteps) * plane * plane / (squared * squared);
    }
  }
  return light;
}

/// Points of an outline's inside, evenly spread.
std::vector<Point> points_within(const std::vector<Point>& outline) {
  Point middle;
  for (const Point p : outline) middle.x += p.x / outline.size(), middle.y += p.y / outline.size();
  constexpr int kRings = 8;
  std::vector<Point> points;
  for (int ring = 0; ring < kRings; ++ring) {
    // Each ring has points in proportion to its area.
    const int count = 6 * ring + 3;
    const double part = std::sqrt((ring + 0.5) * (ring + 0.5) + 1.0 / 12) / kRings;
    for (int i = 0; i < count; ++i) {
      const auto corner = static_cast<std::size_t>((i + 0.5 * (ring % 2)) / count * outline.size());
      const Point edge = outline[corner % outline.size()];
      points.push_back({middle.x + (edge.x - middle.x) * part, middle.y + (edge.y - middle.y) * part});
    }
  }
  return points;
}

/// Rays from what is seen along a principal ray, which has left the lens.
class Source {
 public:
  Source(const LensSystem& lens, const Ray& principal) : direction_(principal.direction) {
    if (std::isfinite(lens.focus_distance())) point_ = at_plane(principal, lens.focus_distance());
  }
  const std::optional<Vector>& point() const { return point_; }
  /// Towards a point of the front surface.
  Ray ray_to(Vector front) const {
    if (point_) return {*point_, unit(front - *point_)};
    return {front + direction_ * 10, direction_ * -1};
  }

 private:
  Vector direction_;
  std::optional<Vector> point_;
};

void set_foci(const LensSystem& lens, const Source& source, Vector front, FieldPoint& field) {
  const double step = 1e-3 * lens.elements().front().surface.diameter;
  const auto chief = lens.to_film(source.ray_to(front), kLineD);
  const auto aside = lens.to_film(source.ray_to(front + Vector{step, 0, 0}), kLineD),
             across = lens.to_film(source.ray_to(front + Vector{0, step, 0}), kLineD);
  if (!chief || !aside || !across) return;
  const auto slope = [](const Ray& ray) {
    return Vector{ray.direction.x / ray.direction.z, ray.direction.y / ray.direction.z, 1};
  };
  const Vector at = at_plane(*chief, 0), at_aside = at_plane(*aside, 0), at_across = at_plane(*across, 0);
  field.tangential_focus = -(at_aside.x - at.x) / (slope(*aside).x - slope(*chief).x);
  field.sagittal_focus = -(at_across.y - at.y) / (slope(*across).y - slope(*chief).y);
}

void set_spot(const LensSystem& lens, const Source& source, const std::vector<Point>& outline, Point film,
              std::span<const double> frequencies, FieldPoint& field) {
  const double plane = pupil_plane(lens);
  const std::vector<double> lines =
      lens.disperses() ? std::vector<double>{kLineF, kLineD, kLineC} : std::vector<double>{kLineD};
  const Vector from{film.x, film.y, 0};
  Vector middle;
  for (const Point p : points_within(outline)) {
    const auto out = lens.to_scene({from, unit(Vector{p.x, p.y, plane} - from)}, kLineD);
    if (!out) continue;
    for (const double nm : lines) {
      if (const auto back = lens.to_film(source.ray_to(out->origin), nm))
        field.spot.push_back(at_plane(*back, 0));
    }
  }
  if (field.spot.empty()) return;
  const double count = static_cast<double>(field.spot.size());
  for (const Vector at : field.spot) middle = middle + at * (1 / count);
  double squares = 0;
  for (Vector& at : field.spot) at = at - middle, squares += dot(at, at);
  field.spot_rms = std::sqrt(squares / count);
  for (const double frequency : frequencies) {
    std::complex<double> x, y;
    for (const Vector at : field.spot)
      x += std::polar(1 / count, 2 * pi * frequency * at.x),
          y += std::polar(1 / count, 2 * pi * frequency * at.y);
    field.tangential_mtf.push_back(std::abs(x)), field.sagittal_mtf.push_back(std::abs(y));
  }
}

}  // namespace

double transmittance(const LensSystem& lens, double nm) {
  double part = 1, before = 1;
  for (const auto& element : lens.elements()) {
    const double behind = element.surface.behind.eta(nm);
    part *= 1 - reflectance(before, behind, element.surface.coating, 1, nm);
    before = behind;
  }
  return part;
}

DepthOfField depth_of_field(const LensSystem& lens, double circle_of_confusion) {
  const Paraxial& paraxial = lens.paraxial();
  const double pupil_z = lens.front() - paraxial.entrance_pupil;
  const double pupil = lens.use().stop_diameter * std::abs(paraxial.entrance_magnification);
  if (!std::isfinite(lens.focus_distance())) {
    // The blur of a thing at distance u is that angle of the pupil.
    return {pupil_z + pupil * paraxial.focal_length() / circle_of_confusion,
            std::numeric_limits<double>::infinity()};
  }
  const double u = lens.focus_distance() - pupil_z;
  const double blur =
      circle_of_confusion / std::abs(paraxial.magnification(lens.focus_distance() - lens.front()));
  return {pupil_z + u * pupil / (pupil + blur),
          pupil > blur ? pupil_z + u * pupil / (pupil - blur) : std::numeric_limits<double>::infinity()};
}

std::optional<Ray> principal_ray(const LensSystem& lens, double height, double nm) {
  const double plane = pupil_plane(lens);
  const Vector from{height, 0, 0};
  const auto ray_at = [&](double x) { return Ray{from, unit(Vector{x, 0, plane} - from)}; };
  const double size = lens.elements().back().surface.diameter;
  // Secants from the middle of the paraxial pupil.
  double x = 0, other = 1e-3 * size;
  auto at = lens.at_stop(ray_at(x), nm), at_other = lens.at_stop(ray_at(other), nm);
  for (int i = 0; i < 50 && at && at_other; ++i) {
    if (std::abs(at->x) < 1e-10 * size) return ray_at(x);
    const double slope = (at_other->x - at->x) / (other - x);
    if (slope == 0 || !std::isfinite(slope)) break;
    other = x, at_other = at;
    x -= at->x / slope;
    at = lens.at_stop(ray_at(x), nm);
  }
  return at && std::abs(at->x) < 1e-6 * size ? std::optional(ray_at(x)) : std::nullopt;
}

std::optional<FieldPoint> field_point(const LensSystem& lens, double height,
                                      std::span<const double> frequencies) {
  FieldPoint field;
  field.height = height;
  const auto principal = principal_ray(lens, height, kLineD);
  if (!principal) return std::nullopt;
  const auto out = lens.unstopped(*principal, kLineD);
  const double plane = pupil_plane(lens);
  const Vector through = at_plane(*principal, plane);
  const std::vector<Point> outline = pupil_outline(lens, {height, 0}, kLineD, {through.x, 0});
  if (!out || outline.empty() || out->direction.z <= 0) return std::nullopt;
  const Light here = light_through(outline, {height, 0}, plane),
              middle = light_through(pupil_outline(lens, {}, kLineD, {}), {}, plane);
  field.illumination = here.irradiance / middle.irradiance;
  field.open_pupil = here.area / middle.area;
  field.angle = std::atan2(std::hypot(out->direction.x, out->direction.y), out->direction.z);
  const Source source(lens, *out);
  const double ideal =
      source.point()
          ? std::abs(lens.paraxial().magnification(lens.focus_distance() - lens.front()) * source.point()->x)
          : lens.paraxial().focal_length() * std::tan(field.angle);
  field.distortion = height > 0 ? height / ideal - 1 : 0;
  set_foci(lens, source, out->origin, field);
  set_spot(lens, source, outline, {height, 0}, frequencies, field);
  return field;
}

}  // namespace tessera::optics
