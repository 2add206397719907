#include "import/pbrt/camera_film.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "import/input/concat.h"
#include "import/pbrt/film_sensor.h"
#include "import/pbrt/realistic_camera.h"
#include "wire/film_size.h"

namespace tessera::client::pbrt {
namespace {

struct FilterType {
  std::string_view name;
  v1::PixelFilter::Kind kind;
  double radius;  // pbrt-v4's default, pixels
};

constexpr FilterType kFilters[] = {{"box", v1::PixelFilter::BOX, 0.5},
                                   {"triangle", v1::PixelFilter::TRIANGLE, 2},
                                   {"gaussian", v1::PixelFilter::GAUSSIAN, 1.5},
                                   {"mitchell", v1::PixelFilter::MITCHELL, 2},
                                   {"sinc", v1::PixelFilter::LANCZOS, 4}};

void warn_of_crop(Context& context, ParameterList& parameters) {
  for (const char* name : {"cropwindow", "pixelbounds"}) {
    if (!parameters.has(name)) continue;
    parameters.ignore({name});
    context.diagnostics.warning(parameters.where(), concat("\"", name,
                                                           "\" of the film is not taken over: the whole "
                                                           "image is rendered; use --crop for a part"));
  }
}

}  // namespace

void write_filter(Context& context, Directive& filter) {
  Diagnostics& diagnostics = context.diagnostics;
  ParameterList& parameters = filter.parameters;
  const auto known = std::find_if(std::begin(kFilters), std::end(kFilters),
                                  [&](const FilterType& type) { return type.name == filter.type; });
  if (known == std::end(kFilters)) {
    diagnostics.error(parameters.where(), concat("unknown pixel filter \"", filter.type,
                                                 "\": expected box, triangle, gaussian, mitchell or sinc"));
    return;
  }
  v1::PixelFilter& message = *context.scene.mutable_film()->mutable_filter();
  message.set_kind(known->kind);
  message.set_radius_x(static_cast<float>(parameters.get_float("xradius", known->radius, diagnostics)));
  message.set_radius_y(static_cast<float>(parameters.get_float("yradius", known->radius, diagnostics)));
  if (!(message.radius_x() > 0) || !(message.radius_y() > 0)) {
    diagnostics.error(parameters.where(), "the radius of the pixel filter is not above 0");
  }
  if (known->kind == v1::PixelFilter::GAUSSIAN) {
    message.set_sigma(static_cast<float>(parameters.get_float("sigma", 0.5, diagnostics)));
  } else if (known->kind == v1::PixelFilter::MITCHELL) {
    message.set_b(static_cast<float>(parameters.get_float("B", 1.0 / 3, diagnostics)));
    message.set_c(static_cast<float>(parameters.get_float("C", 1.0 / 3, diagnostics)));
  } else if (known->kind == v1::PixelFilter::LANCZOS) {
    message.set_tau(static_cast<float>(parameters.get_float("tau", 3, diagnostics)));
  }
}

void write_film(Context& context, Directive& film, double shutter_seconds) {
  Diagnostics& diagnostics = context.diagnostics;
  ParameterList& parameters = film.parameters;
  if (film.type == "gbuffer") {
    diagnostics.warning(parameters.where(),
                        "film \"gbuffer\" is not supported yet: an RGB image is made; use --aov for more");
    parameters.ignore({"coordinatesystem"});
  } else if (film.type != "rgb" && film.type != "spectral") {
    diagnostics.error(parameters.where(),
                      concat("unknown film \"", film.type, "\": expected rgb, gbuffer or spectral"));
    return;
  }
  const std::int64_t width = parameters.get_integer("xresolution", 1280, diagnostics);
  const std::int64_t height = parameters.get_integer("yresolution", 720, diagnostics);
  if (std::min(width, height) < 1 ||
      !wire::is_film_size(static_cast<std::uint64_t>(width), static_cast<std::uint64_t>(height))) {
    diagnostics.error(parameters.where(), concat("film: a resolution of ", width, "x", height,
                                                 " is not possible: ", wire::kFilmSizes));
    return;
  }
  context.scene.mutable_film()->set_width(static_cast<std::uint32_t>(width));
  context.scene.mutable_film()->set_height(static_cast<std::uint32_t>(height));
  write_film_sensor(context, film, shutter_seconds);
  warn_of_crop(context, parameters);
  // Names and formats of files are the command line's; "diagonal" serves cameras with lens systems.
  parameters.ignore({"filename", "savefp16", "diagonal"});
}

ShutterTimes read_shutter(Context& context, Directive& camera) {
  const ShutterTimes times{camera.parameters.get_float("shutteropen", 0, context.diagnostics),
                           camera.parameters.get_float("shutterclose", 1, context.diagnostics)};
  if (times.close > times.open) return times;
  context.diagnostics.error(camera.parameters.where(), "camera: the shutter closes before it opens");
  return {};
}

namespace {

void write_screen_window(Context& context, ParameterList& parameters, v1::Camera& message) {
  Diagnostics& diagnostics = context.diagnostics;
  if (const Parameter* window = parameters.find("screenwindow", {ParameterType::kFloat}, diagnostics)) {
    const std::vector<double>& w = window->numbers;
    if (w.size() != 4 || !(w[0] < w[1]) || !(w[2] < w[3])) {
      diagnostics.error(window->where, "screenwindow: expected xmin < xmax and ymin < ymax");
    }
    for (const double edge : w) message.add_screen_window(static_cast<float>(edge));
  } else if (parameters.has("frameaspectratio")) {
    const double frame = parameters.get_float("frameaspectratio", 1, diagnostics);
    if (!(frame > 0)) diagnostics.error(parameters.where(), "frameaspectratio is not above 0");
    const float x = static_cast<float>(std::max(frame, 1.0)),
                y = static_cast<float>(std::max(1 / frame, 1.0));
    for (const float edge : {-x, x, -y, y}) message.add_screen_window(edge);
  }
  parameters.ignore({"frameaspectratio"});
}

/// A thin lens, of either camera that has one.
template <typename Lens>
void write_lens(Context& context, ParameterList& parameters, Lens& lens) {
  lens.set_lens_radius(static_cast<float>(parameters.get_float("lensradius", 0, context.diagnostics)));
  lens.set_focal_distance(
      static_cast<float>(parameters.get_float("focaldistance", 1e6, context.diagnostics)));
}

void write_perspective(Context& context, ParameterList& parameters, v1::Camera& message) {
  const double fov = parameters.get_float("fov", 90, context.diagnostics);
  if (!(fov > 0) || fov >= 180) {
    context.diagnostics.error(parameters.where(),
                              concat("camera: a field of view of ", fov, " degrees is not in (0, 180)"));
  }
  message.mutable_perspective()->set_fov_degrees(static_cast<float>(fov));
  write_lens(context, parameters, *message.mutable_perspective());
  write_screen_window(context, parameters, message);
}

void write_orthographic(Context& context, ParameterList& parameters, v1::Camera& message) {
  write_lens(context, parameters, *message.mutable_orthographic());
  write_screen_window(context, parameters, message);
}

void write_spherical(Context& context, ParameterList& parameters, v1::Camera& message) {
  const std::string mapping = parameters.get_string("mapping", "equalarea", context.diagnostics);
  if (mapping == "equirectangular") {
    message.mutable_spherical()->set_mapping(v1::SphericalCamera::EQUIRECTANGULAR);
  } else {
    message.mutable_spherical()->set_mapping(v1::SphericalCamera::EQUAL_AREA_OCTAHEDRAL);
    if (mapping != "equalarea") {
      context.diagnostics.error(parameters.where(), concat("unknown mapping \"", mapping,
                                                           "\" of a spherical camera: expected equalarea or "
                                                           "equirectangular"));
    }
  }
  // It has neither lens nor screen.
  parameters.ignore({"lensradius", "focaldistance", "screenwindow", "frameaspectratio"});
}

}  // namespace

void write_camera(Context& context, Directive& camera, Directive& film) {
  v1::Camera& message = *context.scene.mutable_camera();
  if (camera.type == "perspective") {
    write_perspective(context, camera.parameters, message);
  } else if (camera.type == "orthographic") {
    write_orthographic(context, camera.parameters, message);
  } else if (camera.type == "spherical") {
    write_spherical(context, camera.parameters, message);
  } else if (camera.type == "realistic") {
    write_realistic_camera(context, camera, film);
  } else {
    context.diagnostics.error(camera.parameters.where(),
                              concat("unknown camera \"", camera.type,
                                     "\": expected perspective, orthographic, spherical or realistic"));
  }
}

}  // namespace tessera::client::pbrt
