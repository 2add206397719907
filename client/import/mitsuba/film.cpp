#include "import/mitsuba/film.h"

#include <algorithm>
#include <string>
#include <vector>

#include "base/nearest_name.h"
#include "import/input/concat.h"
#include "import/mitsuba/document/property_reader.h"
#include "import/mitsuba/sensitivities.h"
#include "wire/film_size.h"

namespace tessera::client::mitsuba {
namespace {

constexpr std::int64_t kMaxPixels = wire::kMaxFilmSide;

void write_filter(Context& context, Object* rfilter) {
  v1::PixelFilter& filter = *context.scene.mutable_film()->mutable_filter();
  const auto set = [&](v1::PixelFilter::Kind kind, double radius) {
    filter.set_kind(kind);
    filter.set_radius_x(static_cast<float>(radius));
    filter.set_radius_y(static_cast<float>(radius));
  };
  constexpr double kDefaultDeviation = 0.5;
  constexpr double kGaussianExtent = 4;  // standard deviations
  if (rfilter == nullptr) {
    set(v1::PixelFilter::GAUSSIAN, kGaussianExtent * kDefaultDeviation);
    filter.set_sigma(static_cast<float>(kDefaultDeviation));
    return;
  }
  PropertyReader reader(context, *rfilter);
  const std::string& type = rfilter->type;
  if (type == "box") {
    set(v1::PixelFilter::BOX, reader.number("radius", 0.5));
  } else if (type == "tent") {
    set(v1::PixelFilter::TRIANGLE, reader.number("radius", 1));
  } else if (type == "gaussian") {
    const double deviation = reader.number("stddev", kDefaultDeviation);
    set(v1::PixelFilter::GAUSSIAN, kGaussianExtent * deviation);
    filter.set_sigma(static_cast<float>(deviation));
  } else if (type == "mitchell" || type == "catmullrom") {
    const bool mitchell = type == "mitchell";
    set(v1::PixelFilter::MITCHELL, 2);
    filter.set_b(static_cast<float>(mitchell ? reader.number("B", reader.number("b", 1.0 / 3)) : 0));
    filter.set_c(static_cast<float>(mitchell ? reader.number("C", reader.number("c", 1.0 / 3)) : 0.5));
  } else if (type == "lanczos") {
    const double lobes = static_cast<double>(reader.integer("lobes", 3));
    set(v1::PixelFilter::LANCZOS, lobes);
    filter.set_tau(static_cast<float>(lobes));
  } else {
    reader.error(
        concat("rfilter \"", type,
               "\" is not supported: expected box, tent, gaussian, mitchell, catmullrom or lanczos"));
    return;
  }
  if (!(filter.radius_x() > 0)) reader.error(concat(rfilter->title(), ": its radius is not above 0"));
}

/// A size in pixels, as an integer parameter.
double read_pixels(PropertyReader& reader, std::string_view name, double fallback, double least,
                   double most) {
  const std::int64_t value = reader.integer(name, static_cast<std::int64_t>(fallback));
  if (static_cast<double>(value) >= least && static_cast<double>(value) <= most)
    return static_cast<double>(value);
  reader.error(*reader.find(name), concat("expected ", least, " to ", most, " pixels, found ", value));
  return fallback;
}

/// Pictures are of red, green and blue; what else there is in "alpha" and other channels is the command
/// line's.
void check_pixel_format(PropertyReader& film) {
  const std::string format = film.keyword("pixel_format", "rgb");
  if (format == "rgb" || format == "rgba" || film.object().type != "hdrfilm") return;
  const std::vector<std::string> known = {"rgb", "rgba", "luminance", "luminance_alpha", "xyz", "xyza"};
  const bool is_known = std::ranges::find(known, format) != known.end();
  film.diagnostics().warning(film.find("pixel_format")->where,
                             concat("pixel_format \"", format,
                                    "\" is not supported: the picture is of red, green and blue in Rec.709",
                                    is_known ? "" : base::did_you_mean(format, known)));
}

}  // namespace

FilmWindow write_film(Context& context, Object* film) {
  FilmWindow window;
  if (film == nullptr) {
    write_filter(context, nullptr);
  } else {
    PropertyReader reader(context, *film);
    if (film->type == "specfilm") {
      write_film_sensitivities(reader);
    } else if (film->type != "hdrfilm") {
      reader.warn(
          concat("film \"", film->type, "\" is not supported: an RGB image is made, as with hdrfilm"));
    }
    check_pixel_format(reader);
    window.width = read_pixels(reader, "width", window.width, 1, kMaxPixels);
    window.height = read_pixels(reader, "height", window.height, 1, kMaxPixels);
    window.crop_x = read_pixels(reader, "crop_offset_x", 0, 0, window.width - 1);
    window.crop_y = read_pixels(reader, "crop_offset_y", 0, 0, window.height - 1);
    const double most_x = window.width - window.crop_x, most_y = window.height - window.crop_y;
    window.crop_width = read_pixels(reader, "crop_width", most_x, 1, most_x);
    window.crop_height = read_pixels(reader, "crop_height", most_y, 1, most_y);
    write_filter(context, reader.child("rfilter"));
    // Files and their formats are the command line's.
    reader.ignore(
        {"file_format", "component_format", "banner", "compensate", "sample_border", "high_quality_edges"});
  }
  context.scene.mutable_film()->set_width(static_cast<std::uint32_t>(window.crop_width));
  context.scene.mutable_film()->set_height(static_cast<std::uint32_t>(window.crop_height));
  return window;
}

}  // namespace tessera::client::mitsuba
