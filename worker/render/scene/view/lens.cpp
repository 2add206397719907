#include "render/scene/view/lens.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "optics/ghosts.h"
#include "optics/image_quality.h"
#include "optics/pupil.h"
#include "render/scene/view/aperture.h"
#include "wire/film_format.h"
#include "wire/lens_message.h"

namespace tessera::render {

namespace {

constexpr double kSodiumNm = 589.3;
/// Between wavelengths of the table, indices are on straight lines: off by less than 1e-6 for glass.
constexpr double kFirstLensNm = 300, kLastLensNm = 1000, kLensStepNm = 5;

LensSurfaceShape shape_of(const optics::Surface& surface) {
  const bool aspheric =
      std::any_of(surface.aspheric.begin(), surface.aspheric.end(), [](double a) { return a != 0; });
  if (surface.radius == 0 && !aspheric) return LensSurfaceShape::kPlane;
  if (surface.cylindrical) return LensSurfaceShape::kCylinder;
  if (aspheric) return LensSurfaceShape::kAsphere;
  return surface.conic != 0 ? LensSurfaceShape::kConic : LensSurfaceShape::kSphere;
}

class TableBuilder {
 public:
  TableBuilder(const optics::LensSystem& lens, bool disperses) : lens_(lens) {
    if (disperses) {
      table_.first_nm = kFirstLensNm, table_.wavelengths_per_nm = 1 / kLensStepNm;
      table_.wavelengths = static_cast<std::int32_t>((kLastLensNm - kFirstLensNm) / kLensStepNm) + 1;
    }
  }

  void add_surfaces() {
    const auto& elements = lens_.elements();
    for (std::size_t i = elements.size(); i-- > 0;) {
      static const optics::Medium air;
      add(elements[i], elements[i].surface.behind, i > 0 ? elements[i - 1].surface.behind : air);
    }
  }

  void add_pupil(const SensorRecord& sensor) {
    // Filters look beyond the edges of the raster.
    constexpr double kPixelsBeyond = 4;
    const auto farthest = [&](double scale, double offset, double size) {
      const double edge = std::max(std::abs(offset), std::abs(offset + scale * size));
      return (edge + kPixelsBeyond * std::abs(scale)) * table_.film_distance;
    };
    const optics::PupilTable pupil = optics::pupil_table(
        lens_, farthest(sensor.scale_x, sensor.offset_x, sensor.width),
        farthest(sensor.scale_y, sensor.offset_y, sensor.height),
        sensor.disperses ? std::vector<double>{400, optics::kLineD, 700} : std::vector<double>{kSodiumNm});
    table_.pupil_z = static_cast<float>(pupil.z);
    table_.rings = pupil.rings;
    table_.cells_x = pupil.cells_x, table_.cells_y = pupil.cells_y;
    table_.cells_per_mm_x = static_cast<float>(1 / pupil.cell_x);
    table_.cells_per_mm_y = static_cast<float>(1 / pupil.cell_y);
    table_.first_x = static_cast<float>(pupil.first_x), table_.first_y = static_cast<float>(pupil.first_y);
    static_assert(kPupilNodes == optics::PupilTable::kNodes);
    for (const optics::PupilNode& node : pupil.nodes) {
      table_.pupil.push_back({static_cast<float>(node.x), static_cast<float>(node.low),
                              static_cast<float>(node.high), static_cast<float>(node.area_before)});
    }
  }

  /// `half_diagonal`: of the film.
  void add_ghosts(double half_diagonal, bool takes_light, const SensorRecord& sensor) {
    const std::vector<optics::Bounce> bounces = lens_.bounces(kSodiumNm);
    if (bounces.empty()) return;
    GhostTable& ghosts = table_.ghosts;
    const std::vector<double> shares = optics::ghost_shares(lens_, bounces, half_diagonal, kSodiumNm);
    const double all = std::accumulate(shares.begin(), shares.end(), 0.0);
    // Some bounces bring light that a few rays do not find.
    constexpr double kEvenPart = 0.1, kLeastPart = 1.0 / 64, kMostPart = 1.0 / 4;
    std::vector<double> weights;
    for (const double share : shares) {
      const double even = 1 / static_cast<double>(shares.size());
      weights.push_back(all > 0 ? (1 - kEvenPart) * share / all + kEvenPart * even : even);
    }
    ghosts.selection = AliasTable::build(weights);
    // Between equal noise of ghosts and picture, and none of the ghosts'.
    ghosts.part = static_cast<float>(std::clamp(std::sqrt(all), kLeastPart, kMostPart));
    const std::size_t last = lens_.elements().size() - 1;
    for (const optics::Bounce& bounce : bounces) {
      ghosts.bounces.push_back({static_cast<std::int32_t>(last - bounce.near_film),
                                static_cast<std::int32_t>(last - bounce.near_scene)});
    }
    static const optics::Medium air;
    for (std::size_t i = last + 1; i-- > 0;) add_indices(lens_.elements()[i].surface.behind);
    add_indices(air);
    if (takes_light)
      ghosts.rays_of_lights = static_cast<float>(sensor.width) * static_cast<float>(sensor.height);
  }

  LensTable table_;

 private:
  void add_indices(const optics::Medium& medium) {
    for (std::int32_t i = 0; i < table_.wavelengths; ++i)
      table_.ghosts.indices.push_back(static_cast<float>(medium.eta(nm_at(i))));
  }

  double nm_at(std::int32_t wavelength) const {
    return table_.wavelengths > 1 ? kFirstLensNm + wavelength * kLensStepNm : kSodiumNm;
  }

  void add(const optics::LensSystem::Element& element, const optics::Medium& from, const optics::Medium& to) {
    const optics::Surface& surface = element.surface;
    LensSurfaceRecord record;
    record.shape = shape_of(surface);
    record.z = static_cast<float>(element.z);
    record.curvature = static_cast<float>(element.curvature);
    record.conic = static_cast<float>(surface.conic);
    record.aperture_squared = static_cast<float>(surface.diameter * surface.diameter / 4);
    const double turn = surface.axis_degrees * std::numbers::pi / 180;
    record.straight_x = static_cast<float>(std::cos(turn));
    record.straight_y = static_cast<float>(std::sin(turn));
    record.first_coefficient = static_cast<std::int32_t>(table_.coefficients.size());
    record.coefficients = static_cast<std::int32_t>(surface.aspheric.size());
    for (const double a : surface.aspheric) table_.coefficients.push_back(static_cast<float>(-a));
    record.is_stop = surface.stop ? 1 : 0;
    if (surface.coating) {
      record.coating_index = static_cast<float>(surface.coating->index);
      record.coating_nm = static_cast<float>(surface.coating->thickness_nm);
    }
    if (surface.stop) add_edges(surface.diameter / 2, record);
    for (std::int32_t i = 0; i < table_.wavelengths; ++i) {
      const double ratio = from.eta(nm_at(i)) / to.eta(nm_at(i));
      table_.ratios.push_back(static_cast<float>(ratio));
      if (ratio != 1) record.refracts = 1;
    }
    table_.surfaces.push_back(record);
  }

  void add_edges(double radius, LensSurfaceRecord& record) {
    const optics::LensUse& use = lens_.use();
    record.first_edge = static_cast<std::int32_t>(table_.edges.size());
    record.edges = use.blades;
    if (use.blades == 0) return;
    record.apothem = static_cast<float>(radius * std::cos(std::numbers::pi / use.blades));
    for (int i = 0; i < use.blades; ++i) {
      const double turn =
          use.blade_degrees * std::numbers::pi / 180 + (i + 0.5) * 2 * std::numbers::pi / use.blades;
      table_.edges.push_back(static_cast<float>(std::cos(turn)));
      table_.edges.push_back(static_cast<float>(std::sin(turn)));
    }
  }

  const optics::LensSystem& lens_;
};

/// The distance from the middle of the film, between these, beyond which no light reaches it.
double edge_of_light(const optics::LensSystem& lens, double inside, double outside) {
  constexpr int kHalvings = 10;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (inside + outside) / 2;
    const bool is_lit = !optics::pupil_outline(lens, {middle, 0}, optics::kLineD, {0, 0}).empty();
    (is_lit ? inside : outside) = middle;
  }
  return outside;
}

/// The rectangle of the film that a point is in, of lenses that are not round.
std::int32_t cell_of(const LensTable& table, double x, double y) {
  const auto index = [](double at, double per_mm, std::int32_t count) {
    return std::clamp(static_cast<std::int32_t>(at * per_mm), 0, count - 1);
  };
  return index(y - table.first_y, table.cells_per_mm_y, table.cells_y) * table.cells_x +
         index(x - table.first_x, table.cells_per_mm_x, table.cells_x);
}

/// Part of the light towards the middle of the film that passes the picture of the stop; 1 without one.
double open_part(const optics::LensSystem& lens, const AperturePicture& picture) {
  if (!picture.any()) return 1;
  const double radius = lens.use().stop_diameter / 2;
  const auto open_at = [&](const optics::Vector& at) {
    const auto cell = [&](double place, std::int32_t cells) {
      return std::clamp(static_cast<std::int32_t>((place / radius + 1) / 2 * cells), 0, cells - 1);
    };
    const std::int32_t width = picture.density.width;
    const auto number =
        static_cast<std::size_t>(cell(at.y, picture.density.height)) * static_cast<std::size_t>(width) +
        static_cast<std::size_t>(cell(at.x, width));
    return double{picture.density.density[number]} * picture.transmission;
  };
  // A grid over the pupil, as the middle of the film sees it.
  const double plane = optics::pupil_plane(lens);
  double half = 0;
  for (const optics::Point& edge : optics::pupil_outline(lens, {}, kSodiumNm, {}))
    half = std::max({half, std::abs(edge.x), std::abs(edge.y)});
  constexpr int kSide = 256;
  double open = 0, all = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const int row = i / kSide, column = i % kSide;
    const optics::Vector at{half * (2 * (column + 0.5) / kSide - 1), half * (2 * (row + 0.5) / kSide - 1),
                            plane};
    const optics::Ray ray{{}, optics::unit(at)};
    if (lens.end_of(ray, kSodiumNm) != lens.elements().size()) continue;
    const auto stop = lens.at_stop(ray, kSodiumNm);
    if (!stop) continue;
    const double weight = std::pow(ray.direction.z, 4);
    open += weight * open_at(*stop), all += weight;
  }
  return all > 0 ? open / all : 0;
}

}  // namespace

absl::StatusOr<FocusedLens> focus_lens(const v1::LensCamera& camera) {
  std::vector<optics::Fault> faults;
  auto system = wire::lens_system_of(camera, faults);
  if (!system) {
    std::string all = "the lens: ";
    for (std::size_t i = 0; i < faults.size(); ++i)
      absl::StrAppend(&all, i > 0 ? "; " : "", faults[i].message);
    return absl::InvalidArgumentError(all);
  }
  const optics::Paraxial& paraxial = system->paraxial();
  double film_distance = paraxial.focal_length();
  if (std::isfinite(system->focus_distance())) {
    const double object = system->focus_distance() - system->front();
    film_distance = std::abs(paraxial.magnification(object)) * (object + paraxial.entrance_pupil);
  }
  return FocusedLens{*std::move(system), film_distance};
}

absl::StatusOr<std::shared_ptr<const LensTable>> lens_table(const v1::LensCamera& camera,
                                                            const FocusedLens& lens,
                                                            const SensorRecord& sensor,
                                                            const LensSurroundings& surroundings) {
  TableBuilder builder(lens.system, sensor.disperses);
  LensTable& table = builder.table_;
  table.film_distance = static_cast<float>(lens.film_distance);
  table.units_per_mm = static_cast<float>(1 / wire::mm_per_unit(camera));
  builder.add_surfaces();
  builder.add_pupil(sensor);
  if (camera.has_stop_image() && surroundings.blobs != nullptr) {
    auto picture = aperture_picture(camera.stop_image(), *surroundings.blobs);
    if (!picture.ok()) return picture.status();
    table.picture = *std::move(picture);
  }
  const bool ghosts = camera.ghosts();
  if (ghosts) {
    const optics::FilmSize film =
        wire::film_size(camera, {static_cast<double>(sensor.width), static_cast<double>(sensor.height)});
    builder.add_ghosts(std::hypot(film.width, film.height) / 2, surroundings.takes_light, sensor);
  }
  double middle = 1;
  if (camera.brightness() != v1::LensCamera::IRRADIANCE) {
    middle = optics::axial_irradiance(lens.system) * open_part(lens.system, table.picture);
    if (!(middle > 0))
      return absl::InvalidArgumentError(
          "the picture of the stop lets no light through to the middle of the film");
    if (ghosts) middle *= optics::transmittance(lens.system, kSodiumNm);
  }
  table.weight = static_cast<float>(1 / (double{table.pupil_z} * table.pupil_z * middle));
  table.ghosts.per_etendue = static_cast<float>(1 / middle);
  return std::make_shared<const LensTable>(std::move(table));
}

std::string dark_film_warning(const v1::Camera& camera, const SensorRecord& sensor) {
  if (sensor.kind != SensorKind::kLensSystem) return "";
  const LensTable& table = *sensor.lens;
  const auto is_dark = [&](std::int32_t cell) {
    return table.pupil[static_cast<std::size_t>((cell + 1) * kPupilNodes - 1)].area_before == 0;
  };
  double edge = std::numeric_limits<double>::infinity();  // round lenses are dark from there on
  if (table.rings) {
    std::int32_t first = 0;
    while (first < table.cells_x && !is_dark(first)) ++first;
    if (first == table.cells_x) return "";
    const auto lens = focus_lens(camera.lens());
    if (!lens.ok()) return "";
    edge = edge_of_light(lens->system, (first - 1) / double{table.cells_per_mm_x},
                         first / double{table.cells_per_mm_x});
  }
  constexpr int kSteps = 256;
  int dark = 0;
  double nearest = edge, corner = 0;
  for (int i = 0; i <= kSteps * kSteps + 2 * kSteps; ++i) {
    const int column = i % (kSteps + 1), row = i / (kSteps + 1);
    const auto mm = [&](double step, double scale, double offset, std::int32_t pixels) {
      return (step / kSteps * pixels * scale + offset) * table.film_distance;
    };
    const double x = mm(column, sensor.scale_x, sensor.offset_x, sensor.width),
                 y = mm(row, sensor.scale_y, sensor.offset_y, sensor.height);
    const double radius = std::hypot(x, y);
    corner = std::max(corner, radius);
    const bool is_dark_there = table.rings ? radius > edge : is_dark(cell_of(table, -x, -y));
    if (!is_dark_there) continue;
    ++dark;
    nearest = std::min(nearest, radius);
  }
  if (dark == 0) return "";
  return absl::StrFormat(
      "camera: the film is wider than the circle of light that the lens casts: nothing reaches it beyond "
      "%.3g mm from its middle, its corners are %.3g mm from there, and %.2g %% of the picture are black",
      nearest, corner, 100.0 * dark / ((kSteps + 1) * (kSteps + 1)));
}

}  // namespace tessera::render
