#include "import/mitsuba/sensor.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

#include "import/input/concat.h"
#include "import/mitsuba/field_of_view.h"
#include "import/mitsuba/film.h"
#include "import/mitsuba/sensitivities.h"
#include "wire/limits.h"

namespace tessera::client::mitsuba {
namespace {

/// Mitsuba's camera has x to the left of the picture.
Imath::M44d with_x_right(const Imath::M44d& to_world) { return scaling(-1, 1, 1) * to_world; }

double column_length(const Imath::M44d& t, int column) {
  return std::hypot(t[column][0], t[column][1], t[column][2]);
}

/// The lengths of the axes, taken out of the transformation.
Imath::V3d take_scale(Imath::M44d& t) {
  Imath::V3d scale;
  for (int c = 0; c < 3; ++c) {
    scale[c] = column_length(t, c);
    for (int r = 0; r < 3; ++r) t[c][r] /= scale[c];
  }
  return scale;
}

/// The part of the screen that the crop window shows. The film spans [-half_width, half_width] across.
void write_screen_window(PropertyReader& reader, const FilmWindow& film, double half_width,
                         double half_height, v1::Camera& camera) {
  // Fractions of the film, to the right and down.
  const double shift_x = reader.number("principal_point_offset_x", 0);
  const double shift_y = reader.number("principal_point_offset_y", 0);
  const double left = film.crop_x / film.width + shift_x, right = left + film.crop_width / film.width;
  const double top = film.crop_y / film.height + shift_y, bottom = top + film.crop_height / film.height;
  for (const double edge : {(2 * left - 1) * half_width, (2 * right - 1) * half_width,
                            (1 - 2 * bottom) * half_height, (1 - 2 * top) * half_height}) {
    camera.add_screen_window(static_cast<float>(edge));
  }
}

void write_perspective(PropertyReader& reader, const FilmWindow& film, Imath::M44d to_world,
                       v1::Camera& camera) {
  const double aspect = film.width / film.height;
  const double half_width = read_half_width(reader, aspect);
  const double shorter = std::min(half_width, half_width / aspect);
  v1::PerspectiveCamera& perspective = *camera.mutable_perspective();
  perspective.set_fov_degrees(static_cast<float>(2 * std::atan(shorter) * 180 / std::numbers::pi));
  write_screen_window(reader, film, half_width / shorter, half_width / aspect / shorter, camera);

  const Imath::V3d scale = take_scale(to_world);
  for (const double s : {scale.x, scale.y, scale.z}) {
    if (std::abs(s - 1) <= 1e-3) continue;
    reader.warn("the scale in the sensor's transformation is left out");
    break;
  }
  write_matrix(with_x_right(to_world), *camera.mutable_world_from_camera());
  if (reader.object().type == "thinlens") {
    const double aperture = reader.number("aperture_radius", 0);
    if (!(aperture > 0)) reader.error("sensor \"thinlens\": expected an aperture_radius above 0");
    perspective.set_lens_radius(static_cast<float>(aperture));
    perspective.set_focal_distance(static_cast<float>(reader.number("focus_distance", camera.far_clip())));
  } else {
    reader.ignore({"focus_distance"});
  }
}

void write_orthographic(PropertyReader& reader, const FilmWindow& film, Imath::M44d to_world,
                        v1::Camera& camera) {
  // Before it is transformed, the film is two units wide.
  const Imath::V3d scale = take_scale(to_world);
  camera.mutable_orthographic();
  write_screen_window(reader, film, scale[0], scale[1] * film.height / film.width, camera);
  write_matrix(with_x_right(to_world), *camera.mutable_world_from_camera());
  const float near_clip = camera.near_clip();
  camera.set_near_clip(static_cast<float>(near_clip * scale[2]));
  camera.set_far_clip(camera.near_clip() + camera.far_clip() - near_clip);
  reader.ignore({"focus_distance"});
}

void write_sampler(Context& context, Object* sampler) {
  v1::RenderSettings& settings = *context.scene.mutable_settings();
  constexpr std::int64_t kDefaultSamples = 4;
  std::int64_t samples = kDefaultSamples;
  if (sampler != nullptr) {
    PropertyReader reader(context, *sampler);
    // Which sequence Mitsuba would take says nothing about the picture: Tessera takes its own.
    static const std::set<std::string_view> known = {"independent", "stratified", "multijitter", "orthogonal",
                                                     "ldsampler"};
    if (!known.contains(sampler->type)) reader.warn(concat("sampler \"", sampler->type, "\" is not known"));
    samples = reader.integer("sample_count", kDefaultSamples);
    if (samples < 1 || samples > wire::kMaxSamplesPerPixel) {
      reader.error(*reader.find("sample_count"),
                   concat("expected 1 to ", wire::kMaxSamplesPerPixel, " samples a pixel, found ", samples));
      samples = kDefaultSamples;
    }
    settings.set_seed(static_cast<std::uint64_t>(reader.integer("seed", 0)));
    reader.ignore({"jitter"});
  }
  settings.set_spp(static_cast<std::uint32_t>(samples));
}

/// All that a sensor has besides its camera: sampler, film, response and shutter.
FilmWindow write_exposure(Context& context, PropertyReader& reader) {
  write_sampler(context, reader.child("sampler"));
  Object* const film_object = reader.child("film");
  const FilmWindow film = write_film(context, film_object);
  if (film_object != nullptr) context.note(context.scene.film(), *film_object);
  write_sensor_response(reader, film_object != nullptr && film_object->type == "specfilm");
  context.shutter_open = reader.number("shutter_open", 0);
  context.shutter_close = reader.number("shutter_close", context.shutter_open);
  if (context.shutter_close < context.shutter_open)
    reader.error(concat(reader.object().title(), ": its shutter closes before it opens"));
  return film;
}

/// Whether the sensor is a camera of a kind that is known; else an error is noted.
bool check_kind(PropertyReader& reader) {
  const std::string& type = reader.object().type;
  if (type == "perspective" || type == "thinlens" || type == "orthographic") return true;
  reader.error(concat("sensor \"", type,
                      "\" is not supported: expected perspective, thinlens, orthographic or batch"));
  return false;
}

void write_camera(PropertyReader& reader, MediumTable& media, const FilmWindow& film, v1::Camera& camera) {
  reader.context().note(camera, reader.object());
  if (Object* medium = reader.child("medium")) camera.set_medium(media.use(*medium));
  camera.set_near_clip(static_cast<float>(reader.number("near_clip", 0.01)));
  camera.set_far_clip(static_cast<float>(reader.number("far_clip", 10000)));
  if (!(camera.near_clip() > 0) || !(camera.far_clip() > camera.near_clip())) {
    reader.error(concat(reader.object().title(), ": expected 0 < near_clip < far_clip"));
  }
  std::vector<TimedPlacing> motion = reader.motion("to_world");
  const Imath::M44d to_world = motion.front().place;
  if (!inverse(to_world)) {
    reader.error(concat(reader.object().title(), ": its transformation is singular"));
  } else if (reader.object().type == "orthographic") {
    write_orthographic(reader, film, to_world, camera);
  } else {
    write_perspective(reader, film, to_world, camera);
  }
  for (TimedPlacing& placing : motion) {
    take_scale(placing.place);
    placing.place = with_x_right(placing.place);
  }
  write_motion(motion, camera);
}

/// Sensors that Mitsuba puts side by side on one film: views, each of its part of the film's width. Their own
/// films, samplers and shutters do not count there, either.
void write_batch(PropertyReader& batch, MediumTable& media) {
  Context& context = batch.context();
  FilmWindow film = write_exposure(context, batch);
  const std::vector<Property*> sensors = batch.children("sensor");
  if (sensors.empty()) {
    batch.error("sensor \"batch\": expected at least one <sensor> within it");
    return;
  }
  const auto views = static_cast<double>(sensors.size());
  if (film.crop_width != film.width || film.crop_height != film.height)
    batch.error("sensor \"batch\": a crop window of a film that several sensors share is not supported");
  if (std::fmod(film.width, views) != 0) {
    batch.error(concat("sensor \"batch\": the width of its film, ", film.width,
                       ", is not a multiple of its number of sensors, ", views));
    return;
  }
  film.width = film.crop_width = film.width / views;
  context.scene.mutable_film()->set_width(static_cast<std::uint32_t>(film.width));
  for (Property* const property : sensors) {
    Object& sensor = *std::get<Object*>(property->value);
    PropertyReader reader(context, sensor);
    if (!check_kind(reader)) continue;
    v1::Camera& camera =
        property == sensors.front() ? *context.scene.mutable_camera() : *context.scene.add_views();
    camera.set_view_name(sensor.id.empty() ? property->name : sensor.id);
    static_cast<void>(reader.child("film")), static_cast<void>(reader.child("sampler"));
    reader.ignore({"shutter_open", "shutter_close"});
    write_camera(reader, media, film, camera);
  }
}

}  // namespace

void write_sensor(Context& context, MediumTable& media, Object& sensor) {
  PropertyReader reader(context, sensor);
  if (sensor.type == "batch") {
    write_batch(reader, media);
    return;
  }
  if (!check_kind(reader)) return;
  const FilmWindow film = write_exposure(context, reader);
  write_camera(reader, media, film, *context.scene.mutable_camera());
}

}  // namespace tessera::client::mitsuba
