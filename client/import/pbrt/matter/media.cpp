#include "import/pbrt/matter/media.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "import/input/concat.h"
#include "import/input/parallel.h"
#include "wire/volume_blob.h"

namespace tessera::client::pbrt {
namespace {

// Factor that pbrt-v4's images show of a light spectrum that it does not normalise: the integral of the CIE
// function y, nm.
constexpr double kIntegralOfY = 106.856895;
constexpr std::int64_t kMaxSamples = 65536;  // along an axis, of proto/wire/volume_blob.h

std::nullopt_t nothing(ValueReader& values, std::string_view what) {
  fail(values, what);
  return std::nullopt;
}

/// Absorption and scattering, 1/length.
struct Sigma {
  v1::Spectrum a, s;
};

Sigma read_sigma(ValueReader& values) {
  Sigma sigma;
  const std::string preset = values.get_string("preset", "");
  if (!preset.empty()) {
    if (const std::optional<MeasuredMedium> measured = find_measured_medium(preset)) {
      values.parameters().ignore({"sigma_a", "sigma_s"});
      return {rgb_spectrum(measured->sigma_a), rgb_spectrum(measured->sigma_s)};
    }
    values.warn(concat("there is no medium preset \"", preset, "\": sigma_a and sigma_s are used"));
  }
  sigma.a = values.plain_spectrum("sigma_a", 1, SpectrumUse::kUnbounded);
  sigma.s = values.plain_spectrum("sigma_s", 1, SpectrumUse::kUnbounded);
  return sigma;
}

/// "Le" in the units that the image shows, without "Lescale"; nothing where there is none.
std::optional<v1::Spectrum> read_emission(ValueReader& values) {
  if (!values.parameters().has("Le")) return std::nullopt;
  const LightSpectrum light = read_light_spectrum(values.context(), values.parameters(), "Le");
  if (light.spectrum.has_rgb() && light.spectrum.rgb().r() == 0 && light.spectrum.rgb().g() == 0 &&
      light.spectrum.rgb().b() == 0) {
    return std::nullopt;
  }
  return scaled(light.spectrum, light.scale);
}

/// Samples at the centres of cells, `channels` together, x fastest; and where their box lies.
struct Grid {
  std::array<std::int64_t, 3> size = {1, 1, 1};
  std::size_t channels = 1;
  std::vector<float> samples;
  Imath::V3d p0 = {0, 0, 0}, p1 = {1, 1, 1};

  std::size_t cells() const { return static_cast<std::size_t>(size[0] * size[1] * size[2]); }
  std::size_t at(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return static_cast<std::size_t>((z * size[1] + y) * size[0] + x) * channels;
  }
};

bool touches_the_border(const Grid& grid) {
  for (std::int64_t z = 0; z < grid.size[2]; ++z) {
    for (std::int64_t y = 0; y < grid.size[1]; ++y) {
      const bool inside = z > 0 && z + 1 < grid.size[2] && y > 0 && y + 1 < grid.size[1];
      for (std::int64_t x = 0; x < grid.size[0]; x += inside && grid.size[0] > 1 ? grid.size[0] - 1 : 1) {
        for (std::size_t c = 0; c < grid.channels; ++c) {
          if (grid.samples[grid.at(x, y, z) + c] != 0) return true;
        }
      }
    }
  }
  return false;
}

/// pbrt-v4 fades a grid to nothing over the outer half of its outermost cells, while a VolumeGrid stays
/// constant there: a layer of empty cells about it gives the same inside of its bounds.
Grid padded(const Grid& grid) {
  Grid result = grid;
  for (std::size_t a = 0; a < 3; ++a) {
    const double cell = (grid.p1[a] - grid.p0[a]) / static_cast<double>(grid.size[a]);
    result.size[a] += 2;
    result.p0[a] -= cell;
    result.p1[a] += cell;
  }
  result.samples.assign(result.cells() * grid.channels, 0);
  for (std::int64_t z = 0; z < grid.size[2]; ++z) {
    for (std::int64_t y = 0; y < grid.size[1]; ++y) {
      const auto row = grid.samples.begin() + static_cast<std::ptrdiff_t>(grid.at(0, y, z));
      std::copy(row,
                row + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(grid.size[0]) * grid.channels),
                result.samples.begin() + static_cast<std::ptrdiff_t>(result.at(1, y + 1, z + 1)));
    }
  }
  return result;
}

void write_grid(ValueReader& values, const Grid& grid, bool pad, const Imath::M44d& world_from_medium,
                v1::VolumeGrid& message) {
  const Grid out = pad ? padded(grid) : grid;
  const auto count = [&](int axis) {
    return static_cast<std::uint32_t>(out.size[static_cast<std::size_t>(axis)]);
  };
  *message.mutable_blob() = values.context().blobs.add_bytes(wire::encode_volume(
      {count(0), count(1), count(2), static_cast<std::uint32_t>(out.channels), std::span(out.samples)}));
  const Imath::M44d box = scaling(out.p1[0] - out.p0[0], out.p1[1] - out.p0[1], out.p1[2] - out.p0[2]) *
                          translation(out.p0[0], out.p0[1], out.p0[2]);
  write_matrix(box * world_from_medium, *message.mutable_world_from_grid());
}

/// p0 and p1; false when they enclose nothing.
bool read_bounds(ValueReader& values, Grid& grid) {
  const Imath::V3d a = values.parameters().get_point("p0", {0, 0, 0}, values.diagnostics());
  const Imath::V3d b = values.parameters().get_point("p1", {1, 1, 1}, values.diagnostics());
  for (std::size_t i = 0; i < 3; ++i) {
    grid.p0[i] = std::min(a[i], b[i]);
    grid.p1[i] = std::max(a[i], b[i]);
    if (!(grid.p1[i] > grid.p0[i])) {
      fail(values, "p0 and p1 enclose no space");
      return false;
    }
  }
  return true;
}

/// nx, ny, nz and the bounds.
bool read_layout(ValueReader& values, Grid& grid) {
  constexpr const char* kNames[] = {"nx", "ny", "nz"};
  for (std::size_t i = 0; i < 3; ++i) {
    grid.size[i] = values.get_integer(kNames[i], 1);
    if (grid.size[i] < 1 || grid.size[i] > kMaxSamples - 2) {
      fail(values, concat(kNames[i], " is ", grid.size[i], ": expected 1 to ", kMaxSamples - 2));
      return false;
    }
  }
  return read_bounds(values, grid);
}

/// The numbers of a parameter, one or three a cell; nothing where it is absent or, with an error, where they
/// do not fit.
std::optional<std::vector<float>> read_samples(ValueReader& values, const Grid& grid, std::string_view name,
                                               ParameterType type) {
  const Parameter* parameter = values.parameters().find(name, {type}, values.diagnostics());
  if (parameter == nullptr) return std::nullopt;
  const std::size_t per_cell = type == ParameterType::kRgb ? 3 : 1;
  if (parameter->numbers.size() != per_cell * grid.cells()) {
    return nothing(values, concat("\"", name, "\" has ", parameter->numbers.size() / per_cell,
                                  " values, expected nx ny nz = ", grid.cells()));
  }
  std::vector<float> samples(parameter->numbers.begin(), parameter->numbers.end());
  for (const float x : samples) {
    if (!(x >= 0) || !std::isfinite(x))
      return nothing(values, concat("\"", name, "\": ", x, " is not 0 or above"));
  }
  if (per_cell == 3 && parameter->color_space != ColorSpace::kSrgb) {
    for (std::size_t i = 0; i < samples.size(); i += 3) {
      const std::array<double, 3> rgb =
          rec709_from(parameter->color_space, {samples[i], samples[i + 1], samples[i + 2]});
      for (std::size_t c = 0; c < 3; ++c) samples[i + c] = std::max(0.0f, static_cast<float>(rgb[c]));
    }
  }
  return samples;
}

struct DensityUse {
  double scale = 1;   // factor of sigma_a and sigma_s
  bool fades = true;  // it falls to nothing at the border
};

/// Extinction as one channel where it is grey or was measured, and a constant albedo.
void write_density(ValueReader& values, const Grid& density, const Sigma& sigma, DensityUse use,
                   const Imath::M44d& world_from_medium, v1::Medium& medium) {
  const std::array<double, 3> a = linear_rgb_of(sigma.a), s = linear_rgb_of(sigma.s);
  std::array<double, 3> extinction, albedo;
  for (std::size_t c = 0; c < 3; ++c) {
    extinction[c] = a[c] + s[c];
    albedo[c] = extinction[c] > 0 ? s[c] / extinction[c] : 0;
  }
  v1::VolumeGrid& message = *medium.mutable_extinction()->mutable_grid();
  v1::Spectrum& scattered = *medium.mutable_albedo()->mutable_constant();
  Grid grid = density;
  if (const v1::Spectrum sigma_t = sum(sigma.a, sigma.s); is_table(sigma_t)) {
    *message.mutable_factor() = sigma_t;
    *message.mutable_factor()->mutable_in_rgb() = rgb_spectrum(extinction).rgb();
    scattered = sampled_ratio(sigma.s, sigma_t);
    *scattered.mutable_in_rgb() = rgb_spectrum(albedo).rgb();
  } else {
    grid.channels = extinction[0] == extinction[1] && extinction[1] == extinction[2] ? 1 : 3;
    grid.samples.resize(grid.channels * density.samples.size());
    for (std::size_t i = 0; i < density.samples.size(); ++i) {
      for (std::size_t c = 0; c < grid.channels; ++c) {
        grid.samples[grid.channels * i + c] = static_cast<float>(density.samples[i] * extinction[c]);
      }
    }
    scattered = rgb_spectrum(albedo);
  }
  write_grid(values, grid, use.fades && touches_the_border(grid), world_from_medium, message);
  if (use.scale != 1) medium.set_scale(static_cast<float>(use.scale));
}

std::optional<v1::Medium> read_homogeneous(ValueReader& values, const Imath::M44d&) {
  v1::Medium medium;
  const Sigma sigma = read_sigma(values);
  *medium.mutable_extinction()->mutable_constant() = sum(sigma.a, sigma.s);
  *medium.mutable_sigma_s()->mutable_constant() = sigma.s;
  const double scale = values.get_float("scale", 1), emission_scale = values.get_float("Lescale", 1);
  if (!(scale >= 0)) return nothing(values, "scale is below 0");
  if (scale != 1) medium.set_scale(static_cast<float>(scale));
  if (const std::optional<v1::Spectrum> emission = read_emission(values)) {
    *medium.mutable_emission()->mutable_constant() = scaled(*emission, emission_scale);
  }
  return medium;
}

std::optional<v1::Medium> read_uniform_grid(ValueReader& values, const Imath::M44d& world_from_medium) {
  v1::Medium medium;
  Grid grid;
  if (!read_layout(values, grid)) return std::nullopt;
  const Sigma sigma = read_sigma(values);
  const double scale = values.get_float("scale", 1);
  if (!(scale >= 0)) return nothing(values, "scale is below 0");
  std::optional<std::vector<float>> density = read_samples(values, grid, "density", ParameterType::kFloat);
  if (!density)
    return values.diagnostics().has_errors() ? std::nullopt : nothing(values, "expected \"float density\"");
  grid.samples = *std::move(density);
  write_density(values, grid, sigma, {scale, true}, world_from_medium, medium);
  if (values.parameters().has("temperature")) {
    values.warn("light from the \"temperature\" of a medium is not supported yet: it does not glow");
    values.parameters().ignore({"temperature", "temperatureoffset", "temperaturecutoff", "temperaturescale"});
  }
  const std::optional<v1::Spectrum> emission = read_emission(values);
  const std::optional<std::vector<float>> where =
      read_samples(values, grid, "Lescale", ParameterType::kFloat);
  if (!emission) return medium;
  if (!where) {
    *medium.mutable_emission()->mutable_constant() = *emission;
    return medium;
  }
  Grid glow = grid;
  if (is_table(*emission)) {
    glow.samples = *where;
    *medium.mutable_emission()->mutable_grid()->mutable_factor() = *emission;
    write_grid(values, glow, touches_the_border(glow), world_from_medium,
               *medium.mutable_emission()->mutable_grid());
    return medium;
  }
  const std::array<double, 3> rgb = linear_rgb_of(*emission);
  glow.channels = 3;
  glow.samples.clear();
  for (const float x : *where) {
    for (const double c : rgb) glow.samples.push_back(static_cast<float>(c * x));
  }
  write_grid(values, glow, touches_the_border(glow), world_from_medium,
             *medium.mutable_emission()->mutable_grid());
  return medium;
}

std::optional<v1::Medium> read_rgb_grid(ValueReader& values, const Imath::M44d& world_from_medium) {
  v1::Medium medium;
  Grid grid;
  grid.channels = 3;
  if (!read_layout(values, grid)) return std::nullopt;
  const std::optional<std::vector<float>> a = read_samples(values, grid, "sigma_a", ParameterType::kRgb);
  const std::optional<std::vector<float>> s = read_samples(values, grid, "sigma_s", ParameterType::kRgb);
  const std::optional<std::vector<float>> le = read_samples(values, grid, "Le", ParameterType::kRgb);
  const double scale = values.get_float("scale", 1), emission_scale = values.get_float("Lescale", 1);
  if (!(scale >= 0)) return nothing(values, "scale is below 0");
  if (!a && !s) return nothing(values, "expected \"rgb sigma_a\" or \"rgb sigma_s\"");
  if (le && !a) return nothing(values, "\"Le\" takes \"sigma_a\"");
  // The one that is absent is 1 everywhere.
  Grid extinction = grid, scattering = grid;
  extinction.samples.resize(3 * grid.cells());
  scattering.samples.resize(3 * grid.cells());
  for (std::size_t i = 0; i < 3 * grid.cells(); ++i) {
    scattering.samples[i] = s ? (*s)[i] : 1.0f;
    extinction.samples[i] = scattering.samples[i] + (a ? (*a)[i] : 1.0f);
  }
  // Both grids alike, so that one never outgrows the other at the border.
  const bool pad = touches_the_border(extinction);
  write_grid(values, extinction, pad, world_from_medium, *medium.mutable_extinction()->mutable_grid());
  write_grid(values, scattering, pad, world_from_medium, *medium.mutable_sigma_s()->mutable_grid());
  if (scale != 1) medium.set_scale(static_cast<float>(scale));
  if (le) {
    Grid glow = grid;
    for (const float x : *le) glow.samples.push_back(static_cast<float>(x * emission_scale * kIntegralOfY));
    write_grid(values, glow, pad, world_from_medium, *medium.mutable_emission()->mutable_grid());
  }
  return medium;
}

std::optional<v1::Medium> read_cloud(ValueReader& values, const Imath::M44d& world_from_medium) {
  v1::Medium medium;
  CloudShape cloud;
  cloud.density = values.get_float("density", 1);
  cloud.wispiness = values.get_float("wispiness", 1);
  cloud.frequency = values.get_float("frequency", 5);
  Grid grid;
  if (!read_bounds(values, grid)) return std::nullopt;
  const Sigma sigma = read_sigma(values);
  // A few samples to the shortest wave that has a say, within reason.
  for (std::size_t a = 0; a < 3; ++a) {
    const double wanted = 16 * std::abs(cloud.frequency) * (grid.p1[a] - grid.p0[a]);
    grid.size[a] = static_cast<std::int64_t>(std::clamp(std::ceil(wanted), 16.0, 160.0));
  }
  grid.samples.resize(grid.cells());
  const auto centre = [&](std::size_t axis, std::int64_t i) {
    const double t = (static_cast<double>(i) + 0.5) / static_cast<double>(grid.size[axis]);
    return (1 - t) * grid.p0[axis] + t * grid.p1[axis];
  };
  parallel_for(static_cast<std::size_t>(grid.size[2]), values.context().threads, [&](std::size_t slab) {
    const auto z = static_cast<std::int64_t>(slab);
    for (std::int64_t y = 0; y < grid.size[1]; ++y) {
      for (std::int64_t x = 0; x < grid.size[0]; ++x) {
        grid.samples[grid.at(x, y, z)] =
            static_cast<float>(cloud.at({centre(0, x), centre(1, y), centre(2, z)}));
      }
    }
  });
  values.warn(
      concat("a cloud is sampled on a grid of ", grid.size[0], " x ", grid.size[1], " x ", grid.size[2]));
  // pbrt's clouds end sharply: no fade at the border.
  write_density(values, grid, sigma, {1, false}, world_from_medium, medium);
  return medium;
}

struct MediumType {
  std::string_view name;
  std::optional<v1::Medium> (*read)(ValueReader& values, const Imath::M44d& world_from_medium);
};

constexpr MediumType kMediumTypes[] = {{"homogeneous", read_homogeneous},
                                       {"uniformgrid", read_uniform_grid},
                                       {"rgbgrid", read_rgb_grid},
                                       {"cloud", read_cloud}};

}  // namespace

std::optional<v1::Medium> read_medium(const std::string& type, ValueReader& values,
                                      const Imath::M44d& world_from_medium) {
  for (const MediumType& known : kMediumTypes) {
    if (known.name != type) continue;
    std::optional<v1::Medium> medium = known.read(values, world_from_medium);
    if (!medium) return medium;
    const double g = values.get_float("g", 0);
    if (!(std::abs(g) < 1)) return nothing(values, concat("g = ", g, " is not between -1 and 1"));
    medium->set_g(static_cast<float>(g));
    return medium;
  }
  if (type == "nanovdb")
    return nothing(values, "NanoVDB files are not supported: convert the grid to a \"uniformgrid\"");
  return nothing(values,
                 concat("unknown type \"", type, "\": expected homogeneous, uniformgrid, rgbgrid or cloud"));
}

}  // namespace tessera::client::pbrt
