#include "command/lens/lens_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "command/report/table.h"
#include "optics/pupil.h"

namespace tessera::client {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kPartOfDiagonal = 1500;  // circle of confusion that is usual for prints

std::string distance_text(double mm) {
  if (!std::isfinite(mm)) return "infinity";
  return mm >= 1000 ? absl::StrFormat("%.4g m", mm / 1000) : absl::StrFormat("%.4g mm", mm);
}

/// Height and angle of the outermost rays decide where a surface is drawn.
std::vector<DrawnPoint> edge_of(const optics::LensSystem::Element& element, double front) {
  constexpr int kSteps = 32;
  std::vector<DrawnPoint> points;
  for (int i = -kSteps; i <= kSteps; ++i) {
    const double h = element.surface.diameter / 2 * i / kSteps;
    points.push_back({front - element.z + optics::sag(element.surface, std::abs(h)).value_or(0), h});
  }
  return points;
}

/// The brightest ghosts of a point of light; empty without any.
std::string ghost_text(const LensReport& report, std::size_t width) {
  constexpr std::size_t kMostLines = 10;
  if (report.ghosts.empty()) return "";
  Table table({{"ghost of surfaces"},
               {"focus mm", true},
               {"light %", true},
               {"diameter mm", true},
               {"light/mm2", true}});
  double all = 0;
  for (std::size_t i = 0; i < report.ghosts.size(); ++i) {
    const optics::Ghost& ghost = report.ghosts[i];
    all += ghost.part;
    if (i >= kMostLines) continue;
    const double radius = ghost.diameter / 2, area = std::numbers::pi * radius * radius;
    table.add({absl::StrCat(ghost.bounce.near_film + 1, ", ", ghost.bounce.near_scene + 1),
               std::isfinite(ghost.focus) ? absl::StrFormat("%.4g", ghost.focus) : "parallel",
               absl::StrFormat("%.3g", 100 * ghost.part), absl::StrFormat("%.3g", ghost.diameter),
               absl::StrFormat("%.2g", ghost.part / area)});
  }
  return absl::StrCat("\n", table.text(width),
                      absl::StrFormat("%d ghosts of a point on the axis have %.3g %% of its image's light",
                                      report.ghosts.size(), 100 * all),
                      report.ghosts.size() > kMostLines ? "; these are the brightest\n" : "\n");
}

nlohmann::json number_or_null(double x) {
  return std::isfinite(x) ? nlohmann::json(x) : nlohmann::json(nullptr);
}

}  // namespace

LensReport report_of(const optics::LensSystem& lens, double film_diagonal) {
  const optics::Paraxial& paraxial = lens.paraxial();
  LensReport report;
  report.name = lens.prescription().name, report.source = lens.prescription().source;
  report.focal_length = paraxial.focal_length();
  report.f_number = lens.use().f_number;
  report.t_number = report.f_number / std::sqrt(optics::transmittance(lens, optics::kLineD));
  report.focus = lens.focus_distance();
  report.film_distance = lens.back_distance();
  report.magnification =
      std::isfinite(report.focus) ? paraxial.magnification(report.focus - lens.front()) : 0;
  const double stop = lens.use().stop_diameter;
  report.entrance_pupil = paraxial.entrance_pupil;
  report.entrance_diameter = stop * std::abs(paraxial.entrance_magnification);
  report.exit_pupil = paraxial.exit_pupil;
  report.exit_diameter = stop * std::abs(paraxial.exit_magnification);
  report.front_principal = paraxial.front_principal(), report.back_principal = paraxial.back_principal();
  report.length = paraxial.length;
  report.film_diagonal = film_diagonal;
  report.circle_of_confusion = film_diagonal / kPartOfDiagonal;
  const optics::DepthOfField depth = optics::depth_of_field(lens, report.circle_of_confusion);
  report.near = depth.near, report.far = depth.far;
  report.frequencies = {10, 30, 50};
  constexpr int kHeights = 7;
  for (int i = 0; i < kHeights; ++i) {
    const double height = film_diagonal / 2 * i / (kHeights - 1);
    if (auto field = optics::field_point(lens, height, report.frequencies)) {
      report.field.push_back(*std::move(field));
    } else {
      report.dark_heights.push_back(height);
    }
  }
  report.ghosts = optics::ghosts_of(lens);
  if (report.dark_heights.empty()) report.field_degrees = 2 * report.field.back().angle / kDegree;
  return report;
}

std::string text_of(const LensReport& report, std::size_t width) {
  Table facts({{""}, {""}});
  const auto add = [&](const char* what, const std::string& text) { facts.add({what, text}); };
  const auto mm = [](double x) { return absl::StrFormat("%.4g mm", x); };
  if (!report.name.empty()) add("lens", report.name);
  if (!report.source.empty()) add("source", report.source);
  add("focal length", mm(report.focal_length));
  add("aperture", absl::StrFormat("f/%.3g, T%.3g", report.f_number, report.t_number));
  add("focus", absl::StrFormat("%s; the film %.4g mm behind the last surface", distance_text(report.focus),
                               report.film_distance));
  if (report.magnification != 0) add("magnification", absl::StrFormat("%.4g", report.magnification));
  add("entrance pupil", absl::StrFormat("%.4g mm wide, %.4g mm behind the first surface",
                                        report.entrance_diameter, report.entrance_pupil));
  add("exit pupil", absl::StrFormat("%.4g mm wide, %.4g mm behind the last surface", report.exit_diameter,
                                    report.exit_pupil));
  add("principal planes", absl::StrFormat("%.4g mm behind the first surface, %.4g mm behind the last one",
                                          report.front_principal, report.back_principal));
  add("length", mm(report.length));
  add("field", report.field_degrees > 0 ? absl::StrFormat("%.4g degrees across a film of %.4g mm",
                                                          report.field_degrees, report.film_diagonal)
                                        : absl::StrFormat("does not light a film of %.4g mm to its corners",
                                                          report.film_diagonal));
  add("depth of field", absl::StrFormat("%s to %s (circle of confusion %.3g mm)", distance_text(report.near),
                                        distance_text(report.far), report.circle_of_confusion));
  std::vector<Table::Column> columns = {
      {"height mm", true},    {"angle deg", true}, {"distortion %", true}, {"light %", true},
      {"open pupil %", true}, {"spot um", true},   {"focus tan mm", true}, {"focus sag mm", true}};
  std::vector<std::string> headings;
  for (const double frequency : report.frequencies)
    headings.push_back(absl::StrFormat("MTF %g tan/sag", frequency));
  for (const std::string& heading : headings) columns.push_back({heading.c_str(), true});
  Table field(columns);
  for (const optics::FieldPoint& point : report.field) {
    std::vector<std::string> cells = {
        absl::StrFormat("%.2f", point.height),           absl::StrFormat("%.2f", point.angle / kDegree),
        absl::StrFormat("%.2f", 100 * point.distortion), absl::StrFormat("%.1f", 100 * point.illumination),
        absl::StrFormat("%.1f", 100 * point.open_pupil), absl::StrFormat("%.1f", 1000 * point.spot_rms),
        absl::StrFormat("%.3f", point.tangential_focus), absl::StrFormat("%.3f", point.sagittal_focus)};
    for (std::size_t i = 0; i < report.frequencies.size(); ++i) {
      cells.push_back(i < point.tangential_mtf.size()
                          ? absl::StrFormat("%.2f/%.2f", point.tangential_mtf[i], point.sagittal_mtf[i])
                          : "");
    }
    field.add(std::move(cells));
  }
  const std::string table = facts.text(width);  // whose headings are empty
  std::string text = absl::StrCat(table.substr(table.find('\n') + 1), "\n", field.text(width));
  for (const double height : report.dark_heights)
    absl::StrAppend(&text,
                    absl::StrFormat("%.2f mm from the middle of the film there is no light\n", height));
  return text + ghost_text(report, width);
}

std::string json_of(const LensReport& report) {
  nlohmann::ordered_json json{
      {"name", report.name},
      {"source", report.source},
      {"focal_length_mm", report.focal_length},
      {"f_number", report.f_number},
      {"t_number", report.t_number},
      {"focus_mm", number_or_null(report.focus)},
      {"film_distance_mm", report.film_distance},
      {"magnification", report.magnification},
      {"entrance_pupil",
       {{"behind_first_surface_mm", report.entrance_pupil}, {"diameter_mm", report.entrance_diameter}}},
      {"exit_pupil",
       {{"behind_last_surface_mm", number_or_null(report.exit_pupil)},
        {"diameter_mm", number_or_null(report.exit_diameter)}}},
      {"front_principal_plane_mm", report.front_principal},
      {"back_principal_plane_mm", report.back_principal},
      {"length_mm", report.length},
      {"film_diagonal_mm", report.film_diagonal},
      {"field_degrees", report.field_degrees},
      {"circle_of_confusion_mm", report.circle_of_confusion},
      {"depth_of_field_mm", {number_or_null(report.near), number_or_null(report.far)}},
      {"mtf_line_pairs_per_mm", report.frequencies}};
  auto& field = json["field"] = nlohmann::ordered_json::array();
  for (const optics::FieldPoint& point : report.field) {
    auto spot = nlohmann::ordered_json::array();
    for (const optics::Vector at : point.spot) spot.push_back({at.x, at.y});
    field.push_back({{"height_mm", point.height},
                     {"angle_degrees", point.angle / kDegree},
                     {"distortion", point.distortion},
                     {"illumination", point.illumination},
                     {"open_pupil", point.open_pupil},
                     {"spot_rms_mm", point.spot_rms},
                     {"tangential_focus_mm", number_or_null(point.tangential_focus)},
                     {"sagittal_focus_mm", number_or_null(point.sagittal_focus)},
                     {"tangential_mtf", point.tangential_mtf},
                     {"sagittal_mtf", point.sagittal_mtf},
                     {"spot_mm", std::move(spot)}});
  }
  json["dark_heights_mm"] = report.dark_heights;
  auto& ghosts = json["ghosts"] = nlohmann::ordered_json::array();
  for (const optics::Ghost& ghost : report.ghosts) {
    ghosts.push_back({{"surfaces", {ghost.bounce.near_film + 1, ghost.bounce.near_scene + 1}},
                      {"focus_mm", number_or_null(ghost.focus)},
                      {"light", ghost.part},
                      {"diameter_mm", ghost.diameter}});
  }
  return json.dump(2);
}

LensDrawing drawing_of(const optics::LensSystem& lens, double film_diagonal) {
  LensDrawing drawing;
  drawing.title = lens.prescription().name.empty() ? "Lens" : lens.prescription().name;
  const double front = lens.front();
  const auto& elements = lens.elements();
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const optics::Surface& surface = elements[i].surface;
    if (surface.stop) {
      const double half = surface.diameter / 2, along = front - elements[i].z;
      for (const double side : {-1.0, 1.0})
        drawing.blades.push_back({{along, side * half}, {along, side * (half * 1.25 + 1)}});
    }
    const double index = surface.behind.eta(optics::kLineD);
    if (index < 1.01 || i + 1 == elements.size()) continue;
    LensDrawing::Glass glass{edge_of(elements[i], front), index};
    const auto back = edge_of(elements[i + 1], front);
    glass.outline.insert(glass.outline.end(), back.rbegin(), back.rend());
    drawing.elements.push_back(std::move(glass));
  }
  drawing.film = front, drawing.film_height = film_diagonal / 2;
  for (const double part : {0.0, 0.6, 0.95}) {
    const double height = part * film_diagonal / 2;
    const auto outline = optics::pupil_outline(lens, {height, 0}, optics::kLineD, {});
    if (outline.empty()) continue;
    const auto [low, high] = std::minmax_element(outline.begin(), outline.end(),
                                                 [](optics::Point a, optics::Point b) { return a.x < b.x; });
    LensDrawing::Rays rays;
    constexpr int kRays = 5;
    for (int i = 0; i < kRays; ++i) {
      const double x = low->x + (high->x - low->x) * (0.01 + 0.98 * i / (kRays - 1));
      const optics::Vector from{height, 0, 0};
      const auto path = lens.path(
          {from, optics::unit(optics::Vector{x, 0, optics::pupil_plane(lens)} - from)}, optics::kLineD);
      if (path.size() < elements.size() + 2) continue;
      auto& points = rays.paths.emplace_back();
      for (auto at = path.rbegin(); at != path.rend(); ++at) points.push_back({front - at->z, at->x});
    }
    drawing.bundles.push_back(std::move(rays));
  }
  return drawing;
}

}  // namespace tessera::client
