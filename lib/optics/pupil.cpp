#include "optics/pupil.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace tessera::optics {

namespace {

using std::numbers::pi;

constexpr int kTurns = 96;     // corners of an outline
constexpr int kHalvings = 13;  // of the distance to the edge
constexpr int kRings = 64, kColumns = 24;

Ray ray_to(Point film, Point pupil, double plane) {
  const Vector from{film.x, film.y, 0};
  return {from, unit(Vector{pupil.x, pupil.y, plane} - from)};
}

bool is_open(const LensSystem& lens, Point film, Point pupil, double plane, double nm) {
  return lens.to_scene(ray_to(film, pupil, plane), nm).has_value();
}

/// A disk of the plane that holds all that is seen of the last surface from a point of the film.
struct Disk {
  Point middle;
  double radius;
};
Disk last_aperture(const LensSystem& lens, Point film, double plane) {
  const auto& last = lens.elements().back();
  const double radius = last.surface.diameter / 2;
  // Its rim may lie nearer to the film than its vertex.
  const double rim = std::max(last.z - std::max(sag(last.surface, radius).value_or(0), 0.0), 0.1 * last.z);
  const double part = plane / last.z, rim_part = plane / rim, farthest = std::hypot(film.x, film.y);
  constexpr double kSpare = 1.05;
  return {{film.x * (1 - part), film.y * (1 - part)},
          kSpare * (radius * std::max(part, rim_part) + farthest * std::abs(rim_part - part))};
}

/// The point through which a ray goes to the middle of the stop, by Newton's method from another one: where
/// small stops are open.
std::optional<Point> aim_at_stop(const LensSystem& lens, Point film, Point at, double nm, double plane) {
  const double step = 1e-5 * plane;
  for (int i = 0; i < 12; ++i) {
    const auto here = lens.at_stop(ray_to(film, at, plane), nm),
               right = lens.at_stop(ray_to(film, {at.x + step, at.y}, plane), nm),
               above = lens.at_stop(ray_to(film, {at.x, at.y + step}, plane), nm);
    if (!here || !right || !above) return std::nullopt;
    const double xx = (right->x - here->x) / step, yx = (right->y - here->y) / step,
                 xy = (above->x - here->x) / step, yy = (above->y - here->y) / step;
    const double determinant = xx * yy - xy * yx;
    if (determinant == 0) return std::nullopt;
    at.x -= (yy * here->x - xy * here->y) / determinant;
    at.y -= (xx * here->y - yx * here->x) / determinant;
  }
  return at;
}

/// A point in the open part, as near to its middle as a grid tells.
std::optional<Point> find_open(const LensSystem& lens, Point film, Point near, double nm, double plane) {
  const Disk disk = last_aperture(lens, film, plane);
  for (const int steps : {24, 120}) {
    Point sum;
    int open = 0;
    std::vector<Point> found;
    for (int i = 0; i < steps * steps; ++i) {
      const int column = i % steps, row = i / steps;
      const Point at{disk.middle.x + disk.radius * (2 * (column + 0.5) / steps - 1),
                     disk.middle.y + disk.radius * (2 * (row + 0.5) / steps - 1)};
      if (!is_open(lens, film, at, plane, nm)) continue;
      sum.x += at.x, sum.y += at.y, ++open;
      found.push_back(at);
    }
    if (open == 0) {
      const auto aimed = aim_at_stop(lens, film, near, nm, plane);
      if (aimed && is_open(lens, film, *aimed, plane, nm)) return aimed;
      continue;
    }
    const Point middle{sum.x / open, sum.y / open};
    return *std::min_element(found.begin(), found.end(), [&](Point a, Point b) {
      return std::hypot(a.x - middle.x, a.y - middle.y) < std::hypot(b.x - middle.x, b.y - middle.y);
    });
  }
  return std::nullopt;
}

/// Distance from an open point to the edge in a direction: not less than it is.
double edge_from(const LensSystem& lens, Point film, Point open, double turn, double most, double nm,
                 double plane, int halvings = kHalvings) {
  double inside = 0, outside = most;
  // Small pupils, of small stops, are found to a hundredth of their size.
  const auto is_coarse = [&] { return outside - inside > 0.01 * outside && outside > 1e-9 * most; };
  for (int i = 0; i < halvings || is_coarse(); ++i) {
    const double middle = (inside + outside) / 2;
    const Point at{open.x + middle * std::cos(turn), open.y + middle * std::sin(turn)};
    (is_open(lens, film, at, plane, nm) ? inside : outside) = middle;
  }
  return outside;
}

double cross(Point o, Point a, Point b) { return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x); }

/// Edges of the convex hull of the points, along y over x: the lower or the upper one [Andrew 1979].
std::vector<Point> chain(const std::vector<Point>& sorted, bool upper) {
  std::vector<Point> hull;
  for (const Point p : sorted) {
    while (hull.size() >= 2) {
      const double turn = cross(hull[hull.size() - 2], hull.back(), p);
      if (upper ? turn < 0 : turn > 0) break;
      hull.pop_back();
    }
    hull.push_back(p);
  }
  return hull;
}

double height_at(const std::vector<Point>& hull, double x) {
  auto next = std::upper_bound(hull.begin(), hull.end(), x, [](double v, Point p) { return v < p.x; });
  if (next == hull.end()) return hull.back().y;
  if (next == hull.begin()) return hull.front().y;
  const Point a = *std::prev(next), b = *next;
  return a.y + (b.y - a.y) * (x - a.x) / (b.x - a.x);
}

/// Heights at these places between which straight lines lie on the outer side (1: above, -1: below) of a
/// chain.
std::vector<double> around(const std::vector<Point>& hull, const std::vector<double>& xs, double side) {
  std::vector<double> heights, spare(xs.size());
  for (const double x : xs) heights.push_back(height_at(hull, x));
  for (const Point corner : hull) {
    const auto next = std::clamp<std::ptrdiff_t>(
        std::upper_bound(xs.begin(), xs.end(), corner.x) - xs.begin(), 1, std::ssize(xs) - 1);
    const auto b = static_cast<std::size_t>(next), a = b - 1;
    const double part = xs[b] > xs[a] ? (corner.x - xs[a]) / (xs[b] - xs[a]) : 0;
    const double beyond = side * (corner.y - (heights[a] + part * (heights[b] - heights[a])));
    spare[a] = std::max(spare[a], beyond), spare[b] = std::max(spare[b], beyond);
  }
  for (std::size_t i = 0; i < xs.size(); ++i) heights[i] += side * spare[i];
  return heights;
}

/// Appends a cell's nodes: the convex hull of the points, made a little larger, as trapezoids around it.
void add_cell(std::vector<Point> points, std::vector<PupilNode>& nodes) {
  if (points.size() < 3) {
    nodes.resize(nodes.size() + PupilTable::kNodes);
    return;
  }
  Point middle;
  for (const Point p : points) middle.x += p.x / points.size(), middle.y += p.y / points.size();
  constexpr double kLarger = 1.005;  // corners of pupils lie between the turns of an outline
  for (Point& p : points) p = {middle.x + (p.x - middle.x) * kLarger, middle.y + (p.y - middle.y) * kLarger};
  std::sort(points.begin(), points.end(),
            [](Point a, Point b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
  const std::vector<Point> low = chain(points, false), high = chain(points, true);
  // Closer at the ends, where round outlines are steep.
  const double first = points.front().x, last = points.back().x;
  std::vector<double> xs;
  for (int i = 0; i < PupilTable::kNodes; ++i)
    xs.push_back(first + (last - first) * (1 - std::cos(pi * i / (PupilTable::kNodes - 1))) / 2);
  const std::vector<double> lows = around(low, xs, -1), highs = around(high, xs, 1);
  double area = 0;
  for (std::size_t i = 0; i < xs.size(); ++i) {
    if (i > 0) area += (xs[i] - xs[i - 1]) * (highs[i] - lows[i] + highs[i - 1] - lows[i - 1]) / 2;
    nodes.push_back({xs[i], lows[i], highs[i], area});
  }
}

Point middle_of(const std::vector<Point>& points, Point otherwise) {
  if (points.empty()) return otherwise;
  Point sum;
  for (const Point p : points) sum.x += p.x / points.size(), sum.y += p.y / points.size();
  return sum;
}

/// Outlines of all wavelengths.
std::vector<Point> outlines(const LensSystem& lens, const std::vector<double>& wavelengths, Point film,
                            Point& near) {
  std::vector<Point> all;
  for (const double nm : wavelengths) {
    const std::vector<Point> one = pupil_outline(lens, film, nm, near);
    near = middle_of(one, near);
    all.insert(all.end(), one.begin(), one.end());
  }
  return all;
}

}  // namespace

double pupil_plane(const LensSystem& lens) {
  const double last = lens.back_distance(), pupil = last - lens.paraxial().exit_pupil;
  return pupil > 0.5 * last && pupil < 20 * last ? pupil : last;
}

std::vector<Point> pupil_outline(const LensSystem& lens, Point film, double nm, Point near) {
  const double plane = pupil_plane(lens);
  if (!is_open(lens, film, near, plane, nm)) {
    const auto open = find_open(lens, film, near, nm, plane);
    if (!open) return {};
    near = *open;
  }
  const Disk disk = last_aperture(lens, film, plane);
  const double most = disk.radius + std::hypot(near.x - disk.middle.x, near.y - disk.middle.y);
  std::vector<Point> outline;
  for (int i = 0; i < kTurns; ++i) {
    const double turn = 2 * pi * i / kTurns, edge = edge_from(lens, film, near, turn, most, nm, plane);
    outline.push_back({near.x + edge * std::cos(turn), near.y + edge * std::sin(turn)});
  }
  return outline;
}

double axial_irradiance(const LensSystem& lens) {
  // cos^4 / z^2 over the disk, in polar coordinates: the integral along the radius is known.
  constexpr int kParts = 720, kExact = 40;
  const double plane = pupil_plane(lens), most = last_aperture(lens, {}, plane).radius;
  double sum = 0;
  for (int i = 0; i < kParts; ++i) {
    const double edge = edge_from(lens, {}, {}, 2 * pi * (i + 0.5) / kParts, most, kLineD, plane, kExact);
    sum += edge * edge / (plane * plane + edge * edge);
  }
  return sum * pi / kParts;
}

PupilTable pupil_table(const LensSystem& lens, double half_width, double half_height,
                       const std::vector<double>& wavelengths) {
  PupilTable table;
  table.z = pupil_plane(lens);
  table.rings = lens.is_round();
  table.nodes_per_cell = PupilTable::kNodes;
  Point near;
  if (table.rings) {
    table.cells_x = kRings;
    table.cell_x = std::hypot(half_width, half_height) / kRings;
    std::vector<Point> inner = outlines(lens, wavelengths, {}, near);
    for (int i = 0; i < kRings; ++i) {
      std::vector<Point> outer = outlines(lens, wavelengths, {(i + 1) * table.cell_x, 0}, near), both = inner;
      both.insert(both.end(), outer.begin(), outer.end());
      add_cell(std::move(both), table.nodes);
      inner = std::move(outer);
    }
    return table;
  }
  table.cells_x = table.cells_y = kColumns;
  table.first_x = -half_width, table.first_y = -half_height;
  table.cell_x = 2 * half_width / kColumns, table.cell_y = 2 * half_height / kColumns;
  std::vector<std::vector<Point>> corners;
  for (int y = 0; y <= kColumns; ++y) {
    for (int x = 0; x <= kColumns; ++x)
      corners.push_back(outlines(lens, wavelengths,
                                 {table.first_x + x * table.cell_x, table.first_y + y * table.cell_y}, near));
  }
  for (int y = 0; y < kColumns; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      std::vector<Point> all;
      for (const int corner : {0, 1, kColumns + 1, kColumns + 2}) {
        const auto& one = corners[static_cast<std::size_t>(y * (kColumns + 1) + x + corner)];
        all.insert(all.end(), one.begin(), one.end());
      }
      add_cell(std::move(all), table.nodes);
    }
  }
  return table;
}

}  // namespace tessera::optics
