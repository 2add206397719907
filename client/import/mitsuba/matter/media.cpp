#include "import/mitsuba/matter/media.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "import/input/concat.h"
#include "import/input/input_file.h"
#include "import/mitsuba/matter/volume_file.h"

namespace tessera::client::mitsuba {
namespace {

v1::VolumeValue constant_volume(const ConstantColor& color) {
  v1::VolumeValue value;
  *value.mutable_constant() = color.to_spectrum();
  return value;
}

/// The box along the axes of the world about the unit cube, placed. Nothing for the cube of a grid that is
/// such a box.
std::optional<Imath::M44d> bounds_beyond(const Imath::M44d& world_from_volume, bool is_grid) {
  Imath::V3d low = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
  for (int corner = 0; corner < 8; ++corner) {
    const Imath::V3d p = Imath::V3d(corner & 1, corner >> 1 & 1, corner >> 2) * world_from_volume;
    for (int a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], p[a]);
      high[a] = std::max(high[a], p[a]);
    }
  }
  // Each row of a map that keeps axes has one element.
  bool keeps_axes = true;
  for (int r = 0; r < 3; ++r) {
    int elements = 0;
    for (int c = 0; c < 3; ++c)
      elements += std::abs(world_from_volume[c][r]) > 1e-9 * (high[r] - low[r]) ? 1 : 0;
    keeps_axes = keeps_axes && elements == 1;
  }
  if (is_grid && keeps_axes) return std::nullopt;
  return scaling(high[0] - low[0], high[1] - low[1], high[2] - low[2]) * translation(low[0], low[1], low[2]);
}

}  // namespace

std::string MediumTable::use(Object& medium) {
  const auto known = names_.find(&medium);
  if (known != names_.end()) return known->second;
  const std::string name = Context::unique_name(medium, "medium", taken_);
  names_[&medium] = name;
  PropertyReader reader(context_, medium);
  if (medium.type != "homogeneous" && medium.type != "heterogeneous") {
    reader.error(
        concat("medium \"", medium.type, "\" is not supported: expected homogeneous or heterogeneous"));
    return name;
  }
  v1::Medium message;
  message.set_name(name);
  Imath::M44d world_from_extinction, world_from_albedo;
  *message.mutable_extinction() = volume(reader, "sigma_t", 1, ColorUse::kUnbounded, world_from_extinction);
  *message.mutable_albedo() = volume(reader, "albedo", 0.75, ColorUse::kReflectance, world_from_albedo);
  const double scale = reader.number("scale", 1);
  if (scale != 1) message.set_scale(static_cast<float>(scale));
  if (medium.type == "homogeneous" && (message.extinction().has_grid() || message.albedo().has_grid())) {
    reader.error("medium \"homogeneous\": sigma_t and albedo must be constant");
  } else if (medium.type == "heterogeneous") {
    // In Mitsuba it ends at the box about the volume of its extinction, whatever is constant: a colour is a
    // volume too.
    if (const auto bounds = bounds_beyond(world_from_extinction, message.extinction().has_grid())) {
      if (!inverse(*bounds)) reader.error("medium \"heterogeneous\": the volume of its sigma_t is flat");
      write_all_elements(*bounds, *message.mutable_world_from_bounds());
    }
  }
  write_phase(reader, message);
  // These choose between ways to sample.
  reader.ignore(
      {"sample_emitters", "has_spectral_extinction", "majorant_resolution_factor", "majorant_factor"});
  v1::Medium& added = *context_.scene.add_media();
  added = std::move(message);
  context_.note(added, medium);
  return name;
}

v1::VolumeValue MediumTable::volume(PropertyReader& reader, std::string_view name, double fallback,
                                    ColorUse use, Imath::M44d& world_from_volume) {
  const Property* property = reader.find(name);
  if (property == nullptr) return constant_volume({{fallback, fallback, fallback}});
  if (const auto color = read_constant_color(reader, *property, use)) return constant_volume(*color);
  Object* const* object = std::get_if<Object*>(&property->value);
  if (object == nullptr || (*object)->tag != "volume") {
    reader.error(*property, "expected a colour or a volume");
  } else if ((*object)->type == "constvolume") {
    PropertyReader nested(context_, **object);
    const ConstantColor color = read_color(nested, "value", 1, use);
    // It is the same everywhere; its box only counts as that of a heterogeneous medium's extinction.
    world_from_volume = nested.transform("to_world");
    return constant_volume(color);
  } else if ((*object)->type == "gridvolume") {
    return grid(**object, world_from_volume);
  } else {
    reader.error(*property, concat("volume \"", (*object)->type,
                                   "\" is not supported: expected constvolume or gridvolume"));
  }
  return constant_volume({{fallback, fallback, fallback}});
}

v1::VolumeValue MediumTable::grid(Object& volume, Imath::M44d& world_from_grid) {
  PropertyReader reader(context_, volume);
  v1::VolumeValue value;
  v1::VolumeGrid& message = *value.mutable_grid();
  const std::optional<std::filesystem::path> path = reader.file("filename");
  if (!path) return value;
  absl::StatusOr<InputFile> input = InputFile::open(*path);
  absl::StatusOr<VolumeFile> file = input.ok() ? read_volume_file(input->bytes()) : input.status();
  if (!file.ok()) {
    reader.error(*reader.find("filename"),
                 concat(path->string(), ": ", std::string(file.status().message())));
    return value;
  }
  if (file->channels != 1 && file->channels != 3) {
    reader.error(*reader.find("filename"),
                 concat("the volume has ", file->channels, " channels: expected 1 or 3"));
  }
  *message.mutable_blob() = context_.blobs.add_bytes(std::move(file->blob));
  message.mutable_blob()->set_path(reader.text("filename", ""));

  world_from_grid = reader.transform("to_world");
  if (reader.boolean("use_grid_bbox", false)) {
    const auto& [low, high] = std::tie(file->box_min, file->box_max);
    world_from_grid = scaling(high[0] - low[0], high[1] - low[1], high[2] - low[2]) *
                      (translation(low[0], low[1], low[2]) * world_from_grid);
  }
  write_matrix(world_from_grid, *message.mutable_world_from_grid());
  if (!inverse(world_from_grid)) reader.error("volume \"gridvolume\": its transformation is singular");
  if (reader.keyword("filter_type", "trilinear") != "trilinear") {
    reader.warn("the volume is interpolated all the same: filter_type is not supported");
  }
  if (reader.keyword("wrap_mode", "clamp") != "clamp") {
    reader.warn("the volume ends at its bounds: wrap_mode is not supported");
  }
  reader.ignore({"raw", "accel", "max_value"});
  return value;
}

void MediumTable::write_phase(PropertyReader& reader, v1::Medium& message) {
  Object* phase = reader.child("phase");
  if (phase == nullptr) return;
  PropertyReader nested(context_, *phase);
  if (phase->type == "hg") {
    const double g = nested.number("g", 0.8);
    if (!(g > -1 && g < 1)) nested.error(concat("phase \"hg\": g is ", g, ", which is not within -1 and 1"));
    message.set_g(static_cast<float>(g));
  } else if (phase->type != "isotropic") {
    nested.error(concat("phase \"", phase->type, "\" is not supported: expected isotropic or hg"));
    return;
  }
}

}  // namespace tessera::client::mitsuba
